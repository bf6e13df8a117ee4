"""Bundle adjustment: poses and points that agree best with all pixels and depths.

Levenberg-Marquardt with Huber weights; the points are eliminated (Schur complement) in blocks of
dense algebra, which for the ten keyframes of a window is many times faster than a general factor
graph, and sums in one order, so that the same input gives the same bytes.

Sources: Triggs et al. 2000; Huber 1964; depth as disparity: Mur-Artal & Tardos 2017.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import FloatArray, IntArray
from motorcade.tracking.slam.geometry import BoolArray, exp

__all__ = ["Adjusted", "Bundle", "adjust"]

_HUBER = 1.5
_BLOCK = 256
_SMALL = 32


@dataclass(frozen=True, eq=False)
class Bundle:
    """Everything one adjustment works on.

    Args:
        poses: ``(k, 4, 4)`` camera_T_world; fixed: ``(k,)`` those that stay.
        points: ``(p, 3)``.
        pose_of, point_of: ``(n,)`` whom each observation belongs to; a pair stands at most once.
        px: ``(n, 2)`` pixels; depth: ``(n,)`` NaN where none was measured.
        matrix: ``(3, 3)`` intrinsics.
        disparity_px_m: focal length times baseline, by which depths are compared.
        depth_sigma_px: noise of that disparity where a pixel's coordinate has 1.
    """

    poses: FloatArray
    fixed: BoolArray
    points: FloatArray
    pose_of: IntArray
    point_of: IntArray
    px: FloatArray
    depth: FloatArray
    matrix: FloatArray
    disparity_px_m: float
    depth_sigma_px: float


@dataclass(frozen=True, eq=False)
class Adjusted:
    """The result: poses, points, and how far each observation ends from its pixel.

    Args:
        poses: ``(k, 4, 4)``; points: ``(p, 3)``.
        error_px: ``(n,)``, infinite where the point lies behind the camera.
        cost: sum of Huber's losses at the end; before: at the start.
    """

    poses: FloatArray
    points: FloatArray
    error_px: FloatArray
    cost: float
    before: float


@dataclass(frozen=True, eq=False)
class _Linear:
    residuals: FloatArray  # (n, 3), weighted
    by_pose: FloatArray  # (n, 3, 6), weighted
    by_point: FloatArray  # (n, 3, 3), weighted


def adjust(bundle: Bundle, iterations: int = 8) -> Adjusted:
    """Minimise Huber's loss of pixels and depths over the free poses and all points.

    With one fixed pose and no depths the scale is free; the damping then leaves it where it was.
    """
    poses, points = np.array(bundle.poses), np.array(bundle.points)
    damping = 1e-4
    residuals = _residuals(bundle, poses, points)[0]
    cost = before = _loss(residuals)
    for _ in range(iterations):
        linear = _linearised(bundle, poses, points)
        improved = False
        for _ in range(4):
            pose_step, point_step = _step(bundle, linear, damping)
            tried = exp(pose_step) @ poses
            tried_points = points + point_step
            tried_cost = _loss(_residuals(bundle, tried, tried_points)[0])
            if tried_cost < cost:
                improved = True
                break
            damping *= 10.0
        if not improved:
            break
        gain = cost - tried_cost
        poses, points, cost = tried, tried_points, tried_cost
        damping = max(0.1 * damping, 1e-9)
        if gain < 1e-4 * cost:
            break
    residuals, in_camera = _residuals(bundle, poses, points)
    error = np.linalg.norm(residuals[:, :2], axis=-1)
    return Adjusted(poses, points, np.where(in_camera[:, 2] > 0.0, error, np.inf), cost, before)


def _residuals(
    bundle: Bundle, poses: FloatArray, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Residuals ``(n, 3)``: two of the pixel, one of the depth; and points in the camera."""
    own = poses[bundle.pose_of]
    in_camera = (own[:, :3, :3] @ points[bundle.point_of][..., None])[..., 0] + own[:, :3, 3]
    depth = np.where(in_camera[:, 2] > 1e-3, in_camera[:, 2], 1e-3)
    residuals = np.empty((len(depth), 3))
    for axis in (0, 1):
        focal, centre = bundle.matrix[axis, axis], bundle.matrix[axis, 2]
        residuals[:, axis] = focal * in_camera[:, axis] / depth + centre - bundle.px[:, axis]
    disparity = bundle.disparity_px_m / bundle.depth_sigma_px
    residuals[:, 2] = np.nan_to_num(disparity / depth - disparity / bundle.depth)
    return residuals, in_camera


def _norms(residuals: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.linalg.norm(residuals[:, :2], axis=-1), np.abs(residuals[:, 2])


def _loss(residuals: FloatArray) -> float:
    total = 0.0
    for norm in _norms(residuals):
        inside = np.minimum(norm, _HUBER)
        total += float(np.sum(inside * (norm - 0.5 * inside)))
    return total


def _linearised(bundle: Bundle, poses: FloatArray, points: FloatArray) -> _Linear:
    residuals, in_camera = _residuals(bundle, poses, points)
    depth = np.where(in_camera[:, 2] > 1e-3, in_camera[:, 2], 1e-3)
    jacobian = np.zeros((len(depth), 3, 3))
    for axis in (0, 1):
        jacobian[:, axis, axis] = bundle.matrix[axis, axis] / depth
        jacobian[:, axis, 2] = -jacobian[:, axis, axis] * in_camera[:, axis] / depth
    slope = -bundle.disparity_px_m / bundle.depth_sigma_px / depth**2
    jacobian[:, 2, 2] = np.where(np.isfinite(bundle.depth), slope, 0.0)
    pixel, along = (np.sqrt(_HUBER / np.maximum(norm, _HUBER)) for norm in _norms(residuals))
    weight = np.stack([pixel, pixel, along], axis=-1)
    jacobian *= weight[..., None]
    x, y, z = (in_camera[:, None, axis] for axis in range(3))
    a, b, c = (jacobian[..., axis] for axis in range(3))
    turning = np.stack([y * c - z * b, z * a - x * c, x * b - y * a], axis=-1)
    by_pose = np.concatenate([turning, jacobian], axis=-1)
    return _Linear(residuals * weight, by_pose, jacobian @ poses[bundle.pose_of][:, :3, :3])


def _summed(values: FloatArray, owner: IntArray, count: int) -> FloatArray:
    """Sum rows ``(n, …)`` by owner, in the order of the rows."""
    flat = values.reshape(len(values), -1)
    order = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[order], np.arange(count))
    sums = np.zeros((count, flat.shape[1]))
    present = np.flatnonzero(np.bincount(owner, minlength=count))
    sums[present] = np.add.reduceat(flat[order], starts[present], axis=0)
    return sums.reshape(count, *values.shape[1:])


def _step(bundle: Bundle, linear: _Linear, damping: float) -> tuple[FloatArray, FloatArray]:
    """Damped Gauss-Newton step of poses ``(k, 6)`` and points ``(p, 3)``."""
    k, p = len(bundle.poses), len(bundle.points)
    turned, shifted = (np.swapaxes(j, -1, -2) for j in (linear.by_pose, linear.by_point))
    residuals = linear.residuals[..., None]
    pose_hessian = _summed(turned @ linear.by_pose, bundle.pose_of, k)
    pose_gradient = _summed((turned @ residuals)[..., 0], bundle.pose_of, k)
    point_hessian = _damped(_summed(shifted @ linear.by_point, bundle.point_of, p), damping)
    point_gradient = _summed((shifted @ residuals)[..., 0], bundle.point_of, p)
    inverted = np.linalg.inv(point_hessian)
    free = np.flatnonzero(~bundle.fixed)
    slot = np.full(k, -1)
    slot[free] = np.arange(len(free))
    system = np.zeros((6 * len(free), 6 * len(free)))
    for index, pose in enumerate(free):
        at = slice(6 * index, 6 * index + 6)
        system[at, at] = _damped(pose_hessian[pose], damping)
    right = pose_gradient[free].ravel()
    blocks = _crossed(bundle, shifted @ linear.by_pose, slot)
    for points, columns, cross in blocks:
        scaled = inverted[points] @ cross
        system[np.ix_(columns, columns)] -= _product(cross, scaled)
        right[columns] -= np.einsum("pij,pi->j", scaled, point_gradient[points])
    pose_step = np.zeros((k, 6))
    if len(free):
        pose_step[free] = -np.linalg.solve(system, right).reshape(-1, 6)
    pull = point_gradient.copy()
    for points, columns, cross in blocks:
        pull[points] += cross @ pose_step[free].ravel()[columns]
    return pose_step, -(inverted @ pull[..., None])[..., 0]


def _crossed(
    bundle: Bundle, cross: FloatArray, slot: IntArray
) -> list[tuple[slice, IntArray, FloatArray]]:
    """Blocks of points, columns ``(6 f,)`` of the f free poses that see any of them, and their
    coupling ``(block, 3, 6 f)``.

    Points made one after the other are seen by few poses, so a long path costs no more than the
    sum of its parts.
    """
    usable = slot[bundle.pose_of] >= 0
    pose_of, point_of = slot[bundle.pose_of[usable]], bundle.point_of[usable]
    order = np.argsort(point_of, kind="stable")
    pose_of, point_of, cross = pose_of[order], point_of[order], cross[usable][order]
    blocks = []
    for start in range(0, len(bundle.points), _BLOCK):
        stop = min(start + _BLOCK, len(bundle.points))
        mine = slice(*np.searchsorted(point_of, (start, stop)))
        seeing, place = np.unique(pose_of[mine], return_inverse=True)
        block = np.zeros((stop - start, 3, len(seeing), 6))
        block[point_of[mine] - start, :, place] = cross[mine]
        columns = (6 * seeing[:, None] + np.arange(6)).ravel()
        blocks.append((slice(start, stop), columns, block.reshape(stop - start, 3, len(columns))))
    return blocks


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Sum of ``a^T b`` over the blocks' points, in products so small that BLAS starts no threads.

    Threads cost more than they bring here, and sums would depend on how many there are.
    """
    count = -len(a) % _SMALL
    groups = []
    for one in (a, b):
        padded = np.concatenate([one, np.zeros((count, *one.shape[1:]))]) if count else one
        groups.append(padded.reshape(-1, 3 * _SMALL, one.shape[-1]))
    products: FloatArray = np.matmul(groups[0].transpose(0, 2, 1), groups[1]).sum(axis=0)
    return products


def _damped(hessian: FloatArray, damping: float) -> FloatArray:
    diagonal = np.einsum("...ii->...i", hessian)
    damped: FloatArray = hessian + (damping * diagonal + 1e-9)[..., None] * np.eye(
        hessian.shape[-1]
    )
    return damped
