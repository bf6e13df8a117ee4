"""Splines of single columns: scipy's own, and what each value would be without itself."""

import math

import numpy as np
import pytest

from motorcade.fusion.smoothing import REPRESENTATIONS
from motorcade.fusion.smoothing.batch.columns import (
    NO_JUMPS,
    ColumnModel,
    ColumnSegment,
    chosen,
    splined,
)
from motorcade.fusion.smoothing.batch.per_axis import (
    AxisModels,
    Measured,
    chosen_models,
    smoothed_per_axis,
)
from motorcade.fusion.smoothing.batch.start import even_stamps
from motorcade.fusion.smoothing.native import _columns
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray


def column(rng: np.random.Generator, noise: float) -> tuple[FloatArray, FloatArray]:
    time_s = np.cumsum(rng.uniform(0.5, 1.5, 200)) / 20.0
    return time_s, np.sin(2.0 * time_s) + noise * rng.standard_normal(200)


def test_the_spline_is_scipys(rng: np.random.Generator) -> None:
    interpolate = pytest.importorskip("scipy.interpolate")
    time_s, values = column(rng, 0.05)
    found = splined(time_s, values, np.ones(200), 1, 5.0)
    theirs = interpolate.make_smoothing_spline(time_s, values, lam=5.0**-2)
    np.testing.assert_allclose(found.values, theirs(time_s), atol=2e-4)  # its prior, wide as it is
    np.testing.assert_allclose(found.values[20:-20], theirs(time_s)[20:-20], atol=1e-6)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
@pytest.mark.parametrize("row", [60, 90, 199])
def test_residuals_are_from_what_the_other_values_make(
    order: int, row: int, rng: np.random.Generator
) -> None:
    time_s, values = column(rng, 0.05)
    weights = rng.uniform(0.5, 2.0, 200)
    weights[40:50] = 0.0
    whole = splined(time_s, values, weights, order, 20.0)
    weights[row] = 0.0
    without = splined(time_s, values, weights, order, 20.0)
    assert whole.left_out[row] == pytest.approx(values[row] - without.values[row], rel=1e-8)
    assert whole.left_out[row] == pytest.approx(without.left_out[row], rel=1e-8)
    assert whole.variance[row] == pytest.approx(without.variance[row], rel=1e-8)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_rows_before_the_first_that_is_measured_are_as_those_behind_the_last(
    order: int, rng: np.random.Generator
) -> None:
    time_s, values = column(rng, 0.05)
    weights = rng.uniform(0.5, 2.0, 200)
    weights[:80] = 0.0
    found = splined(time_s, values, weights, order, 20.0)
    turned = splined(-time_s[::-1], values[::-1], weights[::-1].copy(), order, 20.0)
    for one, other in zip(vars(found).values(), vars(turned).values(), strict=True):
        np.testing.assert_allclose(one[:80], other[199:119:-1], rtol=1e-9)


def test_shocks_are_what_a_jump_of_the_value_or_of_its_slope_saves(
    rng: np.random.Generator,
) -> None:
    time_s, values = column(rng, 0.05)
    values[120:] += 0.4
    shocks = np.empty((200, 1, 2))
    whole = splined(time_s, values, np.ones(200), 2, 20.0, shocks=shocks)
    assert np.argmax(np.abs(shocks[:, 0, 0])) == 120
    jumps = np.array([120])
    jumped = splined(time_s, values, np.ones(200), 2, 20.0, jumps)
    given = time_s, values[:, None], np.ones(200)
    out = np.empty((200, 1)), np.empty((200, 1)), np.empty(200), np.empty(200)
    squares = [_columns.spline(*given, one, 2, 20.0, 0.0, out)[1][0] for one in (NO_JUMPS, jumps)]
    assert squares[0] - squares[1] == pytest.approx(shocks[120, 0, 0] ** 2, rel=1e-4)
    assert np.ptp(jumped.values[119:121]) == pytest.approx(0.4, abs=0.2)
    assert np.ptp(whole.values[119:121]) < 0.2


@pytest.mark.parametrize("noise", [1e-3, 0.03, 0.3])
def test_noise_is_told_from_motion(noise: float, rng: np.random.Generator) -> None:
    time_s, values = column(rng, noise)
    [(model, *_)] = chosen([ColumnSegment(time_s, values[:, None], np.ones(200))])
    assert model.noise == pytest.approx(noise, rel=0.2)
    smoothed = splined(time_s, values, np.ones(200), model.order, model.ratio).values
    truth = np.sin(2.0 * time_s)
    assert np.std(smoothed - truth) < 0.75 * np.std(values - truth)


def test_density_is_of_the_process() -> None:
    assert ColumnModel(order=1, ratio=4.0, noise=0.5).density == 2.0


@pytest.mark.parametrize("order", [1, 2, 3])
def test_errors_with_a_memory_are_taken_off_as_dense_matrices_do(
    order: int, rng: np.random.Generator
) -> None:
    """Beside the conditional mean and variance of a Gaussian process with a flat polynomial."""
    time_s, values = column(rng, 0.05)
    time_s, values, weights, memory_s, ratio = time_s[:60], values[:60], np.ones(60), 0.2, 20.0
    weights[20:23] = 0.0
    found = splined(time_s, values, weights, order, ratio, memory_s=memory_s)
    shared, apart = np.minimum.outer(time_s, time_s), np.abs(np.subtract.outer(time_s, time_s))
    nodes, scale = np.polynomial.legendre.leggauss(order + 1)
    place = 0.5 * shared[..., None] * (nodes + 1.0)
    power = (place * (place + apart[..., None])) ** order
    motion = ratio**2 * 0.5 * shared * (power @ scale) / float(math.factorial(order)) ** 2
    polynomials = np.polynomial.polynomial.polyvander(time_s, order)
    motion += 1e8 * polynomials @ polynomials.T
    used = weights > 0.0
    total = (motion + np.exp(-apart / memory_s) + 1e-6 * np.eye(60))[np.ix_(used, used)]
    gain = np.linalg.solve(total, motion[used]).T
    np.testing.assert_allclose(found.values, gain @ values[used], atol=1e-4)
    spread = np.diag(motion - gain @ motion[used])
    np.testing.assert_allclose(found.spread, spread, rtol=0.02)
    precision = np.linalg.inv(total)
    off = (precision @ values[used]) / np.diag(precision)
    np.testing.assert_allclose(found.left_out[used], off, atol=1e-4)
    np.testing.assert_allclose(1.0 + found.variance[used], 1.0 / np.diag(precision), rtol=1e-3)


def test_an_axis_that_goes_through_its_values_leaves_no_pose_out(rng: np.random.Generator) -> None:
    """It cannot say whether a pose is right that did not count; the others can, and it counts."""
    rotor = REPRESENTATIONS["rotor"]
    path = rotor.coordinates(Motor.identity((200,)))
    noise = 0.01 * rng.standard_normal((200, 6)) * ([0.0] * 3 + [1.0] * 3)
    measured = Measured(
        rotor, np.arange(200) / 20.0, rotor.retract(path, noise), NO_JUMPS, np.ones(200, np.bool_)
    )
    exact, stiff = ColumnModel(2, 1e6, 1e-6), ColumnModel(2, 1.0, 0.01)
    weights = np.ones(200)
    weights[90] = 0.0
    models = AxisModels((exact,) * 3 + (stiff,) * 3, 0.0)
    found = smoothed_per_axis(measured, path, weights, models, 6.0, 2)
    assert found.weights[90] > 0.3


def test_rows_that_only_open_the_state_tell_no_model(rng: np.random.Generator) -> None:
    time_s, values = column(rng, 0.1)
    weights = np.zeros(200)
    weights[:4] = 1.0
    [(model, score, *_)] = chosen([ColumnSegment(time_s, values[:, None], weights)], (3,))
    assert model.order == 3
    assert np.isfinite(score)


@pytest.mark.parametrize("first", [0, 4900])
def test_runs_left_out_of_long_paths_tell_nothing_of_the_models(
    first: int, rng: np.random.Generator
) -> None:
    noise, weights = 0.01 * rng.standard_normal((6000, 6)), np.ones(6000)
    weights[first : first + 1100] = 0.0
    rotor = REPRESENTATIONS["rotor"]
    path = rotor.coordinates(Motor.identity((6000,)))
    measured = Measured(
        rotor, np.arange(6000) / 30.0, rotor.retract(path, noise), NO_JUMPS, weights > 0.0
    )
    found = chosen_models(measured, path, weights, (1,))
    assert [one.noise for one in found.columns] == pytest.approx([0.01] * 6, rel=0.05)


def test_even_stamps_are_not_sought_over_long_gaps(rng: np.random.Generator) -> None:
    time_s = np.arange(1000) / 30.0 + rng.uniform(-0.003, 0.003, 1000)
    assert even_stamps(time_s) is not None
    time_s[250:] += 1e9
    assert even_stamps(time_s) is None


def test_refused_are_too_few_values(rng: np.random.Generator) -> None:
    time_s, values = column(rng, 0.1)
    weights = np.zeros(200)
    weights[:2] = 1.0
    with pytest.raises(ValueError, match="more values than derivatives"):
        splined(time_s, values, weights, 2, 1.0)


@pytest.mark.parametrize("seed", [0, 1])
def test_motion_that_stamps_do_not_resolve_is_left(seed: int) -> None:
    """A car's body shakes at 8 Hz: at 10 Hz that is folded back, and looks like noise."""
    rng = np.random.default_rng(seed)
    time_s, rates_hz = np.arange(1000) / 10.0, np.arange(0.05, 8.0, 0.0137)
    sizes = np.minimum(1.0, 0.5 / rates_hz) ** 1.5 * rng.standard_normal(len(rates_hz))
    phases = rng.uniform(0.0, 2.0 * np.pi, len(rates_hz))
    motion = np.sin(2.0 * np.pi * time_s[:, None] * rates_hz + phases) @ sizes
    [(model, *_)] = chosen([ColumnSegment(time_s, motion[:, None], np.ones(1000))])
    model = model.told(0.1)
    left = splined(time_s, motion, np.ones(1000), model.order, model.ratio).values
    assert np.std(left - motion) < 0.002 * np.std(motion)
