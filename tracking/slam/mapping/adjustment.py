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
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.native._least_squares import Sight
from motorcade.tracking.optimise import BlockEquations, Stop, minimise
from motorcade.tracking.slam.geometry import BoolArray, lens_of

_HUBER = 1.5
_NEAREST = 1e-3  # depths below it, and behind the camera, count as it
_GAIN, _WINDOW_STEPS = 1e-4, 8


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
    def slots(self) -> IntArray:
        """Numbers ``(k,)`` of the free poses, from 0 on; -1 for those that stay."""
        free = ~self.fixed
        return np.where(free, np.cumsum(free) - 1, -1)

    @cached_property
    def sight(self) -> Sight:
        """What stays of it while poses and points move."""
        return Sight(
            lens_of(self.camera),
            self.pose_of,
            self.point_of,
            self.slots,
            self.px,
            self.depth,
            self.disparity_px_m / self.depth_sigma_px,
            _HUBER,
            _NEAREST,
        )


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


# Adjusts a bundle by more than images. It is given the stamps ``(k,)`` of its poses, which rise
# within those that are free, and how many steps it may take.
Adjuster = Callable[[Bundle, IntArray, int], AdjustedBundle]

_State = tuple[Motor, FloatArray]


def adjust(bundle: Bundle, iterations: int = _WINDOW_STEPS) -> AdjustedBundle:
    """Minimise Huber's loss of pixels and depths over the free poses and all points.

    With one fixed pose and no depths the scale is free; the damping then leaves it where it was.
    """
    start = bundle.world_T_camera, bundle.points
    whole = "adjusting the map" if iterations > _WINDOW_STEPS else ""
    stop = Stop(steps=iterations, gain=_GAIN, what=whole)
    minimum = minimise(start, partial(BundleReprojection, bundle), partial(_retract, bundle), stop)
    end = minimum.evaluation
    return AdjustedBundle(*minimum.state, end.error_px, end.cost, minimum.start_cost)


def _retract(bundle: Bundle, state: _State, step: tuple[FloatArray, FloatArray]) -> _State:
    twists = np.zeros((len(bundle.fixed), 6))
    twists[~bundle.fixed] = step[0]
    return state[0].retract(twists), state[1] + step[1]


class BundleReprojection:
    """All observations against their reprojection: two residuals of the pixel, one of the depth.

    Args:
        bundle: what was seen; state: poses and points, instead of the bundle's own.

    Fields:
        cost: sum of Huber's losses.
        error_px: how far each observation ``(n,)`` is from its pixel; infinite behind the camera.
    """

    def __init__(self, bundle: Bundle, state: _State) -> None:
        self._bundle, self._state = bundle, (state[0].inverse().as_matrix(), state[1])
        self.cost, self.error_px = bundle.sight.evaluate(*self._state)

    @cached_property
    def equations(self) -> BlockEquations:
        """Of the free poses, six numbers each, and the points."""
        bundle = self._bundle
        own, gradient, blocks, pull, coupling = bundle.sight.linearise(*self._state)
        free, every = len(own), np.arange(len(own))
        information = np.zeros((free, 6, free, 6))
        information[every, :, every] = own
        slot = bundle.slots[bundle.pose_of]
        seen = slot >= 0
        return BlockEquations(
            information.reshape(6 * free, 6 * free),
            gradient.ravel(),
            blocks,
            pull,
            bundle.point_of[seen],
            slot[seen],
            coupling,
        )
