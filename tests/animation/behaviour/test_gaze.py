"""Heads that look at something: straight where they can, within limits, and without jumps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, legs_of, mannequin
from motorcade.animation.behaviour import (
    Act,
    Actor,
    Errand,
    Gaze,
    LookTarget,
    Performance,
    Timeline,
    gait_between,
    perform,
)
from motorcade.animation.formats import read_character
from motorcade.animation.ik import fitted_legs
from motorcade.animation.retarget import body_of
from motorcade.ga.arrays import FloatArray

AHEAD = np.array([1.0, 0.0, 0.0])
RIGS = {
    "knight": "kaykit/Knight.glb",
    "sinbad": "sinbad/sinbad.glb",
    "bob": "md5/Bob.md5mesh",
    "makehuman": "makehuman/mh_male_ge53_27k.glb",
}


@pytest.fixture(scope="module")
def actor() -> Actor:
    figure = mannequin()
    legs = tuple(fitted_legs(legs_of(figure.skeleton), figure))
    cycle, speed_m_s = gait_between([figure.clip("walk")], figure.skeleton, legs)
    acts = {"wave": Act.of(figure.clip("wave"), figure.skeleton, legs)}
    return Actor("one", figure, legs, 0.1, figure.clip("idle"), cycle, speed_m_s, acts)


def off_deg(actor: Actor, made: Performance, target: LookTarget) -> FloatArray:
    """Angles ``(F,)`` between where the head faces and the target, from the middle of its skin.

    The head faces as its rest pose's +x does: no code of the gaze's own is used.
    """
    skeleton, head = actor.skeleton, body_of(actor.skeleton)["head"]
    world = made.plane_T_character @ skeleton.world(made.poses)[:, head]
    rest = skeleton.rest_world[head]
    faces = world.rotor.apply(rest.rotor.inverse().apply(AHEAD))
    joints, _ = actor.character.influences
    skin = actor.character.vertices[joints[:, 0] == head]
    middle = rest.inverse().apply(0.5 * (skin.min(axis=0) + skin.max(axis=0)))
    at = made.plane_T_character.apply(
        actor.scale * skeleton.world(made.poses)[:, head].apply(middle)
    )
    away = target.at(made.time_s) - at
    cosine = np.sum(faces * away, axis=-1) / np.linalg.norm(away, axis=-1)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def turn_rates(actor: Actor, made: Performance) -> FloatArray:
    """Of the head in the trunk, degrees a second."""
    skeleton, body = actor.skeleton, body_of(actor.skeleton)
    world = skeleton.world(made.poses).rotor
    inside = world[:, body["spine_1"]].inverse() @ world[:, body["head"]]
    steps = (inside[:-1].inverse() @ inside[1:]).angle()
    return np.degrees(np.asarray(steps)) / np.diff(made.time_s)


def test_it_walks_waves_and_looks_at_a_camera_that_moves(actor):
    """From its side: on the way as far as its neck lets it, then straight into the lens."""
    camera = LookTarget([0.0, 8.0], [[0.3, -0.5, 0.3], [0.6, -0.3, 0.2]])
    facing = float(np.arctan2(-0.4, 0.15))
    errand = Errand((0.0, 0.0), 0.0, [(0.0, 0.0), (0.3, 0.0)], facing, ("wave",))
    line = Timeline(actor, errand)
    plain, made = (perform(line, 8.0, look_at=one) for one in (None, camera))
    waving = next(one for one in made.segments if one.state == "act")
    rows = (made.time_s > waving.start_s + 0.2) & (made.time_s < waving.end_s)
    before, after = (off_deg(actor, one, camera)[rows] for one in (plain, made))
    print("degrees off the camera while waving:", before.max().round(1), after.max().round(1))
    assert after.max() < 4.0
    assert before.max() > 10.0
    on_its_way = (made.time_s > 1.0) & (made.time_s < waving.start_s)
    assert off_deg(actor, made, camera)[on_its_way].max() < 45.0
    rates = turn_rates(actor, made)
    print("head in the trunk, degrees a second:", rates.max().round(0))
    assert rates.max() < 250.0
    # Only neck and head are turned: feet and hands stay as they were.
    others = [k for k in range(len(actor.skeleton)) if k not in (4, 5)]
    np.testing.assert_allclose(
        made.poses[:, others].coefficients, plain.poses[:, others].coefficients, atol=1e-9
    )


def test_the_head_turns_no_farther_than_a_neck_does_and_lets_go_behind(actor):
    """A target that goes all round: within limits everywhere, no jump, straight ahead behind."""
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    places = np.stack([np.cos(turn), np.sin(turn), np.full_like(turn, 0.16)], axis=-1)
    target = LookTarget(np.linspace(2.0, 14.0, 721), places)
    line = Timeline(actor, Errand((0.0, 0.0)))
    plain, made = (perform(line, 14.0, look_at=one) for one in (None, target))
    body, skeleton = body_of(actor.skeleton), actor.skeleton
    turned = []
    for one in (plain, made):
        world = skeleton.world(one.poses).rotor
        inside = world[:, body["spine_3"]].inverse() @ world[:, body["head"]]
        rest = skeleton.rest_world.rotor
        own = rest[body["spine_3"]].inverse() @ rest[body["head"]]
        turned.append(np.degrees(np.asarray((own.inverse() @ inside).angle())))
    assert 60.0 < turned[1].max() < 90.0
    behind = np.abs(made.time_s - 8.0) < 1.0
    np.testing.assert_allclose(turned[1][behind], turned[0][behind], atol=1e-6)
    assert turn_rates(actor, made).max() < 250.0
    ahead = (made.time_s > 1.2) & (made.time_s < 3.5)
    assert off_deg(actor, made, target)[ahead].max() < 5.0


def test_it_begins_to_look_without_a_jerk(actor):
    target = LookTarget([0.0], [[1.0, 1.0, 0.16]])
    made = perform(Timeline(actor, Errand((0.0, 0.0))), 2.0, look_at=target)
    off = off_deg(actor, made, target)
    assert off[0] > 40.0
    assert off[made.time_s > 1.1].max() < 4.0
    assert turn_rates(actor, made).max() < 120.0


@pytest.mark.parametrize("name", RIGS)
def test_real_heads_and_eyes_look_where_they_shall(data_dir: Path, name: str):
    who = read_character(data_dir / "rigs" / RIGS[name])
    gaze = Gaze.of(who)
    skeleton = who.skeleton
    poses = skeleton.rest[None]
    for yaw in np.radians([-60.0, 0.0, 45.0]):
        target = who.height_m * np.array([2.0 * np.cos(yaw), 2.0 * np.sin(yaw), 0.9])
        made = gaze.looking(poses, target[None], np.array([9.0]))
        world = skeleton.world(made)[0]
        for joint in (gaze.head, *(skeleton.index(eye) for eye in gaze.eyes)):
            rest = skeleton.rest_world[joint].rotor
            faces = world[joint].rotor.apply(rest.inverse().apply(AHEAD))
            lacks = target - world[joint].translation_m
            lacks[2] = faces[2] = 0.0  # the eyes' height is not the joint's
            cosine = faces @ lacks / np.linalg.norm(faces) / np.linalg.norm(lacks)
            assert np.degrees(np.arccos(min(cosine, 1.0))) < 6.0, (name, joint, yaw)
    assert len(gaze.eyes) == (2 if name == "sinbad" else 0)


def test_what_has_no_head_is_refused():
    figure = mannequin()
    pole = Character(
        type(figure.skeleton)(("pole",), np.array([-1]), figure.skeleton.rest[:1]),
        vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2.0]]),
        normals=np.tile([0.0, -1.0, 0.0], (3, 1)),
        triangles=np.array([[0, 1, 2]]),
        colors=np.full((3, 3), 0.5),
        joints=np.zeros((3, 4), int),
        weights=np.tile([1.0, 0, 0, 0], (3, 1)),
    )
    with pytest.raises(ValueError, match="look_at: neither bones nor names tell"):
        Gaze.of(pole)
    for times, places in (([], np.zeros((0, 3))), ([0, 0], np.zeros((2, 3))), ([0], [[1, 2]])):
        with pytest.raises(ValueError, match="LookTarget"):
            LookTarget(times, places)
