"""The checkerboard recording by its board: accuracy and jitter, causal and with look-ahead."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from tests.bench.tracking.board_smoothing import (
    CAUSAL,
    bench_board,
    board_table,
    position_jitter_m,
)


def test_jitter_is_that_of_the_noise_and_not_of_even_motion(rng: np.random.Generator) -> None:
    """Second differences of white noise scatter by the root of six; those of a parabola do not."""
    time_s = np.arange(5000) / 30.0
    noise_m = 1e-3 * rng.standard_normal((5000, 3))
    even = np.outer(time_s**2, [1e-3, -2e-3, 5e-4]) + np.outer(time_s, [0.1, 0.2, 0.3])
    stamps = np.arange(5000, dtype=np.int64) * 33_333_333
    for places, jitter in ((even, 0.0), (even + noise_m, 1e-3 * np.sqrt(6.0))):
        path = Trajectory(stamps, Motor.from_translation(places))
        assert position_jitter_m(path) == pytest.approx(jitter, rel=0.03, abs=1e-8)


def test_the_causal_smoother_knows_the_past_alone(rng: np.random.Generator) -> None:
    from motorcade.fusion.smoothing import smooth

    stamps = np.arange(60, dtype=np.int64) * 33_333_333
    path = Trajectory(stamps, Motor.from_translation(0.01 * rng.standard_normal((60, 3))))
    method, parameters = CAUSAL
    whole, start = (smooth(one, method, **parameters) for one in (path, path[:40]))
    np.testing.assert_array_equal(whole.motors[:40].coefficients, start.motors.coefficients)


@pytest.mark.slow
def test_the_checkerboard_recording_is_held_to_its_figures(data_dir: Path) -> None:
    rows = bench_board(data_dir / "replays" / "vamr_board")
    plain, causal, offline = rows
    assert [row["poses"] for row in rows] == [250, 250, 250]
    assert all(row["ape_rmse_m"] <= 0.60e-3 for row in rows)
    assert all(row["rotation_rmse_deg"] <= 0.22 for row in rows)
    assert plain["position_jitter_m"] <= 0.42e-3
    assert causal["position_jitter_m"] <= 0.38e-3
    assert offline["position_jitter_m"] <= 0.30e-3
    assert "offline: local_polynomial" in board_table(rows)
