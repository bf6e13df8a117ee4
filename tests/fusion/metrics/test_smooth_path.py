"""The interpolated reference: what it passes through, where it covers, and where it does not."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from motorcade.fusion.metrics import NotObservableError, evaluate
from motorcade.fusion.metrics.smooth_path import SmoothPath
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor, Trajectory

START_NS = 10**18
MS = 1_000_000


def standing(*stamps_ms: int) -> Trajectory:
    stamps = START_NS + np.array(stamps_ms, dtype=np.int64) * MS
    return Trajectory(stamps, Motor.identity((len(stamps_ms),)))


def test_it_passes_through_every_pose_and_is_a_cubic_spline_between():
    truth = MOTIONS["handheld"].sampled(20.0, 5.0, start_ns=START_NS)
    path = SmoothPath(truth)
    assert path.origin_ns == START_NS
    assert path.span_s == (0.0, pytest.approx(5.0))
    at = path.poses(path.seconds(truth.time_ns))
    np.testing.assert_allclose(at.as_matrix(), truth.motors.as_matrix(), atol=1e-12)
    between = truth.time_s[:-1] + 0.02
    spline = CubicSpline(truth.time_s, truth.motors.translation_m)
    np.testing.assert_allclose(path.positions_m(between), spline(between), atol=1e-14)
    exact = MOTIONS["handheld"].at(between).pose
    assert np.max((path.poses(between).rotor.inverse() @ exact.rotor).angle()) < 1e-3


def test_seconds_are_after_the_first_stamp_also_for_stamps_before_it():
    path = SmoothPath(standing(0, 100))
    given = START_NS + np.array([-250, 0, 100, 150]) * MS
    np.testing.assert_allclose(path.seconds(given), [-0.25, 0.0, 0.1, 0.15], rtol=1e-15)


def test_a_gap_of_three_intervals_is_covered_and_a_longer_one_is_not():
    path = SmoothPath(standing(0, 100, 200, 300, 400, 700, 800, 1110, 1200))
    seconds = np.array([-1e-9, 0.0, 0.1, 0.55, 0.699, 0.7, 0.799, 0.8, 0.9, 1.109, 1.11, 1.2])
    seconds = np.append(seconds, 1.2 + 1e-9)
    expected = [False, *[True] * 6, False, False, False, True, True, False]
    assert path.covers(seconds).tolist() == expected


def test_gaps_at_both_ends_are_gaps_too():
    path = SmoothPath(standing(0, 400, 500, 600, 700, 1100))
    seconds = np.array([0.0, 0.2, 0.399, 0.401, 0.45, 0.699, 0.701, 0.9, 1.1])
    assert path.covers(seconds).tolist() == [*[False] * 3, *[True] * 3, *[False] * 3]


def test_two_poses_are_a_path_and_one_is_none():
    assert SmoothPath(standing(0, 100)).covers(np.array([0.05])).tolist() == [True]
    with pytest.raises(NotObservableError, match="reference: expected 2 or more poses, got 1"):
        SmoothPath(standing(0))
    one = standing(0)
    assert evaluate(one, one).jitter is None


def test_it_is_fitted_once_and_forgotten_with_its_trajectory():
    truth = standing(0, 100, 200)
    fitted = weakref.ref(SmoothPath.through(truth))
    assert SmoothPath.through(truth) is fitted()
    assert SmoothPath.through(standing(0, 100, 200)) is not fitted()
    del truth
    gc.collect()
    assert fitted() is None


def test_steps_too_uneven_for_a_spline_of_rotations_are_told() -> None:
    t = 0.05 * np.arange(5)
    turn = np.stack([0.3 * np.sin(2 * t), 0.2 * np.cos(t), 0.4 * np.sin(t)], axis=-1)
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), np.zeros(3))
    stamps = np.array([0, 10**6, 2 * 10**6, 86_400 * 10**9, 2 * 86_400 * 10**9])
    with pytest.raises(NotObservableError, match="expected stamps near enough to even"):
        SmoothPath(Trajectory(stamps, poses))
