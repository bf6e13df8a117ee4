"""Bundle adjustment: poses and points that agree best with all pixels and depths.

Huber's loss; the points are eliminated in blocks of dense algebra, which for the ten keyframes of a
window is many times faster than a general factor graph.

Sources: Triggs et al. 2000; depth as disparity: Mur-Artal & Tardos 2017.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera, by_twist
from motorcade.tracking.optimise import BlockEquations, Stop, huber, minimise, sum_by
from motorcade.tracking.slam.geometry import BoolArray, is_native

_HUBER = 1.5
_NEAREST = 1e-3  # depths below it, and behind the camera, count as it
_GAIN = 1e-4


@dataclass(frozen=True, eq=False)
class Bundle:
    """Everything one adjustment works on.

    Args:
        world_T_camera: Motor ``(k,)``; fixed: ``(k,)`` those that stay.
        points: ``(p, 3)``.
        pose_of, point_of: ``(n,)`` whom each observation belongs to; a pair stands at most once.
        px: ``(n, 2)`` pixels; depth: ``(n,)`` NaN where none was measured.
        camera: the pinhole.
        disparity_px_m: focal length times baseline, by which depths are compared.
        depth_sigma_px: noise of that disparity where a pixel's coordinate has 1.
    """

    world_T_camera: Motor
    fixed: BoolArray
    points: FloatArray
    pose_of: IntArray
    point_of: IntArray
    px: FloatArray
    depth: FloatArray
    camera: Camera
    disparity_px_m: float
    depth_sigma_px: float

    @cached_property
    def slot(self) -> IntArray:
        """Which of the free poses each observation ``(n,)`` belongs to; -1 for none."""
        free = ~self.fixed
        return np.where(free, np.cumsum(free) - 1, -1)[self.pose_of]


@dataclass(frozen=True, eq=False)
class AdjustedBundle:
    """The result: poses, points, and how far each observation ends from its pixel.

    Args:
        world_T_camera: Motor ``(k,)``; points: ``(p, 3)``.
        error_px: ``(n,)``, infinite where the point lies behind the camera.
        cost: sum of Huber's losses at the end; before: at the start.
    """

    world_T_camera: Motor
    points: FloatArray
    error_px: FloatArray
    cost: float
    before: float


# Adjusts a bundle by more than pictures. It is given the stamps ``(k,)`` of its poses, which rise
# within those that are free, and how many steps it may take.
Adjuster = Callable[[Bundle, IntArray, int], AdjustedBundle]

_State = tuple[Motor, FloatArray]


def adjust(bundle: Bundle, iterations: int = 8) -> AdjustedBundle:
    """Minimise Huber's loss of pixels and depths over the free poses and all points.

    With one fixed pose and no depths the scale is free; the damping then leaves it where it was.
    """
    start = bundle.world_T_camera, bundle.points
    stop = Stop(steps=iterations, gain=_GAIN)
    found = minimise(start, partial(BundleReprojection, bundle), partial(_retract, bundle), stop)
    end = found.evaluation
    return AdjustedBundle(*found.state, end.error_px, end.cost, found.start_cost)


def _retract(bundle: Bundle, state: _State, step: tuple[FloatArray, FloatArray]) -> _State:
    twists = np.zeros((len(bundle.fixed), 6))
    twists[~bundle.fixed] = step[0]
    return state[0].retract(twists), state[1] + step[1]


class BundleReprojection:
    """All observations against their reprojection: two residuals of the pixel, one of the depth."""

    def __init__(self, bundle: Bundle, state: _State) -> None:
        self._bundle = bundle
        poses = state[0].inverse().as_matrix()
        self._turns = poses[bundle.pose_of, :3, :3]
        turned = self._turns @ state[1][bundle.point_of][..., None]
        in_camera = turned[..., 0] + poses[bundle.pose_of, :3, 3]
        if is_native(bundle.camera):  # it sees all around
            self._before = np.ones(len(in_camera), dtype=np.bool_)
        else:
            self._before = in_camera[:, 2] > 0.0
            np.maximum(in_camera[:, 2], _NEAREST, out=in_camera[:, 2])
        self._in_camera = in_camera
        self._disparity = bundle.disparity_px_m / bundle.depth_sigma_px
        self._pixel = bundle.camera.project(in_camera) - bundle.px
        self._along = self._disparity / in_camera[:, 2] - self._disparity / bundle.depth
        self._along = np.nan_to_num(self._along)
        self._size = np.linalg.norm(self._pixel, axis=-1)
        of_pixel, self._pixel_weight = huber(self._size, _HUBER)
        of_depth, self._depth_weight = huber(np.abs(self._along), _HUBER)
        self.cost = float(of_pixel.sum()) + float(of_depth.sum())

    @property
    def error_px(self) -> FloatArray:
        """How far each observation ``(n,)`` is from its pixel; infinite behind the camera."""
        return np.where(self._before, self._size, np.inf)

    @cached_property
    def equations(self) -> BlockEquations:
        """Of the free poses, six numbers each, and the points."""
        bundle, slot = self._bundle, self._bundle.slot
        residuals = np.concatenate([self._pixel, self._along[:, None]], axis=-1)
        weight = np.stack([self._pixel_weight, self._pixel_weight, self._depth_weight], axis=-1)
        by_camera_point = self._by_camera_point()
        by_pose = by_twist(self._in_camera, by_camera_point)
        by_point = by_camera_point @ self._turns
        shifted = np.swapaxes(by_point * weight[..., None], -1, -2)
        seen = slot >= 0
        by_pose, own = by_pose[seen], slot[seen]
        turned = np.swapaxes(by_pose * weight[seen][..., None], -1, -2)
        free, count = int(np.count_nonzero(~bundle.fixed)), len(bundle.points)
        information = np.zeros((free, 6, free, 6))
        every = np.arange(free)
        information[every, :, every] = sum_by(turned @ by_pose, own, free)
        return BlockEquations(
            information.reshape(6 * free, 6 * free),
            sum_by((turned @ residuals[seen][..., None])[..., 0], own, free).ravel(),
            sum_by(shifted @ by_point, bundle.point_of, count),
            sum_by((shifted @ residuals[..., None])[..., 0], bundle.point_of, count),
            bundle.point_of[seen],
            own,
            shifted[seen] @ by_pose,
        )

    def _by_camera_point(self) -> FloatArray:
        """Derivative ``(n, 3, 3)`` of the residuals by the point in the camera's frame."""
        found = np.zeros((len(self._in_camera), 3, 3))
        found[:, :2] = self._bundle.camera.project_jacobian(self._in_camera)[1]
        slope = -self._disparity / self._in_camera[:, 2] ** 2
        found[:, 2, 2] = np.where(np.isfinite(self._bundle.depth), slope, 0.0)
        return found
