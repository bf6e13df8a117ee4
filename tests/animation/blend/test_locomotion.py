"""Blend spaces keep cycles in phase; root motion goes over from clip to character and back."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Clip
from motorcade.animation.blend import BlendSpace, RootMotion
from motorcade.animation.blend.locomotion import phase_between, split_root_motion
from motorcade.ga import Motor, Rotor, Similarity

FEET = ("left_foot", "right_foot")


def test_a_cycle_that_starts_elsewhere_is_found_in_phase(skeleton, cycle):
    walk, run = cycle("walk", 1.2), cycle("run", 0.7, phase=0.25, stride=0.5)
    assert phase_between(walk, run, skeleton, FEET) == pytest.approx(0.75, abs=1 / 64)


def test_feet_keep_their_part_in_phase_and_lose_it_by_the_clock(skeleton, cycle):
    walk, run = cycle("walk", 1.2), cycle("run", 0.7, phase=0.25)
    offset = phase_between(walk, run, skeleton, FEET)
    space = BlendSpace(np.array([1.4, 3.0]), (walk, run), np.array([0.0, offset]))
    phases = np.linspace(0.0, 1.0, 65)
    middle = space.pose(2.2, phases)
    same = walk.at(phases * walk.duration_s)
    assert np.abs(middle.translation_m - same.translation_m).max() < 0.01
    by_clock = BlendSpace(np.array([1.4, 3.0]), (walk, run)).pose(2.2, phases)
    assert np.abs(by_clock.translation_m - same.translation_m).max() > 0.1


def test_a_blended_cycle_takes_the_weighted_mean_of_the_times(cycle):
    space = BlendSpace(
        np.array([1.0, 2.0, 4.0]), (cycle("a", 1.2), cycle("b", 0.8), cycle("c", 0.6))
    )
    np.testing.assert_allclose(space.duration_s([0.0, 1.0, 1.5, 3.0, 9.0]), [1.2, 1.2, 1, 0.7, 0.6])
    np.testing.assert_allclose(space.weights(1.5), [0.5, 0.5, 0.0])
    times = np.linspace(0.0, 6.0, 13)
    np.testing.assert_allclose(space.phases(times, np.full(13, 2.0)), times / 0.8)


def test_refusals_of_blend_spaces(cycle):
    walk = cycle("walk", 1.2)
    once = Clip("once", walk.time_s, walk.poses)
    with pytest.raises(ValueError, match="expected loops of 4 joints, got 'once'"):
        BlendSpace(np.array([1.0, 2.0]), (walk, once))
    with pytest.raises(ValueError, match="expected rising numbers"):
        BlendSpace(np.array([2.0, 1.0]), (walk, walk))


def _travelling(cycle, turn_rad_s: float) -> Clip:
    """The walk going along an arc, leaning into it; one cycle and no more."""
    inside = cycle("walk", 1.2)
    angle = turn_rad_s * inside.time_s
    rotors = Rotor.from_rotation_vector(angle[:, None] * [0.0, 0.0, 1.0])
    positions = np.stack([np.sin(angle), 1.0 - np.cos(angle), 0.0 * angle], axis=1) / turn_rad_s
    way = Motor.from_rotor_translation(rotors, positions)
    lean = Motor.from_twist([0.2, 0.0, 0.0, 0.0, 0.0, 0.0])
    poses = np.array(inside.poses.coefficients)
    poses[:, 0] = (way @ inside.poses[:, 0] @ lean).coefficients
    return Clip("arc", inside.time_s, Motor(poses))


def test_root_motion_put_back_gives_the_clip_again(skeleton, cycle):
    clip = _travelling(cycle, 0.7)
    inside, way = split_root_motion(clip, skeleton)
    again = way.at(clip.time_s) @ inside.at(clip.time_s)[:, 0]
    assert np.abs((again.inverse() @ clip.poses[:, 0]).as_twist()).max() < 1e-12
    np.testing.assert_allclose(way.start_T_now.translation_m[:, 2], 0.0, atol=1e-12)
    assert way.speed_m_s == pytest.approx(1.0, rel=1e-3)


def test_a_cycle_of_root_motion_goes_on_where_it_ended(skeleton, cycle):
    clip = _travelling(cycle, 0.7)
    inside, way = split_root_motion(clip, skeleton)
    assert inside.looped
    assert way.repeated
    times = np.array([0.4, 1.6, 2.8])  # one cycle apart
    steps = way.at(times[:-1]).inverse() @ way.at(times[1:])
    # On a circle every cycle is the same motion, seen from where the character is.
    assert np.abs((steps[0].inverse() @ steps[1]).as_twist()).max() < 1e-9


def test_refusals_of_root_motion(skeleton, cycle):
    clip = cycle("walk", 1.2)
    with pytest.raises(ValueError, match="expected a root joint"):
        split_root_motion(clip, skeleton, "head")


def test_refusals_of_phases(skeleton, cycle):
    walk = cycle("walk", 1.2)
    once = Clip("once", walk.time_s, walk.poses)
    space = BlendSpace(np.array([1.0, 2.0]), (walk, walk))
    for times, values in (([1.0, 0.0], [1.0, 1.0]), ([0.0, 1.0], [1.0]), (0.0, 1.0)):
        with pytest.raises(ValueError, match="expected rising times"):
            space.phases(times, values)
    with pytest.raises(ValueError, match=r"offsets: expected 2 phases, got shape \(3,\)"):
        BlendSpace(np.array([1.0, 2.0]), (walk, walk), np.zeros(3))
    with pytest.raises(ValueError, match="expected a loop, got 'once'"):
        phase_between(walk, once, skeleton, FEET)
    still = Clip("still", np.array([0.0, 1.0]), Motor.stack([skeleton.rest] * 2), looped=True)
    for clip, joints in ((walk, ()), (still, FEET)):
        with pytest.raises(ValueError, match=f"expected joints that move in '{clip.name}'"):
            phase_between(clip, clip, skeleton, joints)
    with pytest.raises(ValueError, match="got 'tail'"):
        phase_between(walk, walk, skeleton, ("tail",))


def test_the_way_of_a_clip_that_grows_is_split_off_too(skeleton, cycle):
    """What is left grows as before, and put back on its way it is the clip again."""
    clip = _travelling(cycle, 0.7)
    sizes = np.linspace(1.0, 2.0, len(clip.time_s))[:, None] * np.ones(4)
    grown = Clip("grown", clip.time_s, Similarity.from_motor_scale(clip.poses, sizes))
    inside, way = split_root_motion(grown, skeleton)
    assert isinstance(inside.poses, Similarity)
    np.testing.assert_allclose(inside.poses.scale, sizes, rtol=1e-12)
    again = Similarity.from_motor_scale(way.at(clip.time_s)) @ inside.poses[:, 0]
    np.testing.assert_allclose(again.as_matrix(), grown.poses[:, 0].as_matrix(), atol=1e-12)


def test_ways_that_are_none_are_refused():
    with pytest.raises(ValueError, match=r"RootMotion\.start_T_now: expected shape \(2,\), got"):
        RootMotion(np.array([0.0, 1.0]), Motor.identity((3,)), False)
    with pytest.raises(ValueError, match=r"RootMotion\.time_s: expected"):
        RootMotion(np.array([1.0, 0.0]), Motor.identity((2,)), False)
