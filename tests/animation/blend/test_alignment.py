"""Motions of any heading, place and carrying joint are blended facing one way, feet in step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorcade.animation import Character, Clip, Skeleton, legs_of, mannequin
from motorcade.animation.behaviour import gait_between
from motorcade.animation.blend import closed, grounded, in_step
from motorcade.animation.blend.alignment import contacts
from motorcade.animation.ik.feet import segments
from motorcade.animation.place import on_the_spot
from motorcade.animation.retarget import facing_rad
from motorcade.animation.vectors import turn_z
from motorcade.ga import Motor, Rotor
from motorcade.replays.tasks.blending import blend_character


@pytest.fixture(scope="module")
def who() -> Character:
    return mannequin()


def turned(clip: Clip, skeleton: Skeleton, degrees: float, aside_m=(0.0, 0.0, 0.0)) -> Clip:
    start = Motor.from_rotor_translation(turn_z(np.radians(degrees)), np.array(aside_m))
    return replace(clip, poses=skeleton.moved(clip.poses, start), looped=False)


def facing_deg(skeleton: Skeleton, clip: Clip) -> np.ndarray:
    facing = facing_rad(skeleton, skeleton.world(clip.poses.rigid).translation_m)
    assert facing is not None
    return np.degrees(facing)


@pytest.mark.parametrize("degrees", [90.0, 180.0])
def test_a_blend_faces_as_both_do_wherever_they_begin(who, degrees):
    names = ("walk", "run")
    second = turned(who.clip(names[1]), who.skeleton, degrees, (1.5, -0.7, 0.0))
    other = replace(who, clips=(who.clip(names[0]), replace(second, name="other")))
    blend = blend_character(other, (names[0], "other"), 0.5)
    plain = blend_character(who, names, 0.5)
    heads = facing_deg(who.skeleton, blend.clip)
    assert np.abs(heads).max() < 8.0  # hips sway in a run
    apart = blend.clip.poses.rigid.translation_m - plain.clip.poses.rigid.translation_m
    assert np.abs(apart).max() < 0.02 * who.height_m
    assert np.abs(np.diff(heads)).max() < 3.0


def test_feet_of_a_blend_stand_still_on_its_way(who):
    blend = blend_character(who, ("walk", "run"), 0.5)
    ways = [
        on_the_spot(who.clip(name), who.skeleton, legs_of(who.skeleton)) for name in ("walk", "run")
    ]
    far_m = np.mean([speed * loop.duration_s for loop, speed in ways])
    assert blend.way.speed_m_s == pytest.approx(far_m / blend.clip.duration_s, rel=0.03)
    again = np.concatenate([blend.clip.time_s, blend.clip.duration_s + blend.clip.time_s[1:]])
    world = blend.way.at(again).reshape(-1, 1) @ who.skeleton.world(blend.clip.at(again).rigid)
    for leg in legs_of(who.skeleton):
        ball = who.skeleton.index(leg.ball)
        at, rest = world[:, ball].translation_m, who.skeleton.rest_world[ball].translation_m
        low = at[:, 2] <= rest[2] + 0.003 * who.height_m
        slides = [np.ptp(at[a:b, :2], axis=0).max() for a, b in segments(low)]
        assert slides
        assert max(slides) < 0.01 * who.height_m


@pytest.mark.parametrize("degrees", [0.0, 180.0])
def test_it_does_not_matter_which_joint_of_a_file_goes(who, degrees):
    """A root above the hips may carry the motion, or stand still while the hips go."""
    names = ("ground", *who.skeleton.names)
    parents = np.append(-1, np.where(who.skeleton.parents < 0, 0, who.skeleton.parents + 1))
    rest = Motor.concatenate([Motor.identity((1,)), who.skeleton.rest])
    skeleton = Skeleton(names, parents, rest)
    time_s = np.linspace(0.0, 2.0, 60)
    way = Motor.from_rotor_translation(
        turn_z(np.full(60, np.radians(degrees))), time_s[:, None] * [0.6, 0.8, 0.0]
    )
    inside = who.clip("walk").at(time_s).rigid.coefficients
    still = np.broadcast_to(Motor.identity().coefficients, (60, 1, 8))
    by_root = np.concatenate([way.coefficients[:, None], inside], axis=1)
    hips = who.skeleton.moved(Motor(inside), way).coefficients
    by_hips = np.concatenate([still, hips], axis=1)
    motions = [
        grounded(Clip(name, time_s, Motor(poses)), skeleton)
        for name, poses in (("root", by_root), ("hips", by_hips))
    ]
    local = [motion.clip.poses.rigid for motion in motions]
    assert np.abs((local[0].inverse() @ local[1]).as_twist()).max() < 1e-6
    np.testing.assert_allclose(
        motions[0].way.start_T_now.translation_m[-1],
        motions[1].way.start_T_now.translation_m[-1],
        atol=1e-6,
    )


def test_what_is_put_back_on_its_way_is_the_motion_again(who, rng):
    time_s = np.linspace(0.0, 3.0, 120)
    heading = np.cumsum(rng.normal(0.0, 0.04, 120)) + 2.0
    at = np.cumsum(rng.normal(0.0, 0.01, (120, 3)), axis=0) * [1.0, 1.0, 0.0]
    way = Motor.from_rotor_translation(turn_z(heading), at)
    clip = Clip("drawn", time_s, who.skeleton.moved(who.clip("idle").at(time_s).rigid, way))
    motion = grounded(clip, who.skeleton)
    again = who.skeleton.moved(motion.clip.poses, motion.way.at(time_s)).rigid
    start = (again[0].inverse() @ clip.poses.rigid[0]).as_twist()
    assert np.abs(start[1:]).max() < 1e-9  # all but the root, which begins ahead at the origin
    steps = [poses[:-1, 0].inverse() @ poses[1:, 0] for poses in (again, clip.poses.rigid)]
    assert np.abs((steps[0].inverse() @ steps[1]).as_twist()).max() < 1e-9
    assert np.abs(facing_deg(who.skeleton, motion.clip)).max() < 4.0 + 1e-6


def test_a_cycle_is_warped_until_its_feet_come_down_as_anothers(who):
    legs = legs_of(who.skeleton)
    walk = grounded(who.clip("walk"), who.skeleton, legs)
    clip = who.clip("walk")
    phase = np.linspace(0.0, 1.0, 97)
    late = phase + 0.31 + 0.02 * np.sin(2.0 * np.pi * phase)
    poses = clip.at(late * clip.duration_s).coefficients.copy()
    poses[-1] = poses[0]
    odd = Clip("odd", 1.4 * phase, Motor(poses), looped=True)
    second, offset, note = in_step(walk, grounded(odd, who.skeleton, legs), who.skeleton, legs)
    assert note == ""
    assert 0.5 < offset < 0.8
    clock = np.linspace(0.0, 1.0, 200)
    stand = [
        contacts(motion, who.skeleton, legs, motion.clip.time_s[0] + clock * motion.clip.duration_s)
        for motion in (walk, second)
    ]
    assert np.mean(stand[0] == stand[1]) > 0.95


def test_gaits_on_the_spot_may_face_anywhere_and_go_ahead(who):
    legs = legs_of(who.skeleton)
    _, speed = on_the_spot(who.clip("walk"), who.skeleton, legs)
    back = turned(who.clip("walk"), who.skeleton, 180.0)
    loop, found = on_the_spot(closed(back), who.skeleton, legs)
    assert found == pytest.approx(speed, rel=1e-3)
    assert np.abs(facing_deg(who.skeleton, loop)).max() < 8.0


def test_a_walk_and_a_walk_backwards_are_no_gaits_to_blend(who):
    walk = who.clip("walk")
    legs = legs_of(who.skeleton)
    backwards = Clip("back", walk.time_s, walk.poses[np.arange(len(walk.time_s))[::-1]])
    share = (walk.time_s - walk.time_s[0])[:, None]
    goes = Motor.from_translation(share * [-0.6, 0.0, 0.0])
    backwards = replace(backwards, poses=who.skeleton.moved(backwards.poses, goes))
    with pytest.raises(ValueError, match=r"face alike as they go, got 180 degrees"):
        gait_between([walk, backwards], who.skeleton, legs, 0.8)


def test_ways_that_part_are_said(who):
    time_s = who.clip("walk").time_s
    side = Motor.from_translation((time_s - time_s[0])[:, None] * [0.0, 1.0, 0.0])
    sideways = Clip("side", time_s, who.skeleton.moved(who.clip("walk").poses, side))
    ahead = Motor.from_translation((time_s - time_s[0])[:, None] * [1.0, 0.0, 0.0])
    onwards = Clip("on", time_s, who.skeleton.moved(who.clip("walk").poses, ahead))
    blend = blend_character(replace(who, clips=(onwards, sideways)), ("on", "side"), 0.5)
    assert any("go 90 degrees apart" in notice for notice in blend.notices)


def test_one_that_lies_on_its_side_keeps_the_heading_around_it(who):
    time_s = np.linspace(0.0, 2.0, 60)
    roll = np.pi / 2.0 * np.clip(2.0 - np.abs(time_s - 1.0) * 4.0, 0.0, 1.0)
    rotors = Rotor.from_rotation_vector(roll[:, None] * [1.0, 0.0, 0.0])
    fall = Motor.from_rotor_translation(rotors, np.zeros((60, 3)))
    clip = Clip("falls", time_s, who.skeleton.moved(who.clip("idle").at(time_s).rigid, fall))
    motion = grounded(clip, who.skeleton)
    heading = motion.way.start_T_now.rotor.as_rotation_vector()[:, 2]
    assert np.abs(heading).max() < np.radians(10.0)
