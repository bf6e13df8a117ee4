"""Stage `smoothed`: any method by name, on every representation by the same numbers."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import METHODS, smooth
from motorcade.replays.engine.knobs import parse_knobs
from motorcade.replays.pipeline import pipeline_graph
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.values.paths import FusedPath


def fused(seconds: float = 3.0, *, looked_ahead: bool = False) -> FusedPath:
    true = MOTIONS["handheld"].sampled(30.0, seconds).rigid
    path = Gaussian(0.005, 0.01).apply(true, np.random.default_rng(0))
    covariance = np.tile(np.diag([1e-4] * 3 + [2.5e-5] * 3), (len(path), 1, 1))
    accepted, nis = np.ones(len(path), bool), np.full(len(path), np.nan)
    return FusedPath(path, covariance, nis, accepted, "nothing", "left", looked_ahead)


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


def test_a_path_that_looked_ahead_is_left_unless_smoothing_is_asked_for() -> None:
    given = fused(looked_ahead=True)
    assert smoothed(given).method is None
    assert smoothed(given).trajectories["motor"] is given.trajectory
    assert smoothed(given, window_s=0.3).parameters == {"window_s": 0.3}
    assert smoothed(given, order=3).parameters["order"] == 3
    assert smoothed(given, method="gaussian").method == "gaussian"
    assert smoothed(fused(0.3), method="auto").method is None


@pytest.mark.parametrize(
    ("knobs", "says"),
    [
        ({"method": "robustmap"}, "did you mean robust_map"),
        ({"method": "one_euro", "window_s": 0.3}, "expected none with one_euro"),
        ({"method": "gaussian", "order": 7}, "order"),
        ({"method": "one_euro", "order": 1}, "expected none with one_euro"),
        ({"method": "auto", "parameters": ("x=3",)}, "auto takes no parameters"),
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
