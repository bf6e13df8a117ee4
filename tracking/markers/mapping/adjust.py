"""Bundle adjustment of rig poses, markers and cameras' places on corners.

All observations are linearised at once, through the full lens model and with exact derivatives; the
frames are eliminated, so a step costs time with the cube of the markers. Huber's loss on the eight
residuals of an observation keeps wrong ones from pulling; where it is known by how much a corner is
off at most, Cauchy's does beyond that, once all stands about right. Source: Triggs et al. 2000.

Poses are perturbed by ``pose.retract(twist)``: rotation (rad), then translation (m).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import reproject
from motorcade.tracking.markers.mapping.rig import RigObservations
from motorcade.tracking.optimise import (
    BlockEquations,
    Stop,
    huber_cauchy,
    minimise,
    pair_sums,
    sum_by,
)
from motorcade.tracking.pose import SIGMA_FLOOR_PX


def residuals_px(seen: RigObservations, world_T_rig: Motor, world_T_marker: Motor) -> FloatArray:
    """Reprojection minus corner ``(N, 4, 2)``; NaN where a corner has no image.

    Args:
        seen: N observations.
        world_T_rig: Motor ``(N,)``, of each observation's frame.
        world_T_marker: Motor ``(N,)``, of each observation's marker.
    """
    camera_T_world = (world_T_rig @ seen.rig_T_camera[seen.camera]).inverse()
    points = (camera_T_world @ world_T_marker)[:, None].apply(seen.points_m)
    residuals = np.full((len(seen), 4, 2), np.nan)
    for which, camera in enumerate(seen.cameras):
        own = seen.camera == which
        residuals[own] = camera.project(points[own]) - seen.corners_px[own]
    return residuals


def linearised(
    seen: RigObservations, world_T_rig: Motor, world_T_marker: Motor
) -> tuple[FloatArray, FloatArray]:
    """Residuals ``(N, 8)`` and their derivatives ``(N, 3, 8, 6)`` by rig, marker and camera pose.

    Zero, with zero derivatives, for observations with a corner that has no image.
    """
    camera_T_rig = seen.rig_T_camera[seen.camera].inverse()
    camera_T_marker = camera_T_rig @ world_T_rig.inverse() @ world_T_marker
    in_camera = camera_T_marker[:, None].apply(seen.points_m)
    residuals, by_camera = np.full((len(seen), 4, 2), np.nan), np.zeros((len(seen), 4, 2, 6))
    for which, camera in enumerate(seen.cameras):
        mine = seen.camera == which
        pixels, by_camera[mine], _ = reproject(camera, in_camera[mine])
        residuals[mine] = pixels - seen.corners_px[mine]
    own = by_camera.reshape(-1, 8, 6)
    by_rig, by_marker = own @ camera_T_rig.adjoint(), -own @ camera_T_marker.adjoint()
    jacobians = np.stack([by_rig, by_marker, own], axis=1)
    hidden = ~np.isfinite(residuals).all(axis=(-1, -2)) | ~np.isfinite(jacobians).all((-1, -2, -3))
    residuals[hidden], jacobians[hidden] = 0.0, 0.0
    return residuals.reshape(-1, 8), jacobians


# Huber's loss turns linear where the eight residuals of an observation exceed so many deviations.
_HUBER = 4.0
_STOP = Stop(steps=60, gain=1e-6, most_damping=1e8, what="adjusting the markers")
_ROUNDS = 2
_MOST_LASTING = 0.95
# What an observation with a corner behind the camera counts.
_NO_IMAGE_PX = 1000.0
# A frame whose corners leave a direction free is known there to a radian or ten metres.
_VAGUE = np.diag(1.0 / np.repeat([1.0, 10.0], 3) ** 2)


@dataclass(frozen=True, eq=False)
class AdjustedRig:
    """Poses after an adjustment.

    Args:
        seen: the observations, with the places of cameras that were not given refined.
        world_T_rig: Motor ``(F,)``.
        world_T_marker: Motor ``(M,)``.
        error_px: ``(N,)`` root mean square reprojection error of each observation.
        sigma_px: noise a coordinate that the observations were weighed with.
        most_px: root mean square error from which on an observation was an outlier.
    """

    seen: RigObservations
    world_T_rig: Motor
    world_T_marker: Motor
    error_px: FloatArray
    sigma_px: float
    most_px: float = np.inf


def adjust(
    seen: RigObservations,
    world_T_rig: Motor,
    world_T_marker: Motor,
    held: NDArray[np.bool_],
    floor_px: float = SIGMA_FLOOR_PX,
    most_px: float = np.inf,
) -> AdjustedRig:
    """Refine all poses of frames and markers that the observations name; others stay as they are.

    Args:
        seen: the observations, at least one.
        world_T_rig: Motor ``(F,)`` to start from.
        world_T_marker: Motor ``(M,)`` to start from.
        held: ``(M,)`` markers that stay where they are; at least one, which fixes the world.
        floor_px: noise a coordinate that there is at least.
        most_px: by how much the corners of an observation are off at most, root mean square.
    """
    state = AdjustedRig(seen, world_T_rig, world_T_marker, np.zeros(0), 1.0)
    for _ in range(_ROUNDS):
        minimum = minimise(state, partial(_Reprojection, held), partial(_retract, held), _STOP)
        state, squares = minimum.state, minimum.evaluation.squares
        sigma_px = max(_noise_px(seen, held, squares), floor_px)
        state = replace(state, error_px=np.sqrt(squares / 4.0), sigma_px=sigma_px, most_px=most_px)
    return state


def _noise_px(seen: RigObservations, held: NDArray[np.bool_], squares: FloatArray) -> float:
    """Noise a coordinate, by the median: of eight residuals poses take the share of an observation.

    The median of χ² is that of Wilson and Hilferty (1931).
    """
    per_frame = np.bincount(seen.frame)[seen.frame]
    kept = 1 + max(int(slot.max(initial=-1)) for slot in _slots(seen, held))
    freedom = np.maximum(8.0 - 6.0 / per_frame - 6.0 * kept / len(seen), 1.0)
    usual = freedom * (1.0 - 2.0 / (9.0 * freedom)) ** 3
    return float(np.sqrt(np.median(squares / usual)))


def pose_covariance(state: AdjustedRig, held: NDArray[np.bool_]) -> FloatArray:
    """Covariance ``(F, 6, 6)`` of each frame's pose beside the others.

    Of the right perturbation, rotation (rad) then translation (m); observations count as Huber's
    loss has them. How unsure markers and cameras are is in it, but for what moves all frames as
    one: inner constraints (Triggs et al. 2000, section 9), weighed by what each frame tells. Errors
    of corners that last from frame to frame tell a map less than as many that do not.
    """
    adjusted, precision = _Reprojection(held, state), state.sigma_px**-2
    by_frame, equations = _VAGUE + precision * adjusted.by_frame, adjusted.equations
    covariance = np.asarray(np.linalg.inv(by_frame), np.float64)
    if len(equations.gradient):
        frames, groups = equations.block_of, equations.group_of
        by_group = np.zeros((len(by_frame), 6, len(equations.gradient) // 6, 6))
        by_group[frames, :, groups] = -precision * covariance[frames] @ equations.coupling
        follows = by_group.reshape(len(by_frame), 6, -1)
        by_world = state.world_T_rig.inverse().adjoint()
        weighted = by_world.swapaxes(-1, -2) @ by_frame
        together = np.linalg.solve(
            np.einsum("fij,fjk->ik", weighted, by_world),
            np.einsum("fij,fjk->ik", weighted, follows),
        )
        follows = follows - by_world @ together
        spread = np.linalg.inv(precision * equations.reduced_information)
        lasting = _variance_inflation(state.seen, adjusted._linearised[0])
        covariance = covariance + lasting * follows @ spread @ follows.swapaxes(-1, -2)
    return 0.5 * (covariance + covariance.swapaxes(-1, -2))


def _variance_inflation(seen: RigObservations, residuals: FloatArray) -> float:
    """By how much errors that last make a mean less sure (Bayley & Hammersley 1946), 1 or more.

    By the correlation of a marker's residuals in one frame with those in the next that shows it.
    """
    order = np.lexsort((seen.frame, seen.camera, seen.marker))
    same = (np.diff(seen.marker[order]) == 0) & (np.diff(seen.camera[order]) == 0)
    before, after = residuals[order[:-1][same]], residuals[order[1:][same]]
    squares = max(0.5 * float(np.sum(before**2) + np.sum(after**2)), 1e-12)
    share = float(np.clip(np.sum(before * after) / squares, 0.0, _MOST_LASTING))
    return (1.0 + share) / (1.0 - share)


class _Reprojection:
    """All observations against their reprojection, weighed by Huber's loss, for unit noise."""

    def __init__(self, held: NDArray[np.bool_], state: AdjustedRig) -> None:
        self._held, self._state = held, state
        seen = state.seen
        poses = state.world_T_rig[seen.frame], state.world_T_marker[seen.marker]
        residuals = residuals_px(seen, *poses)
        squares: FloatArray = np.sum(residuals**2, axis=(-1, -2))
        self.squares = np.where(np.isfinite(squares), squares, _NO_IMAGE_PX**2)
        limit_px = _HUBER * state.sigma_px
        most_px = max(min(2.0 * state.most_px, _NO_IMAGE_PX), limit_px)
        loss, self._weight = huber_cauchy(np.sqrt(self.squares), limit_px, most_px)
        self.cost = float(np.sum(loss))

    @cached_property
    def _linearised(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Weighed residuals ``(N, 8)``, derivatives ``(N, 3, 8, 6)``, those by the rig's pose."""
        state, seen = self._state, self._state.seen
        poses = state.world_T_rig[seen.frame], state.world_T_marker[seen.marker]
        residuals, jacobians = linearised(seen, *poses)
        root = np.sqrt(self._weight)
        jacobians = jacobians * root[:, None, None, None]
        return residuals * root[:, None], jacobians, jacobians[:, 0]

    @property
    def by_frame(self) -> FloatArray:
        """Information ``(F, 6, 6)`` of each frame's pose."""
        seen = self._state.seen
        _, _, by_rig = self._linearised
        return sum_by(by_rig.swapaxes(-1, -2) @ by_rig, seen.frame, len(seen.time_ns))

    @cached_property
    def equations(self) -> BlockEquations:
        """The frames are the blocks; loose markers, then cameras that were not given, are kept."""
        seen = self._state.seen
        residuals, jacobians, by_rig = self._linearised
        slots = _slots(seen, self._held)
        count = int(max((slot.max(initial=-1) for slot in slots), default=-1)) + 1
        kept = [
            (slot[of] >= 0, slot[of], jacobians[:, part])
            for part, (slot, of) in enumerate(
                zip(slots, (seen.marker, seen.camera), strict=True), 1
            )
        ]
        information = np.zeros((count, count, 6, 6))
        gradient = np.zeros((count, 6))
        for free, slot, by_pose in kept:
            pull = np.einsum("nij,ni->nj", by_pose[free], residuals[free])
            gradient += sum_by(pull, slot[free], count)
            for also_free, other, by_other in kept:
                both = free & also_free
                product = by_pose[both].swapaxes(-1, -2) @ by_other[both]
                rows, columns, sums = pair_sums(product, slot[both], other[both])
                information[rows, columns] += sums
        meet = [
            pair_sums(by_rig[free].swapaxes(-1, -2) @ by_pose[free], seen.frame[free], slot[free])
            for free, slot, by_pose in kept
        ]
        return BlockEquations(
            information.swapaxes(1, 2).reshape(6 * count, 6 * count),
            gradient.ravel(),
            self.by_frame,
            sum_by(np.einsum("nij,ni->nj", by_rig, residuals), seen.frame, len(seen.time_ns)),
            *(np.concatenate(parts) for parts in zip(*meet, strict=True)),
        )


def _slots(seen: RigObservations, held: NDArray[np.bool_]) -> tuple[IntArray, IntArray]:
    """Which of the kept poses each marker ``(M,)`` and each camera ``(C,)`` is; -1 if it stays."""
    free = np.zeros(len(seen.marker_ids), bool)
    free[seen.marker] = True
    free &= ~held
    markers = np.where(free, np.cumsum(free) - 1, -1)
    cameras = np.where(seen.stated, -1, np.count_nonzero(free) + np.cumsum(~seen.stated) - 1)
    return markers, cameras


def _retract(
    held: NDArray[np.bool_], state: AdjustedRig, step: tuple[FloatArray, FloatArray]
) -> AdjustedRig:
    kept, frames = step
    twists = np.concatenate([kept, np.zeros((1, 6))])  # slot -1 is what stays
    markers, cameras = _slots(state.seen, held)
    return replace(
        state,
        seen=replace(state.seen, rig_T_camera=state.seen.rig_T_camera.retract(twists[cameras])),
        world_T_rig=state.world_T_rig.retract(frames),
        world_T_marker=state.world_T_marker.retract(twists[markers]),
    )
