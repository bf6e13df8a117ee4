"""Least squares for a camera and the poses of a board in many views, all corners at once.

Levenberg-Marquardt (Levenberg 1944, Marquardt 1963) with exact derivatives; the poses are
eliminated view by view (Schur complement), so a step costs time in proportion to the corners.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import FloatArray, IntArray, Motor
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras import lenses
from motorcade.tracking.cameras.camera import Camera

__all__ = ["Fit", "Observations", "fit_camera"]

_ITERATIONS = 100
_SETTLED = 1e-10
_WORST_DAMPING = 1e9


@dataclass(frozen=True, eq=False)
class Observations:
    """The corners of V views, one view after the other.

    Fields:
        points_m: ``(N, 3)`` board frame.
        corners_px: ``(N, 2)``.
        starts: ``(V,)`` the first row of each view.
    """

    points_m: FloatArray
    corners_px: FloatArray
    starts: IntArray

    @classmethod
    def of(cls, views: list[BoardCorners]) -> Observations:
        """Put views behind one another."""
        counts = np.array([len(view) for view in views])
        return cls(
            np.concatenate([view.points_m for view in views]),
            np.concatenate([view.corners_px for view in views]),
            np.cumsum(counts) - counts,
        )

    @property
    def view(self) -> IntArray:
        """The view of each corner ``(N,)``."""
        counts = np.diff(np.append(self.starts, len(self.points_m)))
        return np.repeat(np.arange(len(self.starts)), counts)

    def sums(self, values: FloatArray) -> FloatArray:
        """Sums ``(V, ...)`` over the corners of each view."""
        return np.add.reduceat(values, self.starts, axis=0)


@dataclass(frozen=True, eq=False)
class Fit:
    """A camera and poses that are least squares.

    Fields:
        camera: with the fitted intrinsics.
        camera_T_board: ``(V, 4, 4)``.
        residuals_px: ``(N, 2)`` reprojection minus corner.
        information: ``(p, p)`` of fx, fy, cx, cy and the distortion, for corners of unit noise,
            the poses being unknown too.
    """

    camera: Camera
    camera_T_board: FloatArray
    residuals_px: FloatArray
    information: FloatArray


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations: pose blocks (V, 6, 6), mixed (V, 6, p), camera (p, p), right-hand sides."""

    poses: FloatArray
    mixed: FloatArray
    camera: FloatArray
    poses_right: FloatArray
    camera_right: FloatArray

    def damped(self, damping: float) -> _Normal:
        scale = 1.0 + damping
        return replace(
            self,
            poses=self.poses * (1.0 + damping * np.eye(6)),
            camera=self.camera + (scale - 1.0) * np.diag(np.diag(self.camera)),
        )

    def reduced(self) -> tuple[FloatArray, FloatArray]:
        """The camera's equations with the poses eliminated: matrix and right-hand side."""
        solved = np.linalg.solve(
            self.poses, np.concatenate([self.mixed, self.poses_right[..., None]], axis=-1)
        )
        transposed = self.mixed.swapaxes(-1, -2)
        taken = (transposed @ solved).sum(axis=0)
        return self.camera - taken[:, :-1], self.camera_right - taken[:, -1]

    def step(self) -> tuple[FloatArray, FloatArray]:
        """Changes of the camera ``(p,)`` and of the poses ``(V, 6)``."""
        camera = np.asarray(np.linalg.solve(*self.reduced()), np.float64)
        right = self.poses_right - self.mixed @ camera
        poses = np.asarray(np.linalg.solve(self.poses, right[..., None]), np.float64)
        return camera, poses[..., 0]


def fit_camera(seen: Observations, camera: Camera, camera_T_board: FloatArray) -> Fit:
    """Minimise the reprojection error of all corners over camera and poses.

    Args:
        seen: the corners.
        camera: where to start; its model and count of coefficients stay. Rational radtan
            coefficients (k4 to k6) are held.
        camera_T_board: ``(V, 4, 4)`` poses to start from, every corner before the camera.
    """
    poses = camera_T_board
    residuals, normal = _linearised(seen, camera, poses)
    cost, damping = float((residuals**2).sum()), 1e-4
    for _ in range(_ITERATIONS):
        try:
            change, moves = normal.damped(damping).step()
            tried_camera = _changed(camera, change)
        except (np.linalg.LinAlgError, ValueError):  # singular, or a focal length below zero
            tried_cost = np.inf
        else:
            tried_poses = Motor.from_twist(moves).as_matrix() @ poses
            tried, tried_normal = _linearised(seen, tried_camera, tried_poses)
            tried_cost = float((tried**2).sum())
        if not tried_cost <= cost:
            damping *= 10.0
            if damping > _WORST_DAMPING:
                break
            continue
        settled = cost - tried_cost <= _SETTLED * cost
        camera, poses, cost = tried_camera, tried_poses, tried_cost
        residuals, normal = tried, tried_normal
        damping = max(0.1 * damping, 1e-10)
        if settled:
            break
    return Fit(camera, poses, residuals, normal.reduced()[0])


def _changed(camera: Camera, change: FloatArray) -> Camera:
    numbers = np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])
    numbers[: len(change)] -= change
    fx, fy, cx, cy, *distortion = numbers.tolist()
    return replace(camera, fx=fx, fy=fy, cx=cx, cy=cy, distortion=tuple(distortion))


def _linearised(
    seen: Observations, camera: Camera, poses: FloatArray
) -> tuple[FloatArray, _Normal]:
    """Residuals ``(N, 2)`` (NaN where a corner has no image) and the normal equations."""
    each = poses[seen.view]
    points = (each[:, :3, :3] @ seen.points_m[..., None])[..., 0] + each[:, :3, 3]
    pixels, by_point = camera.project_jacobian(points)
    residuals = pixels - seen.corners_px
    by_pose = np.concatenate([-np.cross(points[:, None], by_point), -by_point], axis=-1)
    by_camera = _by_camera(camera, points, pixels)
    flipped = by_pose.swapaxes(-1, -2)
    normal = _Normal(
        poses=seen.sums(flipped @ by_pose),
        mixed=seen.sums(flipped @ by_camera),
        camera=np.einsum("nij,nik->jk", by_camera, by_camera),
        poses_right=seen.sums((flipped @ residuals[..., None])[..., 0]),
        camera_right=np.einsum("nij,ni->j", by_camera, residuals),
    )
    return residuals, normal


def _by_camera(camera: Camera, points: FloatArray, pixels: FloatArray) -> FloatArray:
    """Derivative ``(N, 2, p)`` of the pixels by fx, fy, cx, cy and the distortion.

    Both lens models are linear in the coefficients that are fitted, so a difference is exact.
    """
    focal = np.array([camera.fx, camera.fy])
    columns = np.zeros((len(points), 2, 4))
    columns[:, 0, 0], columns[:, 1, 1] = ((pixels - (camera.cx, camera.cy)) / focal).T
    columns[:, 0, 2] = columns[:, 1, 3] = 1.0
    if camera.model == "pinhole":
        return columns
    length = 8 if camera.model == "radtan" else 4
    plain = lenses.distort(camera.model, np.zeros(length), points)
    fitted = min(len(camera.distortion), 5)
    by_lens = [
        focal * (lenses.distort(camera.model, one, points) - plain)
        for one in np.eye(length)[:fitted]
    ]
    return np.concatenate([columns, np.stack(by_lens, axis=-1)], axis=-1)
