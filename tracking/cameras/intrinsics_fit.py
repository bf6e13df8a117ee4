"""Least squares for a camera and the poses of a board in many views, all corners at once.

The poses are eliminated view by view, so a step costs time in proportion to the corners.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras import lenses
from motorcade.tracking.cameras.camera import Camera, reproject
from motorcade.tracking.optimise import BlockEquations, Stop, minimise

_STOP = Stop(steps=100, gain=1e-10)


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
        board_T_camera: Motor ``(V,)``.
        residuals_px: ``(N, 2)`` reprojection minus corner.
        information: ``(p, p)`` of fx, fy, cx, cy and the distortion, for corners of unit noise,
            the poses being unknown too.
        pose_information: ``(V, 6, 6)`` of each pose (right perturbation), the camera being known.
        coupling: ``(V, 6, p)`` the part of the information that pose and intrinsics have in common.
    """

    camera: Camera
    board_T_camera: Motor
    residuals_px: FloatArray
    information: FloatArray
    pose_information: FloatArray
    coupling: FloatArray


@dataclass(frozen=True, eq=False)
class _State:
    numbers: FloatArray  # fx, fy, cx, cy and the distortion
    board_T_camera: Motor

    def retract(self, step: tuple[FloatArray, FloatArray]) -> _State:
        numbers = self.numbers.copy()
        numbers[: step[0].size] += step[0].ravel()
        return _State(numbers, self.board_T_camera.retract(step[1]))


class _Reprojection:
    """All corners against their reprojection; infinite cost where no camera is like that."""

    def __init__(self, seen: Observations, like: Camera, state: _State) -> None:
        self._seen = seen
        self.cost = np.inf
        if not (np.isfinite(state.numbers).all() and (state.numbers[:2] > 0.0).all()):
            return
        self.camera = _camera(like, state.numbers)
        self._in_camera = state.board_T_camera.inverse()[seen.view].apply(seen.points_m)
        self._pixels, self._by_pose, _ = reproject(self.camera, self._in_camera)
        self.residuals_px: FloatArray = self._pixels - seen.corners_px
        self.cost = 0.5 * float((self.residuals_px**2).sum())

    @cached_property
    def equations(self) -> BlockEquations:
        seen, residuals = self._seen, self.residuals_px
        by_camera = _by_camera(self.camera, self._in_camera, self._pixels)
        flipped = self._by_pose.swapaxes(-1, -2)
        every = np.arange(len(seen.starts))
        return BlockEquations(
            information=np.einsum("nij,nik->jk", by_camera, by_camera),
            gradient=np.einsum("nij,ni->j", by_camera, residuals),
            blocks=seen.sums(flipped @ self._by_pose),
            block_gradient=seen.sums((flipped @ residuals[..., None])[..., 0]),
            block_of=every,
            group_of=np.zeros_like(every),
            coupling=seen.sums(flipped @ by_camera),
        )


def fit_camera(seen: Observations, camera: Camera, board_T_camera: Motor) -> Fit:
    """Minimise the reprojection error of all corners over camera and poses.

    Args:
        seen: the corners.
        camera: where to start; its model and count of coefficients stay. Rational radtan
            coefficients (k4 to k6) are held.
        board_T_camera: Motor ``(V,)`` to start from, every corner before the camera.
    """
    numbers = np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])
    evaluate = partial(_Reprojection, seen, camera)
    minimum = minimise(_State(numbers, board_T_camera), evaluate, _State.retract, _STOP)
    at, equations = minimum.evaluation, minimum.evaluation.equations
    return Fit(
        at.camera,
        minimum.state.board_T_camera,
        at.residuals_px,
        equations.reduced_information,
        equations.blocks,
        equations.coupling,
    )


def _camera(like: Camera, numbers: FloatArray) -> Camera:
    fx, fy, cx, cy, *distortion = numbers.tolist()
    return replace(like, fx=fx, fy=fy, cx=cx, cy=cy, distortion=tuple(distortion))


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
        focal * (lenses.distort(camera.model, unit, points) - plain)
        for unit in np.eye(length)[:fitted]
    ]
    return np.concatenate([columns, np.stack(by_lens, axis=-1)], axis=-1)
