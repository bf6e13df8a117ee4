"""Performers that move, grow, hover and come and go, against ones placed anew for each frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorcade.animation import Clip, Placement
from motorcade.animation.vectors import turn_z
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.render import Lighting, Performer, Sun, render_performers
from motorcade.render.scene import ImageArray
from motorcade.tracking.cameras.camera import Camera
from tests.props import box

CAMERA = Camera(240, 180, 200.0, 200.0, 119.5, 89.5)
FRAME: ImageArray = np.full((180, 240, 3), 170, dtype=np.uint8)
TIME_NS = np.array([5, 6, 7]) * 10**9
EYE = Motor.from_rotor_translation(
    Rotor.from_rotation_vector([-1.5708 - 0.6, 0.0, 0.0]), np.array([0.0, -2.0, 1.6])
)
PATH = Trajectory(TIME_NS, Motor.stack([EYE] * 3))
NOON = Lighting((0.4, 0.4, 0.4), Sun((0.0, 0.0, -1.0), 2.0), (), (0.0, 0.0, 0.2), 1.5)


BOX = box()
STILL = Clip("still", np.zeros(1), BOX.skeleton.rest.reshape(1, 1))
GROUND = Placement(Motor.from_rotor_translation(turn_z(np.array(0.3)), [0.1, 0.2, 0.0]), 1.0)


def moves(*poses: Similarity) -> Trajectory:
    return Trajectory(TIME_NS[: len(poses)], Similarity.stack(poses), "placement", "character")


def at(x: float, y: float, z: float, turn: float = 0.0, scale: float = 1.0) -> Similarity:
    motor = Motor.from_rotor_translation(turn_z(np.array(turn)), [x, y, z])
    return Similarity.from_motor_scale(motor, scale)


MOTION = moves(at(-0.4, 0, 0), at(0, 0.1, 0, 0.7, 1.5), at(0.3, -0.1, 0, 1.4, 2.0))


def drawn(*performers: Performer, lighting: Lighting = NOON) -> list[ImageArray]:
    frames = [(int(stamp), FRAME) for stamp in TIME_NS]
    return list(render_performers(frames, CAMERA, PATH, performers, lighting=lighting))


def changed(image: ImageArray) -> NDArray[np.bool_]:
    return np.any(np.abs(image.astype(int) - FRAME) > 8, axis=2)


@pytest.mark.usefixtures("opengl")
def test_a_performer_is_drawn_where_its_motion_has_it() -> None:
    """As is one whose placement says the same, but for the grid that its shadow is made on."""
    made = drawn(Performer(BOX, STILL, GROUND, MOTION))
    for k in range(3):
        pose, scale = MOTION.poses[k].as_motor_scale()
        there = Placement(GROUND.world_T_character @ pose, float(scale))
        wanted = drawn(Performer(BOX, STILL, there))[k]
        assert changed(wanted).sum() > 250
        both = changed(wanted) & changed(made[k])
        assert both.sum() > 0.9 * (changed(wanted) | changed(made[k])).sum()
        assert np.abs(made[k].astype(int) - wanted)[both].mean() < 4.0


@pytest.mark.usefixtures("opengl")
def test_what_hovers_throws_its_shadow_where_the_light_takes_it() -> None:
    """In light at 45 degrees the shadow lies as far to the side as the cube is high."""
    hovers = moves(*[at(-0.5, 0.0, 0.8)] * 3)
    light = replace(NOON, sun=Sun((0.5**0.5, 0.0, -(0.5**0.5)), 2.0))
    level = replace(GROUND, world_T_character=Motor.from_translation([0.0, 0.2, 0.0]))
    image = drawn(Performer(BOX, STILL, level, hovers), lighting=light)[0]
    middle_m = np.array([-0.5 + 0.9, 0.2, 0.0])  # the cube's middle is 0.9 m up
    column, row = CAMERA.project(EYE.inverse().apply(middle_m))
    rows, columns = np.nonzero(changed(image))
    beside = np.hypot(columns - column, rows - row) < 25
    assert beside.sum() > 60
    assert np.hypot(columns[beside].mean() - column, rows[beside].mean() - row) < 3.0


@pytest.mark.usefixtures("opengl")
def test_each_throws_its_shadow_on_its_own_ground() -> None:
    """One on a ground that has gone up is drawn there with its shadow; the other stays."""
    up = Trajectory(TIME_NS, Motor.from_translation([[0, 0, 0], [0, 0, 0.2], [0, 0, 0.4]]))
    left, right = moves(*[at(-0.5, 0, 0)] * 3), moves(*[at(0.5, 0, 0)] * 3)
    both = drawn(
        Performer(BOX, STILL, Placement(Motor.identity(), 1.0), left),
        Performer(BOX, STILL, Placement(Motor.identity(), 1.0), right, up),
    )
    assert np.array_equal(changed(both[0])[:, :120], changed(both[2])[:, :120])
    lifted = Performer(BOX, STILL, Placement(up.motors[2], 1.0), right)
    alone = drawn(lifted)[2]
    half = np.s_[:, 120:]
    agreed = changed(alone)[half] & changed(both[2])[half]
    assert agreed.sum() > 0.9 * (changed(alone)[half] | changed(both[2])[half]).sum() > 200


@pytest.mark.usefixtures("opengl")
def test_a_performer_is_seen_only_while_it_is_there() -> None:
    made = drawn(Performer(BOX, STILL, GROUND, MOTION, visible_s=(0.5, 1.5)))
    assert np.array_equal(made[0], FRAME)
    assert changed(made[1]).sum() > 250
    assert np.array_equal(made[2], FRAME)


def test_world_poses_are_those_of_ground_and_motion() -> None:
    up = Trajectory(TIME_NS, Motor.from_translation([[0, 0, 0], [0, 0, 1], [0, 0, 2.0]]))
    one = Performer(BOX, STILL, replace(GROUND, scale=0.5), MOTION, up)
    stamps = np.array([0, 6 * 10**9, 9 * 10**9])
    poses = one.world_T_character(stamps)
    for k, row in enumerate((0, 1, 2)):  # held before the first stamp and after the last
        point = MOTION.poses[row].apply([0.1, 0.2, 0.3])
        wanted = up.motors[row].apply(replace(GROUND, scale=0.5).apply(point))
        np.testing.assert_allclose(poses[k].apply([0.1, 0.2, 0.3]), wanted, atol=1e-12)
        alone = one.world_T_character(int(stamps[k]))
        np.testing.assert_allclose(alone.as_matrix(), poses[k].as_matrix(), atol=1e-12)
