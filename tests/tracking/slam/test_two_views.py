"""Two views: the motion between them, refused where none can be told, and depth of stereo pairs."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import Camera
from motorcade.tracking.slam.features import find_corners, stereo_depth
from motorcade.tracking.slam.geometry import flow_beyond_rotation_px, two_views

CAMERA = Camera(400, 300, 320.0, 320.0, 199.5, 149.5)


def seen(points_m: FloatArray, camera_T_world: Motor) -> FloatArray:
    return CAMERA.project(camera_T_world.apply(points_m))


def scattered(rng: np.random.Generator, count: int = 300) -> FloatArray:
    """Points before a camera at the origin, from two to six metres away."""
    across = rng.uniform([-0.5, -0.4], [0.5, 0.4], (count, 2))
    return rng.uniform(2.0, 6.0, (count, 1)) * np.column_stack([across, np.ones(count)])


def flat(rng: np.random.Generator, count: int = 300) -> FloatArray:
    """Points on a wall that leans."""
    across = rng.uniform([-2.0, -1.5], [2.0, 1.5], (count, 2))
    return np.column_stack([across, 4.0 + 0.5 * across[:, 0] - 0.3 * across[:, 1]])


@pytest.mark.parametrize(
    ("scene", "model", "shift_m"),
    [(scattered, "essential", [-0.5, 0.1, 0.15]), (flat, "homography", [0.0, 0.5, 0.0])],
)
def test_the_motion_is_found_but_for_its_length(scene, model, shift_m, rng):
    points = scene(rng)
    second_T_first = Motor.from_euler_translation(np.array([0.05, -0.08, 0.03]), np.array(shift_m))
    first_px, px = seen(points, Motor.identity()), seen(points, second_T_first)
    wrong = rng.choice(len(px), 30, replace=False)
    found_px = px + rng.normal(0.0, 0.2, px.shape)
    found_px[wrong] += rng.uniform(20.0, 60.0, (30, 2))
    found = two_views(first_px, found_px, CAMERA)
    assert found is not None
    assert found.model == model
    found_second_T_first = found.first_T_second.inverse()
    apart = found_second_T_first.rotor.inverse() @ second_T_first.rotor
    assert apart.angle() < np.deg2rad(0.5)
    way = found_second_T_first.translation_m
    assert np.linalg.norm(way) == pytest.approx(1.0)
    true_way = second_T_first.translation_m
    assert way @ true_way / np.linalg.norm(true_way) > np.cos(np.deg2rad(3.0))
    assert not np.any(found.good[wrong])
    assert np.mean(np.delete(found.good, wrong)) > 0.9


def test_a_wall_that_two_motions_explain_tells_none(rng):
    """Of a plane two solutions remain; along this way all points lie before both cameras."""
    points = flat(rng)
    moved = Motor.from_euler_translation(np.array([0.05, -0.08, 0.03]), np.array([-0.5, 0.1, 0.15]))
    noise = rng.normal(0.0, 0.2, (len(points), 2))
    assert two_views(seen(points, Motor.identity()), seen(points, moved) + noise, CAMERA) is None


def test_a_turn_on_the_spot_leaves_no_flow_and_tells_no_motion(rng):
    points = scattered(rng)
    turn = Motor.from_euler_translation(np.array([0.1, 0.15, -0.05]), np.zeros(3))
    first_px, px = seen(points, Motor.identity()), seen(points, turn)
    assert flow_beyond_rotation_px(first_px, px, CAMERA) < 1e-6
    assert two_views(first_px, px + rng.normal(0.0, 0.2, px.shape), CAMERA) is None
    moved = seen(points, Motor.from_euler_translation(np.array([0.1, 0.15, -0.05]), [0.5, 0, 0]))
    assert flow_beyond_rotation_px(first_px, moved, CAMERA) > 4.0


def test_few_corners_and_corners_that_do_not_agree_tell_no_motion(rng):
    points = scattered(rng)
    shift = Motor.from_euler_translation(np.zeros(3), np.array([0.5, 0.0, 0.0]))
    first_px, px = seen(points, Motor.identity()), seen(points, shift)
    assert two_views(first_px[:80], px[:80], CAMERA) is not None
    assert two_views(first_px[:79], px[:79], CAMERA) is None
    assert two_views(first_px, rng.permutation(px), CAMERA) is None


def test_depths_of_a_stereo_pair_are_those_that_were_drawn(view):
    """The room, and the room again from 12 cm to the right."""
    baseline_m = 0.12
    left, depth_m = view(Motor.identity())
    right, _ = view(Motor.from_euler_translation(np.zeros(3), np.array([baseline_m, 0.0, 0.0])))
    px = find_corners(left, 200).px
    found = stereo_depth(left, right, px, 320.0 * baseline_m)
    rows = np.rint(px).astype(int)
    true = depth_m[rows[:, 1], rows[:, 0]]
    told = np.isfinite(found)
    assert np.mean(told) > 0.7
    assert np.median(np.abs(found[told] / true[told] - 1.0)) < 0.02
    # an image that did not move shows nothing at a finite distance
    assert np.all(np.isnan(stereo_depth(left, left, px, 320.0 * baseline_m)))
    assert stereo_depth(left, right, px[:0], 1.0).shape == (0,)
