"""Windows, offsets, interpolation, alignment and projection keep what they promise."""

from __future__ import annotations

import logging

import numpy as np
import pytest

from motorcade.fusion.metrics import (
    Delta,
    NotObservableError,
    absolute_errors,
    alignment_of,
    associate,
    cropped,
    evaluate_matched,
    match,
    relative_errors,
)
from motorcade.fusion.metrics.poses import pose_error
from motorcade.fusion.metrics.poses.alignment import folded, projected
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.ga import Motor, Rotor, Similarity, Trajectory

S = 1_000_000_000


@pytest.fixture(scope="module")
def walk() -> tuple[Trajectory, Trajectory]:
    """An estimate at 10 Hz, and its ground truth at 50 Hz."""
    motion = MOTIONS["walk_and_look"]
    estimate = Gaussian(0.01, 0.01).apply(motion.sampled(10.0, 10.0), np.random.default_rng(4))
    return estimate, motion.sampled(50.0, 10.0)


def errors(found) -> np.ndarray:
    return absolute_errors(found.pairs.estimate, found.pairs.reference, "full")


def test_a_window_compares_what_lies_in_it(walk):
    estimate, truth = walk
    found = match(estimate, truth, start_s=2.0, end_s=5.0)
    assert (found.pairs.time_ns.min(), found.pairs.time_ns.max()) == (2 * S, 5 * S)
    assert (found.estimate.time_ns[0], found.estimate.time_ns[-1]) == (2 * S, 5 * S)
    assert (found.reference.time_ns[0], found.reference.time_ns[-1]) == (2 * S, 5 * S)
    by_hand = match(cropped(estimate, 2.0, 5.0), cropped(truth, 2.0, 5.0))
    assert evaluate_matched(found) == evaluate_matched(by_hand)


def test_an_offset_undoes_a_shift_of_the_clock(walk):
    estimate, truth = walk
    shifted = Trajectory(estimate.time_ns - 3 * S, estimate.poses)
    found, unshifted = match(shifted, truth, offset_s=3.0), match(estimate, truth)
    assert evaluate_matched(found) == evaluate_matched(unshifted)
    np.testing.assert_array_equal(found.pairs.time_ns, unshifted.pairs.time_ns)
    np.testing.assert_array_equal(found.estimate.time_ns, estimate.time_ns)


@pytest.mark.parametrize("estimate_hz", [3.0, 70.0])
def test_interpolation_is_exact_on_even_motion(estimate_hz):
    """At constant speed and rate about a fixed axis, whichever of the two has more poses."""

    def path(rate_hz: float) -> Trajectory:
        stamps = np.arange(round(4 * rate_hz)) * round(S / rate_hz)
        turn = Rotor.from_rotation_vector(stamps[:, None] * 1e-9 * [0.0, 0.0, 0.7])
        positions = stamps[:, None] * 1e-9 * [1.0, 2.0, 0.0]
        return Trajectory(stamps, Motor.from_rotor_translation(turn, positions))

    ours, true = path(estimate_hz), path(20.0)
    assert errors(match(ours, true, max_difference_s=0.05)).max() > 0.01
    between = match(ours, true, max_difference_s=0.05, interpolate=True)
    inside = between.pairs.time_ns <= min(ours.time_ns[-1], true.time_ns[-1])
    assert np.count_nonzero(inside) >= 11
    assert errors(between)[inside].max() < 1e-12


def test_nothing_is_extrapolated(walk):
    estimate, truth = walk
    beyond = Trajectory(np.array([-5_000_000, 0]), estimate.motors[:2])
    found = associate(beyond, truth, interpolate=True)
    first = truth.motors[:1].coefficients
    np.testing.assert_allclose(found.reference[:1].coefficients, first, atol=1e-15)
    with pytest.raises(ValueError, match="2 or more poses to interpolate between, got 1"):
        associate(truth[:1], truth[:1], interpolate=True)


def test_a_fit_to_the_first_pairs_shows_drift_after_them():
    truth = MOTIONS["walk_and_look"].sampled(20.0, 10.0)
    bent = np.array(truth.motors.translation_m)
    bent[100:] += np.arange(101)[:, None] * [0.0, 0.01, 0.0]
    drifting = Trajectory(
        truth.time_ns, Motor.from_rotor_translation(truth.motors.rotor, bent)
    ).transformed_by(Motor.from_euler_translation([0.1, 0.2, 0.5], [1.0, 2.0, 3.0]))
    start = absolute_errors(*poses(match(drifting, truth, "se3", n_to_align=100)))
    whole = absolute_errors(*poses(match(drifting, truth, "se3")))
    assert start[:100].max() < 1e-9
    assert start[-1] == pytest.approx(1.0)
    assert whole[:100].mean() > 0.05
    many = match(drifting, truth, "se3", n_to_align=10_000)
    np.testing.assert_array_equal(absolute_errors(*poses(many)), whole)


def poses(found) -> tuple[Motor, Motor]:
    return found.pairs.estimate, found.pairs.reference


@pytest.mark.parametrize("scaled", [False, True])
def test_origin_alignment_makes_the_first_poses_agree(walk, rng, scaled):
    estimate, truth = walk
    elsewhere = estimate.transformed_by(Motor.random(rng))
    found = match(elsewhere, truth, "scaled_origin" if scaled else "origin")
    assert errors(found)[0] < 1e-12
    pairs = associate(elsewhere, truth)
    scale = alignment_of(pairs, "scale").scale if scaled else 1.0
    assert found.alignment.scale == scale
    assert (scale == 1.0) is not scaled
    only = alignment_of(pairs, "scale")
    np.testing.assert_array_equal(only.translation_m, np.zeros(3))
    assert only.rotor.angle() == 0.0


@pytest.mark.parametrize(("plane", "normal"), [("xy", 2), ("xz", 1), ("yz", 0)])
def test_projected_poses_lie_and_turn_in_their_plane(rng, plane, normal):
    """Twice is once, also where the other two angles hide it."""
    flat = projected(Motor.random(rng, (50,)), plane)
    assert np.all(flat.translation_m[:, normal] == 0.0)
    axes = np.delete(np.arange(3), normal)
    assert np.abs(flat.rotor.as_rotation_vector()[:, axes]).max() < 1e-12
    again = projected(flat, plane)
    np.testing.assert_allclose(again.as_matrix(), flat.as_matrix(), atol=1e-12)


def test_turns_that_are_folded_are_said(walk, caplog):
    turned = Rotor.from_rotation_vector([[0.0, 1.5, 0.0], [0.0, 1.6, 0.0], [0.0, -3.0, 0.0]])
    path = Motor.from_rotor_translation(turned, np.eye(3))
    assert folded(path, "xz").tolist() == [False, True, True]
    assert not np.any(folded(path, "xy"))
    both = Trajectory(np.arange(3) * S, path)
    with caplog.at_level(logging.WARNING, "motorcade.metrics"):
        match(both, both, plane="yz")
        assert not caplog.records
        match(both, both, plane="xz")
    assert "2 of 3 poses face backwards in the plane xz" in caplog.text


def test_scales_are_judged_beside_rigid_poses(walk):
    estimate, truth = walk
    grown = Trajectory(estimate.time_ns, Similarity.from_motor_scale(estimate.motors, 1.2))
    found = match(grown, truth, start_s=2.0, interpolate=True)
    assert found.log_scale is not None
    np.testing.assert_allclose(found.log_scale, np.log(1.2))
    assert match(estimate, truth).log_scale is None


def test_a_share_of_no_distance_is_left_out():
    """Also where the frame turns on the spot, far from the origin, whose position then rounds."""
    turns = Rotor.from_rotation_vector(np.arange(4.0)[:, None] * [0.3, 0.2, 0.1])
    still = Motor.from_rotor_translation(turns, [123.4, 567.8, 9.1])
    moved = np.array([[0.0], [0.0], [0.0], [1.0]])
    true = Motor.from_rotor_translation(turns, still.translation_m + moved)
    share, distance = relative_errors(
        still, true, Delta(), ("point_distance_error_ratio", "point_distance")
    )
    np.testing.assert_allclose(share, [100.0])
    np.testing.assert_allclose(distance, [0.0, 0.0, np.sqrt(3.0)], atol=1e-12)


def test_all_pairs_by_angle_are_bounded(rng, monkeypatch):
    few = Motor.from_rotor_translation(Rotor.random(rng, (60,)), np.zeros((60, 3)))
    turn = Delta(100.0, "deg", all_pairs=True, tolerance=0.5)
    first, last = turn.ends(few, few)
    angles = np.rad2deg((few[first].rotor.inverse() @ few[last].rotor).angle())
    assert np.all((angles >= 50.0) & (angles <= 150.0))
    assert np.all(first < last)
    monkeypatch.setattr(pose_error, "_CELLS", 130)  # blocks of two rows
    for whole, blocks in zip((first, last), turn.ends(few, few), strict=True):
        np.testing.assert_array_equal(whole, blocks)
    monkeypatch.setattr(pose_error, "MOST_PAIRS", len(first) - 1)
    with pytest.raises(ValueError, match=r"expected at most .* pairs, got more among 60 poses"):
        turn.ends(few, few)
    monkeypatch.setattr(pose_error, "MOST_POSES", 59)
    with pytest.raises(ValueError, match="expected at most 59 poses for all pairs by angle, got"):
        turn.ends(few, few)


@pytest.mark.parametrize(
    "delta",
    [
        Delta(50),
        Delta(50, all_pairs=True),
        Delta(9.0, "m"),
        Delta(9.0, "m", all_pairs=True),
        Delta(3.0, "rad"),
        Delta(170.0, "deg", all_pairs=True),
    ],
    ids=str,
)
def test_poses_that_are_nowhere_so_far_apart_have_no_relative_error(delta):
    short = Motor.from_translation(np.arange(5.0)[:, None] * [1.0, 0.0, 0.0])
    with pytest.raises(NotObservableError, match="relative error: expected"):
        delta.ends(short, short)
    alone = short[:1]
    with pytest.raises(NotObservableError, match="relative error: expected"):
        delta.ends(alone, alone)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ((0.0,), "delta: expected above 0 frames, got 0.0"),
        ((1.5,), "delta: expected a whole number of frames, got 1.5"),
        ((np.inf, "m"), "delta: expected above 0 m, got inf"),
        ((181.0, "deg"), "delta: expected above 0 and at most 180 deg, got 181.0"),
        ((1.0, "s"), "delta unit: expected one of frames, m, deg, rad, got 's'"),
        ((1.0, "m", True, -0.1), "delta tolerance: expected 0 or more, got -0.1"),
        ((1.0, "m", True, 0.1, "truth"), "pairs_from: expected one of reference, estimate, got"),
    ],
)
def test_deltas_are_refused_where_they_mean_nothing(arguments, problem):
    with pytest.raises(ValueError, match=problem):
        Delta(*arguments)


def test_names_that_there_are_not_are_refused(walk):
    estimate, truth = walk
    pose = Motor.identity((2,))
    with pytest.raises(ValueError, match="plane: expected one of xy, xz, yz, got 'zx'"):
        match(estimate, truth, plane="zx")
    with pytest.raises(ValueError, match=r"relation: expected one of full, .*, got 'fall'"):
        relative_errors(pose, pose, Delta(), ("fall",))
    with pytest.raises(ValueError, match="absolute errors have no point_distance_error_ratio"):
        absolute_errors(pose, pose, "point_distance_error_ratio")
