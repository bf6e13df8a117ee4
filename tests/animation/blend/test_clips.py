"""Clips blended whole: in phase and by the clock, loops that close, methods that tie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Clip
from motorcade.animation.blend import blend_clips, closed, differences_m
from motorcade.animation.blend.locomotion import split_root_motion
from motorcade.animation.clip import MorphTrack
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity


def test_in_phase_the_cycle_takes_the_weighted_mean_of_the_times(cycle):
    walk, run = cycle("walk", 1.2), cycle("run", 0.8, stride=0.5)
    for weight, seconds in ((0.0, 1.2), (0.5, 1.0), (1.0, 0.8)):
        made = blend_clips(walk, run, weight)
        assert made.duration_s == pytest.approx(seconds)
        assert made.looped
    middle = blend_clips(walk, run, 0.5, "motor_linear", rate_hz=120.0)
    # Both feet swing straight, so their strides average.
    assert np.ptp(middle.poses[:, 1].translation_m[:, 0]) == pytest.approx(0.8, abs=1e-3)


@pytest.mark.parametrize("weight", [0.0, 1.0])
def test_at_the_ends_a_blend_is_the_clip_itself(cycle, weight):
    walk, run = cycle("walk", 1.2), cycle("run", 0.8, stride=0.5)
    own = (walk, run)[int(weight)]
    made = blend_clips(walk, run, weight, rate_hz=50.0)
    np.testing.assert_allclose(
        made.poses.coefficients[:-1], own.at(made.time_s).coefficients[:-1], atol=1e-12
    )


def test_by_the_clock_each_runs_at_its_own_speed(cycle):
    walk, run = cycle("walk", 1.2), cycle("run", 0.8)
    made = blend_clips(walk, run, 1.0, in_phase=False)
    assert made.duration_s == pytest.approx(1.2)
    np.testing.assert_allclose(
        made.poses.coefficients, run.at(made.time_s).coefficients, atol=1e-12
    )


def test_ties_of_theory_are_ties_on_a_body(cycle, skeleton):
    apart = differences_m(cycle("walk", 1.2), cycle("run", 0.8, 0.1, 0.5), skeleton, (0.4,))
    for a, b in (
        ("motor", "dual_quaternion"),
        ("motor", "similarity"),
        ("motor_linear", "dual_quaternion_linear"),
        ("rotor", "quaternion"),
        ("rotor_linear", "quaternion_linear"),
    ):
        assert apart[a, b] < 1e-12


def test_a_cycle_that_nearly_closes_is_closed_and_one_that_travels_is_refused(cycle, rng):
    loop = cycle("walk", 1.2)
    drift = Motor.from_twist(0.02 * rng.standard_normal((4, 6)))
    poses = loop.poses.coefficients.copy()
    poses[-1] = (loop.poses[-1] @ drift).coefficients
    made = closed(Clip("walk", loop.time_s, Motor(poses)))
    assert made.looped
    off = (Motor(poses).inverse() @ made.poses).as_twist()
    assert np.abs(off).max() == pytest.approx(np.abs(drift.as_twist()).max(), rel=1e-6)
    assert np.abs(off[0]).max() < 1e-15
    assert np.abs(np.diff(off, axis=0)).max() < 0.1 * np.abs(off).max()
    poses[-1, 0] = (Motor.from_twist([0, 0, 0, 1.0, 0, 0]) @ loop.poses[-1, 0]).coefficients
    with pytest.raises(ValueError, match="got 1 at joint 0"):
        closed(Clip("walk", loop.time_s, Motor(poses)))


def test_refusals(cycle):
    walk = cycle("walk", 1.2)
    with pytest.raises(ValueError, match=r"blend_clips\(weight\): expected 0 to 1, got 1.5"):
        blend_clips(walk, walk, 1.5)
    few = Clip("few", walk.time_s, walk.poses[:, :2])
    with pytest.raises(ValueError, match="expected clips of one skeleton, got 4 joints"):
        blend_clips(walk, few, 0.5)
    for rate_hz in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"blend_clips\(rate_hz\): expected a number above 0"):
            blend_clips(walk, walk, 0.5, rate_hz=rate_hz)
    with pytest.raises(ValueError, match="expected at most 100000 samples, got 1e\\+12 Hz"):
        blend_clips(walk, walk, 0.5, rate_hz=1e12)


def test_points_of_a_body_lie_apart_by_the_turn_times_their_distance(skeleton, rng):
    """Farther from a joint its turn counts more; points at the joints are what is told without."""
    time_s = np.linspace(0.0, 1.0, 5)
    walk, run = (
        Clip(name, time_s, skeleton.rest @ Motor.from_twist(0.5 * rng.standard_normal((5, 4, 6))))
        for name in ("walk", "run")
    )
    pair = ("motor", "euler")
    at_joints = differences_m(walk, run, skeleton, (0.4,), methods=pair)
    same = differences_m(walk, run, skeleton, (0.4,), np.zeros((4, 3)), pair)
    far = differences_m(walk, run, skeleton, (0.4,), np.full((4, 3), 5.0), pair)
    assert at_joints == same
    assert far[pair] > 2.0 * same[pair]


def test_a_clip_that_grows_is_compared_by_its_turns_and_places(cycle, skeleton):
    walk, run = cycle("walk", 1.2), cycle("run", 0.8)
    grown = [
        Clip(one.name, one.time_s, Similarity.from_motor_scale(one.poses, 1.0), True)
        for one in (walk, run)
    ]
    pair = ("motor", "rotor_linear")
    found = differences_m(*grown, skeleton, (0.5,), methods=pair)
    wanted = differences_m(walk, run, skeleton, (0.5,), methods=pair)
    assert found[pair] == pytest.approx(wanted[pair], abs=1e-12)


def test_a_loop_is_closed_already(cycle):
    walk = cycle("walk", 1.2)
    assert closed(walk) is walk


def smiling(clip, weights):
    """The clip with weights of two targets at its ends."""
    track = MorphTrack(np.array([0.0, clip.time_s[-1]]), np.array(weights))
    return replace(clip, morphs=track)


def test_weights_of_morph_targets_are_blended_with_the_poses(cycle):
    walk, run = cycle("walk", 1.2), cycle("run", 0.8)
    glad, sad = smiling(walk, [[0.0, 1.0], [1.0, 1.0]]), smiling(run, [[0.5, 0.0], [0.5, 0.0]])
    made = blend_clips(glad, sad, 0.25, in_phase=False)
    np.testing.assert_allclose(made.morph_weights(0.6), [0.75 * 0.5 + 0.25 * 0.5, 0.75])
    assert blend_clips(glad, run, 0.25).morphs is None
    few = smiling(run, [[0.5], [0.5]])
    with pytest.raises(ValueError, match="morph targets of one character, got 2 in 'walk' and 1"):
        blend_clips(glad, few, 0.25)


def test_clips_that_are_closed_or_held_in_place_keep_their_weights():
    poses = Motor.from_translation([[[0.0, 0, 1]], [[1.0, 0, 1]]])
    clip = smiling(Clip("walk", np.array([0.0, 1.0]), poses), [[0.0, 1.0], [1.0, 1.0]])
    still, _ = split_root_motion(clip, Skeleton(("root",), np.array([-1]), Motor.identity((1,))))
    for one in (still, closed(replace(still, looped=False))):
        assert one.morphs is clip.morphs
