"""Bundle adjustment of rig poses, markers and cameras' places on corners.

Levenberg-Marquardt: all sightings are linearised at once, through the full lens model and with
exact derivatives; gtsam eliminates the sparse system. Huber's loss on the eight residuals of a
sighting keeps wrong ones from pulling. Sources: Triggs et al. 2000; Huber 1964; Dellaert & Kaess
2017 (elimination on factor graphs).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import FloatArray, Motor
from motorcade.tracking.markers.mapping.reprojection import linearised, residuals_px
from motorcade.tracking.markers.mapping.rig import RigSightings
from motorcade.tracking.pose import SIGMA_FLOOR_PX

if TYPE_CHECKING:
    import gtsam

__all__ = ["Adjusted", "adjust", "pose_covariance"]

# Huber's loss turns linear where the eight residuals of a sighting exceed so many deviations.
_HUBER = 4.0
_ITERATIONS = 50
_SETTLED = 1e-6  # share of the loss that an iteration must still gain
_ROUNDS = 2
# What a sighting with a corner behind the camera counts.
_NO_IMAGE_PX = 1000.0
# A frame whose corners leave a direction free is known there to a radian or ten metres.
_VAGUE = np.diag(1.0 / np.repeat([1.0, 10.0], 3) ** 2)
_MEDIAN_CHI2 = 7.344  # median of chi squared with eight degrees of freedom


@dataclass(frozen=True, eq=False)
class Adjusted:
    """Poses after an adjustment.

    Args:
        seen: the sightings, with the places of cameras that were not given refined.
        world_T_rig: Motor ``(F,)``.
        world_T_marker: Motor ``(M,)``.
        error_px: ``(N,)`` root mean square reprojection error of each sighting.
        sigma_px: noise a coordinate that the sightings were weighed with.
    """

    seen: RigSightings
    world_T_rig: Motor
    world_T_marker: Motor
    error_px: FloatArray
    sigma_px: float


def adjust(
    seen: RigSightings, world_T_rig: Motor, world_T_marker: Motor, held: NDArray[np.bool_]
) -> Adjusted:
    """Refine all poses of frames and markers that the sightings name; others stay as they are.

    Args:
        seen: the sightings, at least one.
        world_T_rig: Motor ``(F,)`` to start from.
        world_T_marker: Motor ``(M,)`` to start from.
        held: ``(M,)`` markers that stay where they are; at least one, which fixes the world.
    """
    state = Adjusted(seen, world_T_rig, world_T_marker, np.zeros(0), 1.0)
    for _ in range(_ROUNDS):
        state = _optimised(state, held)
        squares = _squares(state)
        sigma_px = max(float(np.sqrt(np.median(squares) / _MEDIAN_CHI2)), SIGMA_FLOOR_PX)
        state = replace(state, error_px=np.sqrt(squares / 4.0), sigma_px=sigma_px)
    return state


def pose_covariance(state: Adjusted) -> FloatArray:
    """Covariance ``(F, 6, 6)`` of each frame's pose, markers and cameras taken as they stand.

    Of the right perturbation, rotation (rad) then translation (m); sightings count as Huber's loss
    has them.
    """
    seen = state.seen
    residuals, jacobians = linearised(
        seen, state.world_T_rig[seen.frame], state.world_T_marker[seen.marker]
    )
    scaled = jacobians[:, 0] * _weight(residuals, state.sigma_px)[:, None, None]
    information: FloatArray = np.tile(_VAGUE, (len(seen.time_ns), 1, 1))
    np.add.at(information, seen.frame, scaled.swapaxes(-1, -2) @ scaled)
    covariance = np.asarray(np.linalg.inv(information), np.float64)
    return 0.5 * (covariance + covariance.swapaxes(-1, -2))


def _weight(residuals: FloatArray, sigma_px: float) -> FloatArray:
    """Factor ``(N,)`` on each sighting's residuals ``(N, 8)``: Huber's, over the noise."""
    size = np.linalg.norm(residuals, axis=-1) / sigma_px
    return np.asarray(np.sqrt(np.minimum(1.0, _HUBER / np.maximum(size, 1e-12))) / sigma_px)


def _optimised(state: Adjusted, held: NDArray[np.bool_]) -> Adjusted:
    loss, damping = _loss(state), 1e-4
    for _ in range(_ITERATIONS):
        residuals, jacobians = linearised(
            state.seen, state.world_T_rig[state.seen.frame], state.world_T_marker[state.seen.marker]
        )
        weight = _weight(residuals, state.sigma_px)
        before = loss
        while damping < 1e8:
            tried = _stepped(state, residuals, jacobians, weight, held, damping)
            tried_loss = _loss(tried)
            if tried_loss < loss:
                state, loss, damping = tried, tried_loss, max(damping * 0.1, 1e-9)
                break
            damping *= 10.0
        if before - loss <= _SETTLED * before:
            break
    return state


def _stepped(
    state: Adjusted,
    residuals: FloatArray,
    jacobians: FloatArray,
    weight: FloatArray,
    held: NDArray[np.bool_],
    damping: float,
) -> Adjusted:
    """All poses moved by one damped step."""
    import gtsam

    seen = state.seen
    graph = gtsam.GaussianFactorGraph()
    make: Callable[..., gtsam.JacobianFactor] = gtsam.JacobianFactor  # one to three poses
    unit = gtsam.noiseModel.Unit.Create(8)
    scaled = jacobians * weight[:, None, None, None]
    wanted = -residuals * weight[:, None]
    keys = _Keys(seen, held)
    for row in range(len(seen)):
        names = keys.of(row)
        terms: tuple[Any, ...] = ()
        for part, key in enumerate(names):
            if key is not None:
                terms += (key, scaled[row, part])
        graph.add(make(*terms, wanted[row], unit))
    for key, diagonal in keys.diagonals(scaled).items():
        root = np.diag(np.sqrt(damping * diagonal))
        graph.add(gtsam.JacobianFactor(key, root, np.zeros(6), gtsam.noiseModel.Unit.Create(6)))
    found = graph.optimize()
    return keys.moved(state, found)


class _Keys:
    """gtsam's keys of the poses that may move."""

    def __init__(self, seen: RigSightings, held: NDArray[np.bool_]) -> None:
        import gtsam

        self._seen = seen
        self._rig = {int(one): gtsam.symbol("x", int(one)) for one in np.unique(seen.frame)}
        loose = [int(one) for one in np.unique(seen.marker) if not held[one]]
        self._marker = {one: gtsam.symbol("m", one) for one in loose}
        free = [int(one) for one in np.unique(seen.camera) if not seen.given[one]]
        self._camera = {one: gtsam.symbol("c", one) for one in free}

    def of(self, row: int) -> tuple[int, int | None, int | None]:
        """Keys of rig, marker and camera of a sighting; None for what stays."""
        seen = self._seen
        return (
            self._rig[int(seen.frame[row])],
            self._marker.get(int(seen.marker[row])),
            self._camera.get(int(seen.camera[row])),
        )

    def diagonals(self, scaled: FloatArray) -> dict[int, FloatArray]:
        """Diagonal ``(6,)`` of each free pose's information, a little above zero."""
        seen, squares = self._seen, np.sum(scaled**2, axis=-2)
        found: dict[int, FloatArray] = {}
        for part, (keys, index, count) in enumerate(
            (
                (self._rig, seen.frame, len(seen.time_ns)),
                (self._marker, seen.marker, len(seen.marker_ids)),
                (self._camera, seen.camera, len(seen.cameras)),
            )
        ):
            total = np.full((count, 6), 1e-6)
            np.add.at(total, index, squares[:, part])
            found |= {key: total[which] for which, key in keys.items()}
        return found

    def moved(self, state: Adjusted, step: gtsam.VectorValues) -> Adjusted:
        """The poses after a step."""
        seen = replace(
            state.seen, rig_T_camera=_turned(state.seen.rig_T_camera, self._camera, step)
        )
        return replace(
            state,
            seen=seen,
            world_T_rig=_turned(state.world_T_rig, self._rig, step),
            world_T_marker=_turned(state.world_T_marker, self._marker, step),
        )


def _turned(poses: Motor, keys: dict[int, int], step: gtsam.VectorValues) -> Motor:
    twists = np.zeros((len(poses), 6))
    for which, key in keys.items():
        twists[which] = step.at(key)
    return poses @ Motor.from_twist(twists)


def _squares(state: Adjusted) -> FloatArray:
    """Sum of squared residuals ``(N,)`` of each sighting."""
    seen = state.seen
    residuals = residuals_px(seen, state.world_T_rig[seen.frame], state.world_T_marker[seen.marker])
    squares: FloatArray = np.sum(residuals**2, axis=(-1, -2))
    return np.where(np.isfinite(squares), squares, _NO_IMAGE_PX**2)


def _loss(state: Adjusted) -> float:
    size = np.sqrt(_squares(state)) / state.sigma_px
    huber = np.where(size <= _HUBER, 0.5 * size**2, _HUBER * (size - 0.5 * _HUBER))
    return float(np.sum(huber))
