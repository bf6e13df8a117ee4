"""Projection, triangulation and the pose of one picture, in arrays: what every part of SLAM shares.

Poses here are ``camera_T_world`` as 4 by 4 matrices, the camera is an undistorted pinhole, points
are metres (or the free unit of a monocular map). A step is ``(6,)``: rotation (rad), then
translation, applied on the left, ``exp(step) camera_T_world``; so its covariance is also that of
the right perturbation of ``world_T_camera``.

Sources: Hartley & Zisserman 2003, ch. 12; Huber 1964; Barath et al. 2020 (MAGSAC++, in OpenCV).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import FloatArray, Motor

__all__ = [
    "PosedPicture",
    "exp",
    "inverse",
    "moved",
    "parallax_rad",
    "pose_by_sampling",
    "project",
    "refine_pose",
    "triangulate",
]

BoolArray = NDArray[np.bool_]

HUBER_PX = 1.5
OUTLIER_PX = 3.0
_SIGMA_FLOOR_PX = 0.3
_ITERATIONS = 10
_NEAREST = 1e-6
_SAMPLES = 300
_FEWEST = 6


@dataclass(frozen=True, eq=False)
class PosedPicture:
    """A pose fitted to points and their pixels.

    Args:
        camera_T_world: ``(4, 4)``.
        covariance: ``(6, 6)``, rotation (rad) then translation, of the step.
        inliers: ``(n,)`` which points the pose explains within `OUTLIER_PX`.
        error_px: root mean square reprojection error of the inliers.
    """

    camera_T_world: FloatArray
    covariance: FloatArray
    inliers: BoolArray
    error_px: float


def exp(step: FloatArray) -> FloatArray:
    """Matrices ``(*, 4, 4)`` of steps ``(*, 6)``."""
    return Motor.from_twist(step).as_matrix()


def inverse(pose: FloatArray) -> FloatArray:
    """Invert rigid matrices ``(*, 4, 4)``."""
    turned = np.swapaxes(pose[..., :3, :3], -1, -2)
    inverted = np.zeros_like(pose)
    inverted[..., :3, :3] = turned
    inverted[..., :3, 3] = -(turned @ pose[..., :3, 3:])[..., 0]
    inverted[..., 3, 3] = 1.0
    return inverted


def moved(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Points ``(n, 3)`` moved by one pose ``(4, 4)``."""
    return points @ pose[:3, :3].T + pose[:3, 3]


def project(
    camera_T_world: FloatArray, points: FloatArray, matrix: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Pixels ``(n, 2)`` and depths ``(n,)``; pixels are NaN where the depth is not above zero."""
    return to_pixels(moved(camera_T_world, points), matrix)


def to_pixels(points_camera: FloatArray, matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """As `project`, of points ``(n, 3)`` in the camera's frame."""
    depth = points_camera[:, 2]
    safe = np.where(depth > _NEAREST, depth, np.nan)[:, None]
    focal, centre = matrix[(0, 1), (0, 1)], matrix[:2, 2]
    return points_camera[:, :2] / safe * focal + centre, depth


def triangulate(
    first: FloatArray, second: FloatArray, px: FloatArray, other_px: FloatArray, matrix: FloatArray
) -> FloatArray:
    """Points ``(n, 3)`` seen at pixels ``(n, 2)`` from two poses; linear, all at once."""
    rows = []
    to_plane = np.linalg.inv(matrix)
    for pose, pixels in ((first, px), (second, other_px)):
        plane = pixels @ to_plane[:2, :2].T + to_plane[:2, 2]
        rows += [plane[:, k, None] * pose[2] - pose[k] for k in (0, 1)]
    system = np.stack(rows, axis=1)
    system = system / np.linalg.norm(system, axis=-1, keepdims=True)
    # The smallest eigenvector of A^T A: four by four, and far faster than a batch of SVDs.
    _, vectors = np.linalg.eigh(np.swapaxes(system, -1, -2) @ system)
    homogeneous = vectors[..., 0]
    scale = np.where(np.abs(homogeneous[:, 3:]) > 1e-12, homogeneous[:, 3:], np.nan)
    points: FloatArray = homogeneous[:, :3] / scale
    return points


def parallax_rad(first: FloatArray, second: FloatArray, points: FloatArray) -> FloatArray:
    """Angles ``(n,)`` between the rays from two camera centres to the points."""
    a, b = (points - inverse(pose)[:3, 3] for pose in (first, second))
    cosine = np.sum(a * b, axis=-1) / (np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1))
    angle: FloatArray = np.arccos(np.clip(cosine, -1.0, 1.0))
    return angle


def refine_pose(
    camera_T_world: FloatArray, points: FloatArray, px: FloatArray, matrix: FloatArray
) -> PosedPicture:
    """Least squares (Huber) of the reprojection error, from a pose that is near.

    Args:
        camera_T_world: the start, ``(4, 4)``.
        points: ``(n, 3)``.
        px: ``(n, 2)`` where they were seen.
        matrix: ``(3, 3)`` intrinsics.

    Points behind the camera count as outliers. With fewer than six inliers, or points that do not
    fix the pose, the covariance is infinite.
    """
    pose = np.array(camera_T_world)
    for _ in range(_ITERATIONS):
        residuals, jacobian, weight = _linearised(pose, points, px, matrix)
        weighted = jacobian * weight[:, None, None]
        normal = np.einsum("nij,nik->jk", weighted, jacobian)
        gradient = np.einsum("nij,ni->j", weighted, residuals)
        try:
            step = -np.linalg.solve(normal + 1e-9 * np.diag(np.diag(normal)), gradient)
        except np.linalg.LinAlgError:
            break
        pose = exp(step) @ pose
        if float(np.abs(step).max()) < 1e-7:
            break
    return _described(pose, points, px, matrix)


def _described(
    pose: FloatArray, points: FloatArray, px: FloatArray, matrix: FloatArray
) -> PosedPicture:
    _, jacobian, _ = _linearised(pose, points, px, matrix)
    seen, _ = project(pose, points, matrix)
    error = np.linalg.norm(seen - px, axis=-1)
    inliers = np.nan_to_num(error, nan=np.inf) <= OUTLIER_PX
    count = int(np.count_nonzero(inliers))
    covariance = np.full((6, 6), np.inf)
    rms = float(np.sqrt(np.mean(error[inliers] ** 2))) if count else float("inf")
    if count >= _FEWEST:
        used = jacobian[inliers]
        normal = np.einsum("nij,nik->jk", used, used)
        if np.linalg.cond(normal) < 1e14:
            sigma = max(rms / np.sqrt(2.0), _SIGMA_FLOOR_PX)
            covariance = sigma**2 * np.linalg.inv(normal)
            covariance = 0.5 * (covariance + covariance.T)
    return PosedPicture(pose, covariance, inliers, rms)


def _linearised(
    pose: FloatArray, points: FloatArray, px: FloatArray, matrix: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Residuals ``(n, 2)``, derivative ``(n, 2, 6)`` by the step, Huber weights ``(n,)``."""
    in_camera = moved(pose, points)
    seen, _ = to_pixels(in_camera, matrix)
    behind = ~np.isfinite(seen[:, 0])
    residuals = np.where(behind[:, None], 0.0, seen - px)
    in_camera = np.where(behind[:, None], (0.0, 0.0, 1.0), in_camera)
    distance = np.linalg.norm(residuals, axis=-1)
    weight = np.where(behind, 0.0, HUBER_PX / np.maximum(distance, HUBER_PX))
    # Beyond the outlier's distance a residual pulls less and less (Cauchy's tail on Huber's).
    weight = weight / (1.0 + np.maximum(distance - OUTLIER_PX, 0.0) ** 2 / OUTLIER_PX**2)
    return residuals, projection_by_step(in_camera, matrix), weight


def projection_by_point(in_camera: FloatArray, matrix: FloatArray) -> FloatArray:
    """Derivative ``(n, 2, 3)`` of the pixels by the point in the camera's frame."""
    inverse_depth = 1.0 / in_camera[:, 2]
    jacobian = np.zeros((len(in_camera), 2, 3))
    jacobian[:, 0, 0] = matrix[0, 0] * inverse_depth
    jacobian[:, 1, 1] = matrix[1, 1] * inverse_depth
    jacobian[:, 0, 2] = -jacobian[:, 0, 0] * in_camera[:, 0] * inverse_depth
    jacobian[:, 1, 2] = -jacobian[:, 1, 1] * in_camera[:, 1] * inverse_depth
    return jacobian


def projection_by_step(in_camera: FloatArray, matrix: FloatArray) -> FloatArray:
    """Derivative ``(n, 2, 6)`` of the pixels by the step."""
    by_point = projection_by_point(in_camera, matrix)
    return np.concatenate([np.cross(in_camera[:, None], by_point), by_point], axis=-1)


def pose_by_sampling(points: FloatArray, px: FloatArray, matrix: FloatArray) -> PosedPicture | None:
    """Pose from scratch: MAGSAC over minimal samples, then `refine_pose`; None where none is found.

    OpenCV seeds its samples alike at every call, so the same points give the same pose.
    """
    if len(points) < _FEWEST:
        return None
    try:
        found, turn, shift, _ = cv2.solvePnPRansac(
            np.ascontiguousarray(points), np.ascontiguousarray(px), np.array(matrix), None,
            iterationsCount=_SAMPLES, reprojectionError=OUTLIER_PX, confidence=0.999,
            flags=cv2.USAC_MAGSAC,
        )  # fmt: skip
    except cv2.error:
        return None  # samples that allow no pose at all: OpenCV 5 throws where it finds no model
    if not found or not np.isfinite(turn).all() or not np.isfinite(shift).all():
        return None
    start = np.eye(4)
    start[:3, :3], start[:3, 3] = cv2.Rodrigues(turn)[0], np.ravel(shift)
    return refine_pose(start, points, px, matrix)
