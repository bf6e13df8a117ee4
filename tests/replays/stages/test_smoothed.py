"""Stage `smoothed`: any method by name, on every representation by the same numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import METHODS, LiveSmoother, smooth
from motorcade.replays.engine.graph import parse_knobs
from motorcade.replays.pipeline.job import pipeline_graph
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.stages.values.paths import FusedPath, FusedWith


def fused(
    seconds: float = 3.0,
    *,
    by: FusedWith = "nothing",
    lag_s: float = np.inf,
    stated: float = 1.0,
) -> FusedPath:
    """A noisy path, whose deviations are stated as so many times the true ones."""
    true = MOTIONS["handheld"].sampled(30.0, seconds).rigid
    path = Gaussian(0.005, 0.01).apply(true, np.random.default_rng(0))
    covariance = np.tile(stated**2 * np.diag([1e-4] * 3 + [2.5e-5] * 3), (len(path), 1, 1))
    accepted, nis = np.ones(len(path), bool), np.full(len(path), np.nan)
    return FusedPath(path, covariance, nis, accepted, by, "made", lag_s=lag_s)


@pytest.mark.parametrize("method", sorted(METHODS))
def test_every_method_of_the_library_is_within_reach(method: str) -> None:
    """What the stage gives is what the library gives, on each representation."""
    given = fused()
    made = smoothed(given, method=method, representations=("motor", "rotor"))
    assert made.method == method
    for name, path in made.trajectories.items():
        expected = smooth(given.trajectory, method, name, **made.parameters)
        np.testing.assert_array_equal(path.motors.coefficients, expected.motors.coefficients)


def test_numbers_of_a_method_come_by_name() -> None:
    knobs = parse_knobs(
        ["smoothed.method=one_euro", "smoothed.parameters=min_cutoff_hz=2, beta_per_m=0"],
        pipeline_graph(),
    )["smoothed"]
    made = smoothed(fused(), representations=("motor",), **knobs)
    assert made.parameters == {"min_cutoff_hz": 2.0, "beta_per_m": 0.0}
    expected = smooth(fused().trajectory, "one_euro", min_cutoff_hz=2.0, beta_per_m=0.0)
    ours = made.trajectories["motor"].motors.coefficients
    np.testing.assert_array_equal(ours, expected.motors.coefficients)
    assert smoothed(fused(), method="gaussian", parameters=("order=0",)).parameters == {"order": 0}


def test_by_default_auto_smooths() -> None:
    given = fused()
    made = smoothed(given, representations=("rotor", "motor"))
    assert (made.method, made.parameters) == ("auto", {})
    for name, path in made.trajectories.items():
        expected = smooth(given.trajectory, "auto", name)
        np.testing.assert_array_equal(path.motors.coefficients, expected.motors.coefficients)


@pytest.mark.parametrize("stated", [0.3, 10.0])
def test_a_path_stays_where_its_uncertainty_does_not_explain_what_is_taken_away(
    stated: float,
) -> None:
    """Less stated noise than is taken for it: motion; far more: errors that neighbours share."""
    given = fused(stated=stated)
    made = smoothed(given)
    assert made.method is None
    assert all(path is given.trajectory for path in made.trajectories.values())
    assert smoothed(given, method="auto").method == "auto"
    assert smoothed(given, parameters=("smoothness=-1",)).parameters == {"smoothness": -1.0}


@pytest.mark.parametrize("lag_s", [0.0, 0.1])
def test_a_causal_run_is_smoothed_with_no_more_lag_than_it_may_have(lag_s: float) -> None:
    given = replace(fused(10.0, lag_s=lag_s), held_out=fused().trajectory)
    made = smoothed(given)
    assert (made.method, made.parameters) == ("auto", {"lag_s": lag_s})
    expected = LiveSmoother(lag_s).smooth(given.trajectory).motors.coefficients
    for path in made.trajectories.values():
        np.testing.assert_array_equal(path.motors.coefficients, expected)
    assert made.held_out is not None
    # What comes later changes nothing.
    known = given.trajectory.time_ns <= 5 * 10**9 + round(1e9 * lag_s)
    cut = smoothed(
        replace(given, trajectory=given.trajectory[known], covariance=given.covariance[known])
    )
    before = int(np.count_nonzero(given.trajectory.time_ns <= 5 * 10**9 - 1))
    np.testing.assert_array_equal(
        cut.trajectories["motor"].motors.coefficients[:before], expected[:before]
    )


def test_what_a_filter_made_is_left_unless_smoothing_is_asked_for() -> None:
    for given in (fused(by="imu"), fused(by="odometry"), fused(by="imu", lag_s=0.0)):
        assert smoothed(given).method is None
        assert smoothed(given).trajectories["motor"] is given.trajectory
        assert smoothed(given, window_s=0.3).parameters == {"window_s": 0.3}
        assert smoothed(given, window_s=0.3).method == "local_polynomial"
        assert smoothed(given, order=3).parameters["order"] == 3
        assert smoothed(given, method="gaussian").method == "gaussian"
    assert smoothed(fused(0.3), method="auto").method is None
    assert smoothed(fused(0.3)).method is None


@pytest.mark.parametrize(
    ("knobs", "says"),
    [
        ({"method": "robustmap"}, "did you mean robust_map"),
        ({"method": "one_euro", "window_s": 0.3}, "expected none with one_euro"),
        ({"method": "gaussian", "order": 7}, "order"),
        ({"method": "one_euro", "order": 1}, "expected none with one_euro"),
        ({"method": "auto", "parameters": ("x=3",)}, "names of auto: smoothness"),
        ({"method": "one_euro", "parameters": ("beta=1",)}, "names of one_euro"),
        ({"method": "one_euro", "parameters": ("min_cutoff_hz",)}, "expected name=value"),
        ({"method": "one_euro", "parameters": ("min_cutoff_hz=fast",)}, "expected float"),
        ({"representations": ()}, "expected at least one"),
        ({"window_s": 0.0}, "window_s"),
    ],
)
def test_what_does_not_fit_is_named(knobs: dict, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        smoothed(fused(), **knobs)
