"""Paths by their length, and walks along them whose feet neither slide nor sink."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Clip, Skeleton
from motorcade.animation.ik import Leg, bend_limb, find_stances
from motorcade.animation.place import GroundPath, walk_along
from motorcade.ga import Motor

NAMES = ("hips", *(f"{side}_{part}" for side in "lr" for part in ("thigh", "calf", "foot")))
LEGS = [Leg(f"{side}_thigh", f"{side}_calf", f"{side}_foot") for side in "lr"]
SPEED_M_S, PERIOD_S = 1.2, 1.0


@pytest.fixture
def skeleton() -> Skeleton:
    parents = np.array([-1, 0, 1, 2, 0, 4, 5])
    shifts = [[0, 0, 0.95]]
    for y in (0.1, -0.1):
        shifts += [[0, y, 0.0], [0.02, 0, -0.47], [-0.02, 0, -0.44]]
    rest = Motor.from_twist(np.concatenate([np.zeros((7, 3)), shifts], axis=1))
    return Skeleton(NAMES, parents, rest)


@pytest.fixture
def walk(skeleton) -> Clip:
    """Feet that go back at the walk's speed for 60 % of the cycle and swing forward for 40 %."""
    time_s = np.linspace(0.0, PERIOD_S, 61)
    poses = Motor.stack([skeleton.rest] * 61)
    down = Motor.from_twist([0, 0, 0, 0, 0, -0.06])
    held = poses.coefficients.copy()
    held[:, 0] = (down @ poses[:, 0]).coefficients
    poses = Motor(held)
    for side, leg, y in ((0.0, LEGS[0], 0.1), (0.5, LEGS[1], -0.1)):
        phase = (time_s / PERIOD_S + side) % 1.0
        swing = np.clip((phase - 0.6) / 0.4, 0.0, 1.0)
        reach = 0.3 * SPEED_M_S * PERIOD_S
        x = np.where(
            phase < 0.6,
            reach - SPEED_M_S * PERIOD_S * phase,
            -reach + 2 * reach * swing * swing * (3 - 2 * swing),
        )
        z = 0.04 + 0.12 * np.sin(np.pi * swing)
        target = np.stack([x, np.full_like(x, y), z], axis=1)
        ahead = [9.0, y, 0.5]
        poses = bend_limb(skeleton, poses, (leg.hip, leg.knee, leg.ankle), target, ahead)
    closed = poses.coefficients.copy()
    closed[-1] = closed[0]
    return Clip("walk", time_s, Motor(closed), looped=True)


def test_a_path_passes_its_points_at_an_even_speed(rng):
    points = np.cumsum(rng.uniform(0.3, 1.0, (6, 2)) * [1.0, -0.4], axis=0)
    path = GroundPath(points)
    assert path.length_m >= np.linalg.norm(np.diff(points, axis=0), axis=1).sum() - 1e-9
    at, heading = path.at(np.linspace(0.0, path.length_m, 2001))
    for point in points:
        assert np.linalg.norm(at - point, axis=1).min() < 2e-3
    steps = np.diff(at, axis=0)
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), path.length_m / 2000, rtol=2e-3)
    along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    cosine = np.sum(along[:-1] * steps, axis=1) / np.linalg.norm(steps, axis=1)
    assert np.arccos(np.clip(cosine, -1, 1)).max() < 0.02
    beyond, _ = path.at(path.length_m + 1.0)
    assert np.linalg.norm(beyond - points[-1]) == pytest.approx(1.0)


def test_a_straight_path_is_straight():
    at, heading = GroundPath(np.array([[0, 0], [1, 1], [3, 3.0]])).at([0.0, 1.0, 2.0])
    np.testing.assert_allclose(at[:, 0], at[:, 1], atol=1e-12)
    np.testing.assert_allclose(heading, np.pi / 4, atol=1e-9)


@pytest.mark.parametrize("scale", [1.0, 0.1])
def test_feet_of_a_walk_along_a_bend_neither_slide_nor_sink(skeleton, walk, scale):
    path = GroundPath(scale * np.array([[0, 0], [1.5, 0], [2.5, 1.0], [2.5, 2.5]]))
    made = walk_along(path, walk, skeleton, LEGS, SPEED_M_S, scale=scale, starts=False, stops=False)
    assert made.time_s[-1] == pytest.approx(path.length_m / scale / SPEED_M_S, abs=1 / 60)
    inside = skeleton.world(made.poses)
    plain = skeleton.world(walk.at(made.time_s))
    for leg in LEGS:
        foot = skeleton.index(leg.ankle)
        seen, before = (
            made.plane_T_character.apply(scale * one[:, foot].translation_m) / scale
            for one in (inside, plain)
        )
        standing = find_stances(before, made.time_s)
        assert 0.35 < standing.mean() < 0.7
        worst = 0.0
        for run in np.split(np.arange(len(standing)), np.flatnonzero(np.diff(standing)) + 1):
            if standing[run[0]]:
                worst = max(worst, float(np.ptp(seen[run, :2], axis=0).max()))
        assert worst < 0.01
        assert seen[:, 2].min() > skeleton.rest_world[foot].translation_m[2] - 0.01


def test_the_character_ends_where_the_path_does(skeleton, walk):
    path = GroundPath(np.array([[0, 0], [1, 0.2], [2, 0.0]]))
    made = walk_along(path, walk, skeleton, LEGS, SPEED_M_S)
    ends = made.plane_T_character.translation_m[[0, -1]]
    np.testing.assert_allclose(ends, [[0, 0, 0], [2, 0, 0]], atol=1e-6)


def _feet(skeleton, made) -> np.ndarray:
    """Ankles ``(F, 2, 3)`` in the plane."""
    world = made.plane_T_character.reshape(-1, 1) @ skeleton.world(made.poses)
    return world[:, [skeleton.index(leg.ankle) for leg in LEGS]].translation_m


@pytest.mark.parametrize("far_m", [0.3, 1.0, 1.4, 4.0])
def test_it_starts_from_standing_and_comes_to_stand(skeleton, walk, far_m):
    path = GroundPath(np.array([[0.0, 0.0], [far_m, 0.0]]))
    made = walk_along(path, walk, skeleton, LEGS, SPEED_M_S)
    ways = made.plane_T_character.translation_m[:, 0]
    assert ways[0] == pytest.approx(0.0, abs=1e-9)
    assert ways[-1] == pytest.approx(far_m, abs=1e-9)
    speed = np.diff(ways) * 60.0
    assert speed.min() >= -1e-9
    assert speed.max() < SPEED_M_S + 1e-6
    assert max(speed[0], speed[-1]) < 0.02
    assert np.abs(np.diff(speed)).max() * 60.0 < 1.6 * SPEED_M_S / (0.5 * PERIOD_S)
    feet = _feet(skeleton, made)
    for end, x in ((0, 0.0), (-1, far_m)):
        np.testing.assert_allclose(feet[end, :, 0], x, atol=0.01)
        np.testing.assert_allclose(feet[end, :, 2], 0.04, atol=2e-3)
    for foot in feet.transpose(1, 0, 2):
        low = np.flatnonzero(foot[:, 2] < 0.042)
        for run in np.split(low, np.flatnonzero(np.diff(low) > 1) + 1):
            assert np.ptp(foot[run, 0]) < 0.01
        # Short strides do not walk on the spot: feet hardly go back, 1.2 m/s were they not shorter.
        assert np.diff(foot[:, 0]).min() * 60.0 > -0.4


def test_it_settles_into_what_it_is_told_to_do_standing(skeleton, walk):
    turned = skeleton.rest.coefficients.copy()
    nod = Motor.from_twist([0.0, 0.3, 0.0, 0.0, 0.0, 0.0])
    turned[0] = (skeleton.rest[0] @ nod).coefficients
    idle = Clip("idle", np.zeros(1), Motor(turned[None]))
    path = GroundPath(np.array([[0.0, 0.0], [2.0, 0.0]]))
    made = walk_along(path, walk, skeleton, LEGS, SPEED_M_S, standing=idle)
    for end in (0, -1):
        apart = made.poses[end, 0].rotor.inverse() @ idle.poses[0, 0].rotor
        assert float(apart.angle()) < 1e-6
    middle = made.poses[len(made.time_s) // 2, 0].rotor
    assert float((middle.inverse() @ idle.poses[0, 0].rotor).angle()) > 0.2


def test_it_comes_walking_and_walks_on_where_that_is_wanted(skeleton, walk):
    path = GroundPath(np.array([[0.0, 0.0], [2.0, 0.0]]))
    for starts, stops in ((True, False), (False, True), (False, False)):
        made = walk_along(path, walk, skeleton, LEGS, SPEED_M_S, starts=starts, stops=stops)
        speed = np.diff(made.plane_T_character.translation_m[:, 0]) * 60.0
        assert (speed[0] < 0.02) == starts
        assert (speed[-1] < 0.02) == stops
        still = np.abs(np.diff(_feet(skeleton, made)[-4:], axis=0)).max() * 60.0
        assert (still < 0.05) == stops


def test_refusals(skeleton, walk):
    with pytest.raises(ValueError, match="got 1 and 2 at one place"):
        GroundPath(np.array([[0, 0], [1, 0], [1, 0.0]]))
    path = GroundPath(np.array([[0, 0], [1, 0.0]]))
    once = Clip("once", walk.time_s, walk.poses)
    with pytest.raises(ValueError, match="expected a rigid loop, got 'once'"):
        walk_along(path, once, skeleton, LEGS, 1.0)
    with pytest.raises(ValueError, match=r"walk_along\(legs\): expected legs to start or stop"):
        walk_along(path, walk, skeleton, [], 1.0)
    with pytest.raises(ValueError, match=r"walk_along\(speed_m_s\)"):
        walk_along(path, walk, skeleton, LEGS, 0.0)
