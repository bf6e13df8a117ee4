"""A loop is found where the camera stands again, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.tracking import Camera
from motorcade.tracking.slam.features import find_corners
from motorcade.tracking.slam.mapping.loops import find_loop
from motorcade.tracking.slam.mapping.map import Keyframe, SlamMap

CAMERA = Camera(400, 300, 320.0, 320.0, 199.5, 149.5)
FEATURES = 300
DRIFT = Motor.from_euler_translation(np.array([0.01, -0.02, 0.03]), np.array([0.1, -0.15, 0.05]))


def looking(yaw_rad: float, place_m: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Motor:
    return Motor.from_euler_translation(np.array([0.0, yaw_rad, 0.0]), np.array(place_m))


def add_keyframe(slam_map: SlamMap, view, world_T_camera: Motor, believed: Motor) -> None:
    """All corners of an image as new points, put by its depths where the drifted pose has them."""
    gray, depth_m = view(world_T_camera)
    corners = find_corners(gray, FEATURES)
    column, row = np.rint(corners.px).astype(int).T
    depth = depth_m[row, column].astype(np.float64)
    rays = CAMERA.unproject(corners.px)
    ids = slam_map.add_points(corners.descriptors)
    slam_map.points[ids] = believed.apply(depth[:, None] * rays)
    stamp = len(slam_map.keyframes)
    slam_map.keyframes.append(Keyframe(stamp, believed, ids, corners.px, depth, gray))


def around(view, last: Motor, count: int = 12) -> SlamMap:
    """Once around a room, each view a part of a turn on, and last where `last` says, drifted."""
    slam_map = SlamMap()
    slam_map.metric = [True]
    for yaw in np.linspace(0.0, 2.0 * np.pi, count, endpoint=False):
        add_keyframe(slam_map, view, looking(yaw), looking(yaw))
    add_keyframe(slam_map, view, last, DRIFT @ last)
    return slam_map


def test_where_it_was_before_it_knows_its_place_again(view) -> None:
    """The pose in the old part of the map is the true one, not the drifted one."""
    last = looking(0.03, (0.05, 0.02, 0.04))
    slam_map = around(view, last)
    loop = find_loop(slam_map, FEATURES, CAMERA)
    assert loop is not None
    assert (loop.old, loop.new) == (0, 12)
    found = loop.world_S_new.rigid
    assert float(loop.world_S_new.scale) == pytest.approx(1.0)
    assert np.linalg.norm(found.translation_m - last.translation_m) < 0.02
    assert (found.rotor.inverse() @ last.rotor).angle() < np.deg2rad(0.5)
    assert len(loop.ids) == len(loop.px) >= 40
    seen = CAMERA.project(found.inverse().apply(slam_map.points[loop.ids]))
    error_px = np.linalg.norm(seen - loop.px, axis=1)
    assert np.median(error_px) < 1.0


def test_a_place_it_has_not_seen_is_no_loop(view) -> None:
    """The floor, which no view around showed."""
    down = Motor.from_euler_translation(np.array([0.5 * np.pi, 0.0, 0.0]), np.zeros(3))
    assert find_loop(around(view, down), FEATURES, CAMERA) is None


def test_a_place_seen_a_moment_ago_is_no_loop(view) -> None:
    """Nine keyframes after the same view; ten are the least."""
    last = looking(0.03, (0.05, 0.02, 0.04))
    assert find_loop(around(view, last, 9), FEATURES, CAMERA) is None
    assert find_loop(around(view, last, 10), FEATURES, CAMERA) is not None


@pytest.mark.parametrize("tie", ["itself", "through another"])
def test_what_the_map_ties_already_is_no_loop(view, tie) -> None:
    """The newest keyframe, or one that shares points with it, sees points of all old ones."""
    slam_map = around(view, looking(0.03, (0.05, 0.02, 0.04)))
    newest, between = slam_map.keyframes[-1], slam_map.keyframes[11]
    old = np.concatenate([slam_map.keyframes[row].ids[:20] for row in range(3)])
    (newest if tie == "itself" else between).ids[:60] = old
    if tie != "itself":
        between.ids[60:80] = newest.ids[:20]
    assert find_loop(slam_map, FEATURES, CAMERA) is None


def test_without_its_image_nothing_is_looked_for(view) -> None:
    slam_map = around(view, looking(0.03))
    slam_map.keyframes[-1].gray = None
    assert find_loop(slam_map, FEATURES, CAMERA) is None
