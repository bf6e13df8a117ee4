"""Pairs, their alignment and the statistics over them, against evo and at their bounds."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.metrics import (
    absolute_translation_m,
    align,
    alignment_of,
    associate,
    evaluate,
    relative_errors,
)
from motorcade.fusion.metrics.poses.alignment import Alignment, Pairs
from motorcade.fusion.metrics.poses.pose_error import Statistics
from motorcade.ga import Motor, Rotor, Trajectory

MS = 1_000_000


def at(*stamps_ms: float) -> Trajectory:
    """Poses at these milliseconds, each as many metres along x as its index."""
    stamps = np.round(np.array(stamps_ms) * MS).astype(np.int64)
    return Trajectory(stamps, placed(np.arange(len(stamps))[:, None] * [1.0, 0.0, 0.0]))


def placed(positions_m: np.ndarray) -> Motor:
    return Motor.from_translation(positions_m)


def pairs_of(estimate_m: np.ndarray, reference_m: np.ndarray) -> Pairs:
    index = np.arange(len(estimate_m))
    return Pairs(index * MS, placed(estimate_m), placed(reference_m), index, index)


def test_a_stamp_as_far_as_allowed_is_paired_and_one_farther_is_not():
    estimate = at(1000, 2000, 3000, 4000)
    reference = at(0, 1005, 1996, 2994, 4006, 9000)
    pairs = associate(estimate, reference, 0.005)
    assert pairs.estimate_index.tolist() == [0, 1]
    assert pairs.reference_index.tolist() == [1, 2]
    np.testing.assert_array_equal(pairs.time_ns, estimate.time_ns[:2])
    np.testing.assert_array_equal(pairs.reference.translation_m[:, 0], [1.0, 2.0])
    exact = associate(at(1000, 2000, 2999), at(1000, 1999, 2500, 2999), 0.0)
    assert (exact.estimate_index.tolist(), exact.reference_index.tolist()) == ([0, 2], [0, 3])


def test_ten_milliseconds_are_allowed_unless_said_otherwise():
    assert len(associate(at(0, 2000), at(10, 2011))) == 1
    assert evaluate(at(0, 2000), at(10, 2011)).pairs == 1


def test_equally_long_trajectories_are_led_by_the_estimate():
    """Both poses of the estimate are nearest to one of the reference, which then serves twice."""
    pairs = associate(at(1000, 1004), at(1002, 3000))
    assert pairs.estimate_index.tolist() == [0, 1]
    assert pairs.reference_index.tolist() == [0, 0]


@pytest.mark.parametrize("bad", [-1e-9, np.inf, np.nan])
def test_a_distance_between_stamps_is_a_number_from_zero_on(bad):
    with pytest.raises(ValueError, match="max_difference_s: expected 0 or more, got"):
        associate(at(0, 1), at(0, 1), bad)


def test_where_nothing_can_be_paired_both_spans_are_told():
    with pytest.raises(ValueError, match=r"estimate spans 1000000 to 2000000 ns, the reference "):
        associate(at(1, 2), at(500, 600, 700))


def test_alignment_is_evos_of_any_two_patterns_also_mirrored_ones(rng):
    """Of mirrored points no rotation fits; the best one is still a rotation."""
    geometry = pytest.importorskip("evo.core.geometry")
    for mirror in (1.0, -1.0):
        for scale in (1.0, 0.3):
            source = rng.standard_normal((12, 3)) * [1.0, 2.0, 3.0]
            turn = Rotor.random(rng).as_matrix()
            target = scale * source * [1.0, 1.0, mirror] @ turn.T + rng.standard_normal(3)
            target += 0.05 * rng.standard_normal(target.shape)
            pairs = pairs_of(source, target)
            for with_scale, how in ((False, "se3"), (True, "sim3")):
                found = align(pairs, with_scale)
                rotation, shift, size = geometry.umeyama_alignment(source.T, target.T, with_scale)
                np.testing.assert_allclose(found.rotor.as_matrix(), rotation, atol=1e-12)
                np.testing.assert_allclose(found.translation_m, shift, atol=1e-12)
                assert found.scale == pytest.approx(size, rel=1e-12)
                named = alignment_of(pairs, how)
                np.testing.assert_array_equal(named.translation_m, found.translation_m)


def test_three_points_align_and_a_nearly_straight_path_does_too(rng):
    corner = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    turn = Rotor.random(rng)
    found = align(pairs_of(corner, turn.apply(corner)), with_scale=False)
    np.testing.assert_allclose(found.rotor.as_matrix(), turn.as_matrix(), atol=1e-12)
    # A metre along, 10 µm across: far from a line.
    slim = np.stack([np.linspace(0, 1, 9), 1e-5 * np.arange(9) ** 2, np.zeros(9)], axis=-1)
    found = align(pairs_of(slim, turn.apply(slim)), with_scale=True)
    np.testing.assert_allclose(found.rotor.as_matrix(), turn.as_matrix(), atol=1e-5)
    for across in (1e-9, 0.0):
        line = slim * [1e3, across, 0.0]
        with pytest.raises(
            ValueError, match=r"lie on one line, got singular .*use align='origin' or 'none'"
        ):
            align(pairs_of(line, line), with_scale=False)


def test_points_that_hardly_differ_are_no_path():
    small = 1e-9 * np.eye(3)
    with pytest.raises(ValueError, match="expected positions that do not lie on one line"):
        align(pairs_of(small, small), with_scale=False)


def test_alignments_act_on_poses_and_trajectories(rng):
    turn, shift = Rotor.random(rng), rng.standard_normal(3)
    poses = Motor.random(rng, (5,))
    moved = Alignment(turn, shift, 2.0).apply(poses)
    np.testing.assert_allclose(
        moved.translation_m, 2.0 * poses.translation_m @ turn.as_matrix().T + shift, atol=1e-12
    )
    np.testing.assert_allclose(
        moved.rotor.as_matrix(), turn.as_matrix() @ poses.rotor.as_matrix(), atol=1e-12
    )
    path = Trajectory(np.arange(5), poses, "room", "eye")
    after = Alignment(turn, shift, 2.0).apply_to(path)
    np.testing.assert_array_equal(after.motors.coefficients, moved.coefficients)
    assert (after.parent, after.child) == ("room", "eye")
    same = Alignment.identity().apply(poses)
    np.testing.assert_allclose(same.coefficients, poses.coefficients, atol=1e-15)


def test_distances_keep_the_batch(rng):
    ours, true = Motor.random(rng, (2, 7)), Motor.random(rng, (2, 7))
    expected = np.sqrt(np.sum((ours.translation_m - true.translation_m) ** 2, axis=-1))
    np.testing.assert_allclose(absolute_translation_m(ours, true), expected, rtol=1e-14)


def test_statistics_are_evos(rng):
    metrics = pytest.importorskip("evo.core.metrics")
    errors = np.abs(rng.standard_normal(101))
    theirs = metrics.APE()
    theirs.error = errors
    ours = Statistics.of(errors)
    for name in Statistics.names():
        expected = theirs.get_statistic(metrics.StatisticsType[name])
        assert getattr(ours, name) == pytest.approx(expected, rel=1e-14), name
    one = Statistics.of(np.array([2.0]))
    assert (one.rmse, one.std, one.min, one.max) == (2.0, 0.0, 2.0, 2.0)


@pytest.mark.parametrize("shape", [(0,), (2, 3), ()])
def test_statistics_are_of_one_error_a_pair(shape):
    with pytest.raises(ValueError, match=r"errors: expected shape \(N,\) with N >= 1, got"):
        Statistics.of(np.ones(shape))


def test_relative_errors_need_two_pairs(rng):
    two = Motor.random(rng, (2,))
    metres, radians = relative_errors(two, two)
    assert (metres.shape, radians.shape) == ((1,), (1,))
    assert max(metres[0], radians[0]) < 1e-12
    with pytest.raises(ValueError, match="relative error: expected 2 or more pairs, got 1"):
        relative_errors(two[:1], two[:1])
    flat = evaluate(at(5), at(5, 6)).as_dict()
    assert flat["rpe_trans_rmse_m"] is None
    assert flat["rpe_by_length_trans_rmse_m"] is None
    flat = evaluate(at(5, 6), at(5, 6)).as_dict()
    assert flat["rpe_trans_rmse_m"] == pytest.approx(0.0, abs=1e-12)
    assert flat["rpe_length_m"] == 1.0  # both metres apart: one segment
    assert flat["rpe_by_length_trans_rmse_m"] == pytest.approx(0.0, abs=1e-12)
