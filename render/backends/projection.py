"""OpenGL's cameras: their axes, near and far planes, and where lights look from.

OpenGL looks along −z with y up, OpenCV along z with y down: half a turn about x lies between.
OpenGL counts pixels from the corner of the top-left one, hence the half pixel added to principal
points.
"""

from __future__ import annotations

import numpy as np

from motorcade.animation.vectors import perpendicular, unit
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.render.scene import Lighting
from motorcade.tracking.cameras.camera import Camera

__all__ = ["FAR_M", "NEAR_M", "OPENCV_T_OPENGL", "looking_along", "projection", "shadow_camera"]

NEAR_M, FAR_M = 0.02, 60.0
OPENCV_T_OPENGL = Motor.from_quaternion_translation((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def projection(camera: Camera) -> FloatArray:
    """OpenGL's projection (4, 4) of a pinhole camera."""
    x, y = camera.cx + 0.5, camera.cy + 0.5
    depth = FAR_M - NEAR_M
    return np.array([
        [2.0 * camera.fx / camera.width, 0.0, 1.0 - 2.0 * x / camera.width, 0.0],
        [0.0, 2.0 * camera.fy / camera.height, 2.0 * y / camera.height - 1.0, 0.0],
        [0.0, 0.0, -(FAR_M + NEAR_M) / depth, -2.0 * FAR_M * NEAR_M / depth],
        [0.0, 0.0, -1.0, 0.0],
    ])  # fmt: skip


def looking_along(direction: FloatArray) -> Rotor:
    """The rotor that turns −z along a direction (3,), as OpenGL's lights and cameras look."""
    back = -unit(direction)
    side = perpendicular(back)
    return Rotor.from_matrix(np.stack([side, np.cross(back, side), back], axis=1))


def shadow_camera(lighting: Lighting) -> tuple[Motor, FloatArray]:
    """From where the shadow map is drawn, and over which depths.

    Returns:
        ``world_T_light`` in OpenGL's axes, and the nearest and farthest distance in metres. The map
        is twice `Lighting.shadow_radius_m` wide and high.
    """
    turn = looking_along(np.array(lighting.sun.direction))
    radius = lighting.shadow_radius_m
    behind = turn.apply(np.array([0.0, 0.0, 2.0 * radius]))
    pose = Motor.from_rotor_translation(turn, np.array(lighting.shadow_center_m) + behind)
    return pose, np.array([0.1 * radius, 8.0 * radius])
