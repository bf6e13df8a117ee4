"""Planes in a depth image: points on a grid of pixels, with the noise and slope of each.

The noise of a depth is that of a structured-light camera, 0.0012 + 0.0019 (z - 0.4)^2 m
(Nguyen, Izadi & Lovell 2012): right for the recordings with real depth, generous for exact ones.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.planes.finding import FEWEST, FoundPlanes, find_planes

__all__ = ["STRIDE", "depth_sigma_m", "find_planes_in_depth"]

STRIDE = 4
# Slopes are taken over so many steps of the grid to each side.
_STEPS = 2


def find_planes_in_depth(
    depth_m: NDArray[np.floating], camera: Camera, rng: np.random.Generator, *, most: int = 6
) -> FoundPlanes:
    """Find the planes of a depth image, in the camera's frame.

    Args:
        depth_m: ``(height, width)`` along the optical axis; NaN, zero and below where unknown.
        camera: whose picture it is.
        rng: of the samples.
        most: how many planes to look for.

    Returns:
        Planes whose normals point to the camera; labels of every fourth pixel of every fourth row,
        ``depth_m[::4, ::4]``.

    Raises:
        ValueError: not of the camera's size, or hardly any depth known.

    >>> import numpy as np
    >>> from motorcade.tracking import Camera, find_planes_in_depth
    >>> camera = Camera(160, 120, 130.0, 130.0, 79.5, 59.5)
    >>> wall = np.full((120, 160), 1.5, np.float32)  # 1.5 m before the camera
    >>> [plane] = find_planes_in_depth(wall, camera, np.random.default_rng(0)).planes
    >>> plane.normal.round(3) + 0.0, round(plane.distance_m, 3)  # it faces the camera
    (array([ 0.,  0., -1.]), -1.5)
    """
    if depth_m.shape != (camera.height, camera.width):
        raise ValueError(
            f"depth_m: expected shape {(camera.height, camera.width)}, got {depth_m.shape}"
        )
    depth = np.asarray(depth_m[::STRIDE, ::STRIDE], dtype=np.float64)
    rows, columns = np.mgrid[0 : camera.height : STRIDE, 0 : camera.width : STRIDE]
    with np.errstate(invalid="ignore"):
        depth = np.where(np.isfinite(depth) & (depth > 0.0), depth, np.nan)
    points = camera.unproject(np.stack([columns, rows], axis=-1)) * depth[..., None]
    normals = _normals(points)
    known = np.isfinite(normals[..., 0])
    if np.count_nonzero(known) < FEWEST:
        raise ValueError(
            f"depth_m: expected surfaces to see, got {np.count_nonzero(np.isfinite(depth))} "
            f"pixels with depth among {depth.size}"
        )
    found = find_planes(
        points[known],
        depth_sigma_m(depth[known]),
        rng,
        normals=normals[known],
        most=most,
    )
    labels = np.full(depth.shape, -1, dtype=np.int64)
    labels[known] = found.labels
    return FoundPlanes(found.planes, labels)


def depth_sigma_m(depth_m: FloatArray) -> FloatArray:
    """Noise of depths, metres."""
    return np.asarray(0.0012 + 0.0019 * (depth_m - 0.4) ** 2)


def _normals(points: FloatArray) -> FloatArray:
    """Unit normals ``(h, w, 3)`` of a grid of points; NaN at its rim, beside gaps and at points.

    Where the surface jumps, the slope between its sides is no plane's nearby.
    """
    normals = np.full(points.shape, np.nan)
    step = _STEPS
    if min(points.shape[:2]) <= 2 * step:
        return normals
    along = points[step:-step, 2 * step :] - points[step:-step, : -2 * step]
    down = points[2 * step :, step:-step] - points[: -2 * step, step:-step]
    normal = np.cross(along, down)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = normal / length
    own = np.isfinite(points[step:-step, step:-step])
    normals[step:-step, step:-step] = np.where(own & np.isfinite(normal), normal, np.nan)
    return normals
