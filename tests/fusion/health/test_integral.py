"""A running integral, of every sample's sum or of one in eight, beside scipy's trapezoids."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from motorcade.fusion.health import gyroscope
from motorcade.fusion.health.gyroscope import RunningIntegral
from motorcade.ga.arrays import FloatArray, IntArray


def _readings(count: int) -> tuple[IntArray, FloatArray]:
    rng = np.random.default_rng(count)
    stamps = np.cumsum(rng.integers(4_000_000, 6_000_000, count))
    return stamps, rng.normal(size=(count, 3))


@pytest.mark.parametrize("count", [2, 8, 9, 500])
@pytest.mark.parametrize("all_kept", [True, False])
def test_it_is_the_trapezoids_sum_and_a_line_between_samples(
    count: int, all_kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    stamps, values = _readings(count)
    if not all_kept:
        monkeypatch.setattr(gyroscope, "_ALL_KEPT", 1)
    monkeypatch.setattr(gyroscope, "_BLOCK", 64)
    seconds = (stamps - stamps[0]) * 1e-9
    sums = cumulative_trapezoid(values, seconds, axis=0, initial=0.0)
    found = RunningIntegral(stamps, values)
    assert np.allclose(found.at(stamps), sums, rtol=0.0, atol=1e-12)
    wanted = np.random.default_rng(1).integers(stamps[0] - 10**8, stamps[-1] + 10**8, 300)
    at_s = (wanted - stamps[0]) * 1e-9
    lines = np.stack([np.interp(at_s, seconds, column) for column in sums.T], axis=-1)
    assert np.allclose(found.at(wanted), lines, rtol=0.0, atol=1e-12)


def test_nothing_asked_for_is_nothing_told() -> None:
    assert RunningIntegral(*_readings(5)).at(np.zeros(0, dtype=np.int64)).shape == (0, 3)


def test_sums_between_those_kept_are_the_same_to_the_last_bit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stamps, values = _readings(300)
    each = RunningIntegral(stamps, values).at(stamps)
    monkeypatch.setattr(gyroscope, "_ALL_KEPT", 1)
    monkeypatch.setattr(gyroscope, "_BLOCK", 64)
    assert np.array_equal(RunningIntegral(stamps, values).at(stamps), each)
