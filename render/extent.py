"""Where in a pinhole camera's picture points and planes of the world lie."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera

__all__ = ["plane_homography", "seen_extent"]


def plane_homography(camera: Camera, camera_T_plane: Motor) -> FloatArray:
    """(3, 3) from (x, y, 1) of a plane z = 0 to depth times (column, row, 1).

    >>> from motorcade.ga import Motor
    >>> from motorcade.render.extent import plane_homography
    >>> from motorcade.tracking.cameras.camera import Camera
    >>> camera = Camera(64, 48, 50.0, 50.0, 31.5, 23.5)
    >>> plane_homography(camera, Motor.from_translation([0, 0, 2.0])) @ [1.0, 0.0, 1.0]
    array([113.,  47.,   2.])
    """
    return np.asarray(camera.matrix @ camera_T_plane.as_matrix()[:3][:, [0, 1, 3]])


def seen_extent(
    camera: Camera, points_m: FloatArray, nearest_m: float, margin_px: float = 0.0
) -> tuple[IntArray, IntArray]:
    """First and last (column, row) that may show the hull of points.

    Args:
        camera: pinhole.
        points_m: (N, 3) in the camera's frame.
        nearest_m: where a point is nearer than this, or behind, the whole picture may show it.
        margin_px: by so much the hull is drawn larger.
    """
    last = np.array([camera.width, camera.height]) - 1
    if np.min(points_m[:, 2]) < nearest_m:
        return np.zeros(2, dtype=np.int64), last
    pixels = camera.project(points_m)
    low = np.clip(np.floor(pixels.min(axis=0) - margin_px), 0, last)
    high = np.clip(np.ceil(pixels.max(axis=0) + margin_px), 0, last)
    return low.astype(np.int64), high.astype(np.int64)
