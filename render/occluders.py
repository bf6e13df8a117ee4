"""What hides a character, and what takes its shadow: flat prints, the ground, what stands on it.

Without measured depth, a board or a marker with a known pose is a rectangle and the ground is a
plane; both have a depth in every picture, and hide things by the same rule as measured depth does.
Measured depth also shows how high things stand on the ground.
"""

from __future__ import annotations

import cv2
import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.lens import plane_homography, seen_extent
from motorcade.render.light.prints import Prints
from motorcade.render.scene import DepthArray
from motorcade.render.shadow import ground_depth
from motorcade.tracking.cameras.camera import Camera

# What has sunk into a plane by less than this is held to stand on it.
SUNK_M = 1e-3
# A rectangle with a corner nearer than this, or behind the camera, has no outline to go by.
NEAREST_M = 0.01
# Planes through the eye, nearly, are seen edge on and hide nothing.
EDGE_ON = 1e12
# A thing is before the ground, and not on it, where it is nearer by this share.
NEARER = 1e-3
# Of the edge between what takes a shadow and what does not.
SOFT_PX = 1.5


def known_depth(
    camera: Camera,
    world_T_camera: Motor,
    figure_m: FloatArray,
    prints: Prints | None,
    world_T_ground: Motor,
) -> DepthArray | None:
    """Depth of the nearest thing that is known without a sensor, in every pixel.

    Args:
        camera: pinhole.
        world_T_camera: its pose, batch shape ().
        figure_m: (C, 3) corners of a hull of what is drawn, world: a plane that has it and the
            camera on one side hides nothing of it and is left out.
        prints: rectangles that hide from both sides.
        world_T_ground: a plane z = 0 without end that hides what lies beneath it; a camera that is
            beneath it itself sees through, for then it is no ground.

    Returns:
        (height, width) float32 metres along the optical axis, 0 where nothing is known; or None
        where nothing can hide the figure.
    """
    nearest = np.full((camera.height, camera.width), np.inf, dtype=np.float32)
    hides = False
    camera_T_world = world_T_camera.inverse()
    eye_m = world_T_camera.translation_m
    if _side(world_T_ground, eye_m) > 0.0 and _between(world_T_ground, eye_m, figure_m):
        hides = True
        nearest[:] = ground_depth(camera, camera_T_world @ world_T_ground)
    for k in range(0 if prints is None else len(prints)):
        assert prints is not None  # counted above
        world_T_print = prints.world_T_print[k]
        if _between(world_T_print, eye_m, figure_m):
            hides = True
            low, high = prints.low_m[k] - prints.margin_m, prints.high_m[k] + prints.margin_m
            _lay(nearest, camera, camera_T_world @ world_T_print, low, high)
    return np.where(np.isfinite(nearest), nearest, np.float32(0.0)) if hides else None


def _side(world_T_plane: Motor, points_m: FloatArray) -> FloatArray:
    """Heights (C,) above a plane, metres."""
    return np.asarray(world_T_plane.inverse().apply(points_m)[..., 2])


def _between(world_T_plane: Motor, eye_m: FloatArray, figure_m: FloatArray) -> bool:
    """Whether any of the figure lies beyond the plane, seen from the eye."""
    towards = 1.0 if _side(world_T_plane, eye_m) >= 0.0 else -1.0
    return bool(np.min(towards * _side(world_T_plane, figure_m)) < -SUNK_M)


def _lay(
    nearest: DepthArray, camera: Camera, camera_T_print: Motor, low: FloatArray, high: FloatArray
) -> None:
    """Take the depth of one rectangle wherever it is nearer than what was there."""
    to_picture = plane_homography(camera, camera_T_print)
    if np.linalg.cond(to_picture) > EDGE_ON:
        return
    corners = [[x, y, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])]
    first, last = seen_extent(camera, camera_T_print.apply(corners), NEAREST_M)
    rows, columns = np.arange(first[1], last[1] + 1), np.arange(first[0], last[0] + 1)
    from_picture = np.linalg.inv(to_picture)
    x, y, inverse_depth = (
        row[0] * columns[None, :] + row[1] * rows[:, None] + row[2] for row in from_picture
    )
    # Over a positive inverse depth, low < x / inverse depth < high needs no division.
    inside = (inverse_depth > 0.0) & (x > low[0] * inverse_depth) & (x < high[0] * inverse_depth)
    inside &= (y > low[1] * inverse_depth) & (y < high[1] * inverse_depth)
    depth_m = (1.0 / inverse_depth[inside]).astype(np.float32)
    region = nearest[first[1] : last[1] + 1, first[0] : last[0] + 1]
    region[inside] = np.minimum(region[inside], depth_m)


def raised(depth_m: DepthArray, ground_m: DepthArray, eye_m: float) -> DepthArray:
    """How high above the ground each pixel's thing is, metres.

    Args:
        depth_m: (height, width) measured, along the optical axis; 0 and NaN are unknown.
        ground_m: of the plane, in the same pixels; infinite at and above the horizon.
        eye_m: the camera's height above the ground.

    Returns:
        (height, width) float32, below 0 beneath the ground, NaN where unknown or where the camera
        is not above the ground.
    """
    known = np.isfinite(depth_m) & (depth_m > 0.0) & (eye_m > 0.0)
    share = np.where(known, depth_m, np.nan) / np.maximum(ground_m, np.finfo(np.float32).tiny)
    return np.asarray(eye_m * (1.0 - share), dtype=np.float32)


def share_on_ground(raised_m: DepthArray, within_m: float) -> FloatArray:
    """How much of a shadow on the ground each pixel takes, by how far from the ground it is.

    All up to half the distance `within_m`, none from half as much again on; what the sensor does
    not tell goes by what is around it, and its noise leaves no ragged edges.
    """
    known = np.isfinite(raised_m)
    share = 1.0 - np.clip(np.abs(np.where(known, raised_m, 0.0)) / within_m - 0.5, 0.0, 1.0)
    weight = cv2.GaussianBlur(known.astype(np.float32), (0, 0), SOFT_PX)
    smooth = cv2.GaussianBlur((share * known).astype(np.float32), (0, 0), SOFT_PX)
    return np.where(weight > 1e-3, smooth / np.maximum(weight, 1e-3), 1.0).astype(np.float64)


def share_beyond(known_m: DepthArray, ground_m: DepthArray) -> FloatArray:
    """How much of each pixel's ground no known thing stands before, softened by a pixel.

    Args:
        known_m: (height, width) of `known_depth`.
        ground_m: of the plane, in the same pixels; infinite at and above the horizon.
    """
    before = (known_m > 0.0) & (known_m < (1.0 - NEARER) * ground_m)
    return np.asarray(1.0 - cv2.GaussianBlur(before.astype(np.float64), (0, 0), 0.5))
