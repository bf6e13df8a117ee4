"""Where points of the world appear in a picture, and how that changes with pose and points.

The one derivative of reprojection. A pose is perturbed by a twist in its own frame,
``world_T_camera.retract(twist)``: rotation (rad), then translation (m). The derivative by a pose
elsewhere in a chain follows by the adjoint of what lies between: a twist of the rig in
``world_T_rig @ rig_T_camera`` moves the camera by ``camera_T_rig.adjoint() @ twist``.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera

__all__ = ["by_twist", "project", "reproject", "to_frame"]


def project(
    camera: Camera, world_T_camera: Motor, points_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Pixels ``(n, 2)`` and depths ``(n,)`` of points ``(n, 3)`` of the world, NaN passed on.

    Pixels are NaN where `Camera.project` gives NaN, and where a point is NaN.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.cameras.camera import Camera
    >>> from motorcade.tracking.cameras.reprojection import project
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> one_metre_back = Motor.from_twist([0.0, 0.0, 0.0, 0.0, 0.0, -1.0])
    >>> project(camera, one_metre_back, np.array([[0.1, 0.0, 0.0]]))
    (array([[369.5, 239.5]]), array([1.]))
    """
    in_camera = to_frame(world_T_camera, points_m)
    return camera.project(in_camera, allow_nan=True), in_camera[:, 2]


def to_frame(world_T_frame: Motor, points_m: FloatArray) -> FloatArray:
    """Points ``(*, 3)`` of the world in a frame, NaN passed on (`Motor.apply` refuses it)."""
    pose = world_T_frame.as_matrix()
    in_frame: FloatArray = (points_m - pose[:3, 3]) @ pose[:3, :3]
    return in_frame


def reproject(camera: Camera, in_camera: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pixels of points ``(*, 3)`` in the camera's frame, and the derivatives.

    Returns:
        pixels ``(*, 2)``, their derivative ``(*, 2, 6)`` by the twist of the camera's pose, and
        ``(*, 2, 3)`` by the point in the camera's frame; NaN where a point has no image.
    """
    pixels, by_point = camera.project_jacobian(in_camera)
    return pixels, by_twist(in_camera, by_point), by_point


def by_twist(in_camera: FloatArray, by_point: FloatArray) -> FloatArray:
    """Derivative ``(*, r, 6)`` by the twist of the camera's pose, of r numbers of a point.

    Args:
        in_camera: ``(*, 3)`` the point, which moves by ``X x d(rotation) - d(translation)``.
        by_point: ``(*, r, 3)`` derivative of the numbers by it.
    """
    x, y, z = (in_camera[..., None, axis] for axis in range(3))
    a, b, c = (by_point[..., axis] for axis in range(3))
    found = np.empty((*by_point.shape[:-1], 6))
    found[..., 0] = z * b - y * c
    found[..., 1] = x * c - z * a
    found[..., 2] = y * a - x * b
    np.negative(by_point, out=found[..., 3:])
    return found
