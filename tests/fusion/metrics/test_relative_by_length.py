"""Relative errors by length are evo's and KITTI's."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from motorcade.fusion.metrics import (
    Delta,
    NotObservableError,
    drift_by_length,
    evaluate,
    relative_errors,
)
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.ga import Motor, Rotor, Trajectory


@pytest.fixture
def pair(rng):
    truth = MOTIONS["walk_and_look"].sampled(30.0, 20.0)
    return Gaussian(0.01, 0.01).apply(truth, rng), truth


@pytest.mark.parametrize("length_m", [0.05, 1.0, 7.3])
def test_errors_by_length_are_evos(pair, length_m):
    evo_metrics = pytest.importorskip("evo.core.metrics")
    from evo.core.trajectory import PoseTrajectory3D

    def of_evo(trajectory):
        wxyz, position_m = trajectory.poses.as_quaternion_translation()
        return PoseTrajectory3D(position_m, wxyz, timestamps=trajectory.time_s)

    estimate, truth = pair
    metres, radians = relative_errors(estimate.motors, truth.motors, Delta(length_m, "m"))
    for ours, relation in [
        (metres, evo_metrics.PoseRelation.translation_part),
        (np.rad2deg(radians), evo_metrics.PoseRelation.rotation_angle_deg),
    ]:
        theirs = evo_metrics.RPE(
            relation, length_m, evo_metrics.Unit.meters, pairs_from_reference=True
        )
        theirs.process_data((of_evo(truth), of_evo(estimate)))
        np.testing.assert_allclose(ours, theirs.error, rtol=0, atol=1e-6)
        assert len(ours) > 2


def kitti(estimate, truth, length_m, every):
    """The development kit's loops, on matrices."""
    ours, true = estimate.as_matrix(), truth.as_matrix()
    along = [0.0]
    for before, after in pairwise(true):
        along.append(along[-1] + float(np.linalg.norm(before[:3, 3] - after[:3, 3])))
    found = []
    for first in range(0, len(true), every):
        last = next((i for i in range(first, len(true)) if along[i] > along[first] + length_m), -1)
        if last == -1:
            continue
        true_step = np.linalg.inv(true[first]) @ true[last]
        error = np.linalg.inv(np.linalg.inv(ours[first]) @ ours[last]) @ true_step
        cosine = np.clip(0.5 * (np.trace(error[:3, :3]) - 1.0), -1.0, 1.0)
        found.append((np.linalg.norm(error[:3, 3]) / length_m, np.arccos(cosine) / length_m))
    return np.mean(found, axis=0), len(found)


def test_drift_is_the_development_kits(pair):
    estimate, truth = (trajectory.motors for trajectory in pair)
    found = drift_by_length(estimate, truth, (2.0, 1000.0, 5.0), every=7)
    assert [drift.length_m for drift in found] == [2.0, 5.0]
    for drift in found:
        (translation, rotation), count = kitti(estimate, truth, drift.length_m, 7)
        assert drift.count == count > 10
        assert drift.translation == pytest.approx(translation, rel=1e-9)
        assert drift.rotation_rad_m == pytest.approx(rotation, rel=1e-6)


def test_a_wrong_scale_drifts_by_its_excess():
    metres = np.arange(0.0, 1000.0, 1.0)[:, None] * [1.0, 0.0, 0.0]
    truth, estimate = (
        Motor.from_rotor_translation(Rotor.identity((1000,)), s * metres) for s in (1.0, 1.01)
    )
    # Each sub-sequence ends one pose after its length.
    for drift in drift_by_length(estimate, truth):
        expected = 0.01 * (drift.length_m + 1) / drift.length_m
        assert drift.translation == pytest.approx(expected, rel=1e-9)
        assert drift.rotation_rad_m < 1e-9


def test_evaluate_reports_the_length_it_was_given(pair):
    found = evaluate(*pair, rpe_length_m=3.0)
    metres, radians = relative_errors(pair[0].motors, pair[1].motors, Delta(3.0, "m"))
    flat = found.as_dict()
    assert flat["rpe_length_m"] == 3.0
    assert flat["rpe_by_length_trans_max_m"] == pytest.approx(metres.max())
    assert flat["rpe_by_length_rot_mean_deg"] == pytest.approx(np.rad2deg(radians.mean()))
    assert evaluate(*pair, rpe_length_m=1e4).rpe_by_length_trans_m is None


def test_lengths_and_starts_are_kittis_unless_said_otherwise():
    """Its development kit: 100, 200, …, 800 m, from every tenth frame on."""
    metres = np.arange(0.0, 900.0, 1.0)[:, None] * [1.0, 0.0, 0.0]
    path = Motor.from_rotor_translation(Rotor.identity((900,)), metres)
    found = drift_by_length(path, path)
    assert [drift.length_m for drift in found] == [100.0 * k for k in range(1, 9)]
    # From 0, 10, … the last pose but one can be reached: 900 - length - 1 of them, by tens.
    assert [drift.count for drift in found] == [80, 70, 60, 50, 40, 30, 20, 10]
    assert drift_by_length(path, path, (100.0,), every=1)[0].count == 799


@pytest.mark.parametrize("bad", [-1.0, 0.0, np.inf, np.nan])
def test_lengths_are_numbers_above_zero(pair, bad):
    for refused in (
        lambda: relative_errors(pair[0].motors, pair[1].motors, Delta(bad, "m")),
        lambda: drift_by_length(pair[0].motors, pair[1].motors, (bad,)),
    ):
        with pytest.raises(ValueError, match=r"(length_m|delta): expected (a number )?above 0"):
            refused()


def test_a_segment_ends_when_its_length_is_reached():
    """Steps of 1 m and segments of 2: at every second pose, and the odd one is left out."""
    along = np.arange(6.0)[:, None] * [0.0, 1.0, 0.0]
    truth = Motor.from_rotor_translation(Rotor.identity((6,)), along)
    estimate = Motor.from_rotor_translation(Rotor.identity((6,)), along * 1.5)
    metres, radians = relative_errors(estimate, truth, Delta(2.0, "m"))
    np.testing.assert_allclose(metres, [1.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(radians, [0.0, 0.0], atol=1e-12)
    with pytest.raises(NotObservableError, match="poses 6 m apart, got none among 6"):
        relative_errors(estimate, truth, Delta(6.0, "m"))
    with pytest.raises(NotObservableError, match=r"one of \(6.0, 7.0\) m, got 5 m"):
        drift_by_length(estimate, truth, (6.0, 7.0))


def test_short_lengths_are_steps(pair):
    steps = relative_errors(pair[0].motors, pair[1].motors)
    short = relative_errors(pair[0].motors, pair[1].motors, Delta(1e-6, "m"))
    for one, other in zip(steps, short, strict=True):
        np.testing.assert_array_equal(one, other)


def test_refusals(pair):
    motors = pair[0].motors
    with pytest.raises(ValueError, match="delta: expected above 0 m, got 0"):
        relative_errors(motors, motors, Delta(0.0, "m"))
    with pytest.raises(NotObservableError, match="poses 1000 m apart, got none"):
        relative_errors(motors, motors, Delta(1000.0, "m"))
    with pytest.raises(NotObservableError, match="a path longer than one of"):
        drift_by_length(motors, motors)
    with pytest.raises(ValueError, match="every: expected 1 or more, got 0"):
        drift_by_length(motors, motors, every=0)
    similar = Trajectory(np.arange(5), MOTIONS["zoom"].at(np.arange(5.0)).pose)
    with pytest.raises(ValueError, match="expected rigid poses"):
        _ = similar.motors
