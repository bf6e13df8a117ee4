"""The fit of bodies, round by round: outliers, velocities and noise follow from the last fit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.optimise import Stop, minimise
from motorcade.tracking.pose import SIGMA_FLOOR_PX
from motorcade.tracking.self_calibration.bodies import (
    BodyObservations,
    BodyReprojection,
    BodyState,
    Freedom,
    velocities,
)
from motorcade.tracking.self_calibration.result import SelfCalibrationError

_STOP = Stop(steps=40, gain=1e-6)
_ROUNDS = 3
_NO_IMAGE = (
    "views: expected corners that one camera explains, got some that it would not see: tags that "
    "moved, or too few frames to tell how they lie"
)
_LIMIT = 3.0  # of the noise of a coordinate
_MEDIAN_OF_TWO = float(np.sqrt(2.0 * np.log(2.0)))  # median length of two standard normal numbers


@dataclass(frozen=True, eq=False)
class BodyFit:
    """A state that is least squares.

    Fields:
        state: where it ended.
        residuals_px: ``(N, 2)`` reprojection minus corner.
        covariance: ``(p, p)`` of the free ones of the state's shared numbers, for independent
            corners.
        sigma_px: noise of a coordinate.
        evaluation: the problem there.
        focal_by_view: ``(V,)`` change of the focal length that each view alone asks for, and
        focal_sigma: ``(V,)`` its standard deviation, pixels.
    """

    state: BodyState
    residuals_px: FloatArray
    covariance: FloatArray
    sigma_px: float
    evaluation: BodyReprojection
    focal_by_view: FloatArray
    focal_sigma: FloatArray

    def camera(self, size: tuple[int, int]) -> Camera:
        """The camera that was found."""
        return self.state.kind.camera(self.state.numbers, size)

    @property
    def rms_px(self) -> float:
        """Root mean square distance of corners from their reprojection."""
        return float(np.sqrt((self.residuals_px**2).sum(axis=-1).mean()))


def fit(
    seen: BodyObservations,
    start: BodyState,
    *,
    lens: bool = True,
    readout: bool = False,
    bodies: bool = True,
    alike: float = 1.0,
) -> BodyFit:
    """Minimise the reprojection error over the views and what else is free.

    Args:
        seen: corners.
        start: a state that is near.
        lens: whether its numbers are free.
        readout: whether the shutter's is.
        bodies: whether all but the first are, or how a lone one is bent.
        alike: by how much corners that err alike make errors larger than their noise says: so much
            less they weigh against what is expected of the lens (`certainty.error_inflation`).

    Raises:
        SelfCalibrationError: a start from which some corner has no image.
    """
    state, noise_px = start, _noise_px(seen, start)
    for _ in range(_ROUNDS):
        free = Freedom(lens, readout, bodies, _LIMIT * noise_px, alike * noise_px)
        evaluate = partial(
            BodyReprojection, seen, velocities(seen.time_s, state.world_T_camera), free
        )
        if not np.isfinite(evaluate(state).cost):
            raise SelfCalibrationError(_NO_IMAGE)
        minimum = minimise(state, evaluate, partial(_retract, free), _STOP)
        before, state, at = noise_px, minimum.state, minimum.evaluation
        noise_px = _median_px(at.residuals_px)
        if not readout and abs(noise_px - before) < 0.05 * before:
            break
    return _fitted(state, at, noise_px)


def _retract(free: Freedom, state: BodyState, step: tuple[FloatArray, FloatArray]) -> BodyState:
    groups, views = step
    lens, moved = len(state.numbers), free.of(state)
    wide = -(-len(moved) // 6)
    shared = state.shared
    shared[moved] += groups[:wide].ravel()[: len(moved)]
    bodies = state.world_T_body
    if free.bodies and bodies.shape[0] > 1:
        bodies = bodies.retract(np.concatenate([np.zeros((1, 6)), groups[wide:]]))
    return replace(
        state,
        numbers=shared[:lens],
        readout_s=shared[lens : lens + 2],
        bent=shared[lens + 2 :],
        world_T_camera=state.world_T_camera.retract(views),
        world_T_body=bodies,
    )


def _noise_px(seen: BodyObservations, state: BodyState) -> float:
    velocity = velocities(seen.time_s, state.world_T_camera)
    at = BodyReprojection(seen, velocity, Freedom(False, False, False, 1.0, 1.0), state)
    if not np.isfinite(at.cost):
        raise SelfCalibrationError(_NO_IMAGE)
    return _median_px(at.residuals_px)


def _median_px(residuals_px: FloatArray) -> float:
    """Noise of a coordinate that outliers do not move."""
    median = float(np.median(np.linalg.norm(residuals_px, axis=-1)))
    return max(median / _MEDIAN_OF_TWO, SIGMA_FLOOR_PX)


def _fitted(state: BodyState, at: BodyReprojection, noise_px: float) -> BodyFit:
    equations, free = at.equations, at.free_numbers
    if not len(free):
        nothing = np.zeros(len(equations.blocks))
        return BodyFit(state, at.residuals_px, np.zeros((0, 0)), noise_px, at, nothing, nothing)
    inverse = np.linalg.inv(equations.reduced_information)
    covariance = np.asarray(noise_px**2 * inverse[: len(free), : len(free)], np.float64)
    by_view, information = _focal_alone(at, equations.blocks)
    sigma = np.asarray(noise_px / np.sqrt(information), np.float64)
    return BodyFit(state, at.residuals_px, covariance, noise_px, at, by_view, sigma)


def _focal_alone(at: BodyReprojection, blocks: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Change ``(V,)`` of the focal length that each view asks for, its pose free, all else held.

    Returns:
        the changes, and their information for corners of unit noise.
    """
    by_focal, starts = at.by_shared[..., 0], at.starts
    pulled = at.weight[:, None] * by_focal
    shared = np.add.reduceat(np.einsum("nij,ni->nj", at.by_view, pulled), starts, axis=0)
    weighed = at.weight[:, None] * at.residuals_px
    pull = np.add.reduceat(np.einsum("nij,ni->nj", at.by_view, weighed), starts, axis=0)
    own = np.add.reduceat((pulled * by_focal).sum(axis=-1), starts)
    gradient = np.add.reduceat((pulled * at.residuals_px).sum(axis=-1), starts)
    held = np.linalg.solve(blocks + 1e-9 * np.eye(6), np.stack([shared, pull], axis=-1))
    information = np.maximum(own - (shared * held[..., 0]).sum(axis=-1), 1e-12)
    change = -(gradient - (shared * held[..., 1]).sum(axis=-1)) / information
    return change, information
