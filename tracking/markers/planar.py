"""Both poses of many squares at once, by infinitesimal plane-based pose estimation (IPPE).

Source: T. Collins and A. Bartoli, Infinitesimal plane-based pose estimation, IJCV 109 (2014): the
homography's derivative at the square's centre has two rotations; translations follow linearly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.pose import ASIDE_COSINE

_LEAST_DEPTH = 1e-9
_LARGEST_CONDITION = 1e15


def planar_poses(
    camera: Camera, corners_px: FloatArray, side_m: FloatArray
) -> tuple[IntArray, Motor, FloatArray]:
    """Both planar poses of markers ``(n, 4, 2)`` with sides ``(n,)``, where there are any.

    Returns:
        rows ``(m,)`` of those that have poses, camera_T_marker Motor ``(m, 2)`` with the better
        reprojection first, and their reprojection errors ``(m, 2)`` in pixels. The others have
        corners through which the lens model has no ray, or that no planar pose explains.
    """
    rays, view = _views(camera.bearings(corners_px))
    rows = np.flatnonzero(np.isfinite(rays).all((-1, -2)) & _convex(rays))
    points = marker_points_m(side_m[rows])
    centre = points.mean(axis=-2)
    flat = (points - centre[:, None])[..., :2]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rotation = _rotations(_homographies(flat / side_m[rows, None, None], rays[rows]))
        translation = _translations(rotation, flat, rays[rows])
    translation = translation - (rotation @ centre[:, None, :, None])[..., 0]
    fits = np.isfinite(rotation).all((-1, -2, -3)) & np.isfinite(translation).all((-1, -2))
    view = view[rows][:, None]
    matrix = np.zeros((len(rows), 2, 4, 4))
    matrix[..., :3, :3], matrix[..., 3, 3] = view @ rotation, 1.0
    matrix[..., :3, 3] = (view @ translation[..., None])[..., 0]
    rows, matrix, points = rows[fits], matrix[fits], points[fits]
    poses = Motor.from_matrix(matrix)
    residuals = camera.project(poses[..., None].apply(points[:, None])) - corners_px[rows, None]
    errors = np.sqrt(np.mean(np.sum(residuals**2, axis=-1), axis=-1))
    seen = np.isfinite(errors).any(axis=-1)
    errors = np.where(np.isfinite(errors), errors, np.inf)
    order = np.argsort(errors, axis=-1, kind="stable")
    first = np.arange(len(rows))[:, None]
    poses = Motor(poses.coefficients[first, order])
    return rows[seen], poses[seen], errors[first, order][seen]


def _views(bearings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rays ``(n, 4, 2)`` of unit depth, and the view they are in, as rotations ``(n, 3, 3)``.

    It is the camera's but for corners far aside: there, one turned to look at the marker. NaN where
    they do not lie within one view.
    """
    view = np.tile(np.eye(3), (len(bearings), 1, 1))
    aside = np.flatnonzero(bearings[..., 2].min(axis=-1, initial=1.0) < ASIDE_COSINE)
    middle = bearings[aside].mean(axis=-2)
    view[aside] = _to_ray(middle / np.linalg.norm(middle, axis=-1, keepdims=True))
    seen = bearings @ view
    ahead = seen[..., 2:] >= ASIDE_COSINE
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(ahead, seen[..., :2] / seen[..., 2:], np.nan), view


def _convex(rays: FloatArray) -> NDArray[np.bool_]:
    """Whether four rays go round without a corner on, or beyond, the line of its neighbours."""
    sides = np.roll(rays, -1, axis=-2) - rays
    after = np.roll(sides, -1, axis=-2)
    turns = sides[..., 0] * after[..., 1] - sides[..., 1] * after[..., 0]
    return np.asarray(np.abs(np.sign(turns).sum(axis=-1)) == 4)


def _homographies(flat: FloatArray, rays: FloatArray) -> FloatArray:
    """``(n, 3, 3)`` from the plane of a square with sides 1 to that of the rays, last entry 1."""
    x, y = flat[..., 0], flat[..., 1]
    zero, unit = np.zeros_like(x), np.ones_like(x)
    u, v = rays[..., 0], rays[..., 1]
    above = np.stack([x, y, unit, zero, zero, zero, -u * x, -u * y], axis=-1)
    below = np.stack([zero, zero, zero, x, y, unit, -v * x, -v * y], axis=-1)
    matrix = np.concatenate([above, below], axis=-2)
    entries = _solved(matrix, np.concatenate([u, v], axis=-1)[..., None])[..., 0]
    return np.concatenate([entries, np.ones((len(entries), 1))], axis=-1).reshape(-1, 3, 3)


def _rotations(homography: FloatArray) -> FloatArray:
    """Both ``(n, 2, 3, 3)``, camera from square."""
    p, q = homography[:, 0, 2], homography[:, 1, 2]
    derivative = homography[:, :2, :2] - homography[:, :2, 2:] * homography[:, 2:, :2]
    length = np.sqrt(p * p + q * q + 1.0)
    turn = _to_ray(np.stack([p, q, np.ones_like(p)], axis=-1) / length[:, None])
    view = np.zeros((len(p), 2, 3))
    view[:, 0, 0] = view[:, 1, 1] = 1.0
    view[:, 0, 2], view[:, 1, 2] = -p, -q
    affine = np.asarray(np.linalg.solve(view @ turn[:, :, :2], derivative), np.float64)
    upper = affine / _largest_stretch(affine)[:, None, None]
    lower = np.sqrt(np.maximum(1.0 - np.sum(upper**2, axis=-2), 0.0))
    opposite = np.sum(upper[:, :, 0] * upper[:, :, 1], axis=-1) > 0.0
    lower[:, 1] = np.where(opposite, -lower[:, 1], lower[:, 1])
    rotations = np.empty((len(p), 2, 3, 3))
    for which, sign in enumerate((1.0, -1.0)):
        columns = np.concatenate([upper, sign * lower[:, None]], axis=-2)
        third = np.cross(columns[..., 0], columns[..., 1])
        rotations[:, which] = turn @ np.concatenate([columns, third[..., None]], axis=-1)
    return _orthonormal(rotations)


def _largest_stretch(matrix: FloatArray) -> FloatArray:
    """The largest singular value of matrices ``(n, 2, 2)``; NaN stays NaN."""
    square = matrix.swapaxes(-1, -2) @ matrix
    first, second, mixed = square[:, 0, 0], square[:, 1, 1], square[:, 0, 1]
    return np.sqrt(0.5 * (first + second + np.hypot(first - second, 2.0 * mixed)))


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Of systems ``(..., k, k)``; NaN where one is singular, as of a marker shrunk to a point."""
    try:
        return np.asarray(np.linalg.solve(matrix, right), np.float64)
    except np.linalg.LinAlgError:
        finite = np.isfinite(matrix).all((-1, -2), keepdims=True)
        condition = np.linalg.cond(np.where(finite, matrix, 0.0))[..., None, None]
        regular = condition < _LARGEST_CONDITION
        solution = np.linalg.solve(np.where(regular, matrix, np.eye(matrix.shape[-1])), right)
        return np.where(regular, solution, np.nan)


def _orthonormal(matrix: FloatArray) -> FloatArray:
    """The nearest rotations, against what rounding and noise left of columns that are not."""
    finite = np.isfinite(matrix).all((-1, -2), keepdims=True)
    left, _, right = np.linalg.svd(np.where(finite, matrix, np.eye(3)))
    return np.where(finite, left @ right, np.nan)


def _to_ray(ray: FloatArray) -> FloatArray:
    """Rotations ``(n, 3, 3)`` that take z to unit vectors ``(n, 3)``, none of which is -z."""
    x, y, z = np.moveaxis(ray, -1, 0)
    more = 1.0 / (1.0 + z)
    rows = [[1.0 - x * x * more, -x * y * more, x], [-x * y * more, 1.0 - y * y * more, y]]
    rows.append([-x, -y, z])
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _translations(rotation: FloatArray, flat: FloatArray, rays: FloatArray) -> FloatArray:
    """``(n, 2, 3)``, by least squares in the plane of the rays."""
    turned = np.einsum("nkij,ncj->nkci", rotation[..., :2], flat)
    u, v = rays[:, None, :, 0], rays[:, None, :, 1]
    unit, zero = np.ones_like(u), np.zeros_like(u)
    matrix = np.concatenate(
        [np.stack([unit, zero, -u], axis=-1), np.stack([zero, unit, -v], axis=-1)], axis=-2
    )
    right = np.concatenate(
        [u * turned[..., 2] - turned[..., 0], v * turned[..., 2] - turned[..., 1]], axis=-1
    )
    normal = matrix.swapaxes(-1, -2) @ matrix
    pull = matrix.swapaxes(-1, -2) @ np.broadcast_to(right[..., None], (*rotation.shape[:2], 8, 1))
    translation = _solved(np.broadcast_to(normal, (*rotation.shape[:2], 3, 3)), pull)[..., 0]
    return np.where(translation[..., 2:] > _LEAST_DEPTH, translation, np.nan)
