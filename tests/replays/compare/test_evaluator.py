"""Measuring many paths at once gives what the metrics give one by one."""

import numpy as np
import pytest

from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Trajectory
from motorcade.replays.comparison.evaluator import METRICS, PathEvaluator, RecordedTruth
from motorcade.replays.comparison.plan import DegradedMotion, Setting

SETTINGS = (
    Setting("one_euro", "motor"),
    Setting("gaussian", "euler"),
    Setting("exponential", "quaternion", (("cutoff_hz", 1.0),)),
)
# A sub-sample's lag, where steps are uneven, and what lies between the splines' knots.
TOLERANCE = {"lag_ms": 1e-2, "angular_rate_lag_ms": 3e-2}
DURATION_S = 8.0


def paths_of(motion: str, degradation: str) -> tuple[list[Trajectory], PathEvaluator]:
    degraded, evaluator = DegradedMotion(motion, degradation, 7, 30.0, DURATION_S).drawn()
    return [degraded, *(setting.smooth(degraded) for setting in SETTINGS)], evaluator


def one_by_one(path: Trajectory, truth: Trajectory) -> list[float]:
    found = evaluate(path, truth, max_difference_s=1.0).as_dict()
    told = [found[metric] for metric in METRICS]
    return [np.nan if value is None else float(value) for value in told]


@pytest.mark.parametrize("motion", ["gimbal_crossing", "stop_and_go", "fast_spin", "screw", "zoom"])
def test_every_figure_is_the_metric_s_own(motion: str) -> None:
    paths, evaluator = paths_of(motion, "gaussian")
    truth = MOTIONS[motion].sampled(150.0, DURATION_S + 2.0, start_ns=-(10**9), start_s=-1.0)
    expected = np.array([one_by_one(path, truth) for path in paths])
    for column, metric in enumerate(METRICS):
        np.testing.assert_allclose(
            evaluator.measure(paths)[:, column],
            expected[:, column],
            rtol=2e-4,
            atol=TOLERANCE.get(metric, 2e-4),
            err_msg=metric,
        )


@pytest.mark.parametrize("degradation", ["dropped_frames", "latency", "stamp_jitter"])
def test_uneven_stamps_are_measured_alike(degradation: str) -> None:
    # Errors are left out: `evaluate` pairs stamps, here the ground truth is known at every one.
    paths, evaluator = paths_of("walk_and_look", degradation)
    truth = MOTIONS["walk_and_look"].sampled(
        150.0, DURATION_S + 2.0, start_ns=-(10**9), start_s=-1.0
    )
    expected = np.array([one_by_one(path, truth) for path in paths])
    for metric in METRICS[2:]:
        column = METRICS.index(metric)
        np.testing.assert_allclose(
            evaluator.measure(paths)[:, column],
            expected[:, column],
            rtol=2e-4,
            atol=TOLERANCE.get(metric, 2e-4),
            err_msg=metric,
        )


def test_a_late_copy_of_the_truth_is_exactly_so_late() -> None:
    _, evaluator = DegradedMotion("handheld", "gaussian", 1, 30.0, DURATION_S).drawn()
    late = MOTIONS["handheld"].sampled(30.0, DURATION_S, start_s=-0.0437)
    found = dict(zip(METRICS, evaluator.measure([late])[0], strict=True))
    assert found["lag_ms"] == pytest.approx(43.7, abs=2e-3)
    assert found["angular_rate_lag_ms"] == pytest.approx(43.7, abs=2e-3)


def test_a_recorded_truth_measures_as_the_formula_does() -> None:
    paths, evaluator = paths_of("walk_and_look", "gaussian")
    dense = MOTIONS["walk_and_look"].sampled(
        200.0, DURATION_S + 2.0, start_ns=-(10**9), start_s=-1.0
    )
    recorded = PathEvaluator(paths[0].time_ns, RecordedTruth(dense))
    np.testing.assert_allclose(
        recorded.measure(paths), evaluator.measure(paths), rtol=1e-4, atol=2e-3
    )
