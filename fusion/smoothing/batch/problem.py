"""The most probable path as a problem of least squares, and its descent; see `robust_map`.

The state of a pose is its small move and the change of its velocity, 2 d numbers. Normal equations
couple neighbours only, and are factored from the first pose to the last (`native/robust_map.h`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.batch.inliers import Sizes, bridged
from motorcade.fusion.smoothing.native import _robust_map
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray

# The loss is this much wider than its own width at first, and halves until it is not.
_WIDEST = 8.0
LAST_STEPS = 60
# Largest move of a last step, in deviations of the noise; and where the loss narrows again anyway,
# which only has to lead to where that begins.
_CONVERGED, _NEARLY = 1e-5, 0.1


class PathState(NamedTuple):
    """Coordinates ``(N, D)`` and velocities ``(N, d)``."""

    coordinates: FloatArray
    velocity: FloatArray


class Charged(NamedTuple):
    """A state, what its poses and the prior are charged, and squared residuals ``(N,)``."""

    state: PathState
    cost: float
    squares: FloatArray


def component_sizes(
    representation: Representation, count: int, rotation: float, translation: float, scale: float
) -> FloatArray:
    """Sizes ``(d,)`` of the components of a difference for sizes in rad, m and log scale.

    A small turn changes quaternion components by half of it, and so does a small shift the dual
    part of a dual quaternion near the origin (further off, components are larger than that).
    """
    (turning, shifting), (a_radian, a_metre) = representation.ends, representation.units
    sizes = np.full(count, scale)
    sizes[:turning], sizes[turning:shifting] = a_radian * rotation, a_metre * translation
    return sizes


class Problem:
    """Measured poses and the model; see the module."""

    def __init__(
        self,
        representation: Representation,
        time_s: FloatArray,
        poses: Motor | Similarity,
        start: NDArray[np.bool_],
        sizes: tuple[Sizes, Sizes, Sizes],
    ) -> None:
        self.representation = representation
        self.time_s, self.interval_s = time_s, np.diff(time_s)
        self.poses, self.start = poses, start
        self.measured = representation.coordinates(poses)
        d = representation.local(self.measured[:1], self.measured[:1]).shape[-1]
        self.noise = component_sizes(representation, d, *(size.noise for size in sizes))
        self.density = component_sizes(representation, d, *(size.acceleration for size in sizes))

    def narrowed(self, loss: str, width: float) -> PathState:
        """The path of the poses to start from alone, by a loss that narrows down to its width."""
        state = self._first_guess()
        self.measured = self.written(self.poses, state.coordinates)
        wide = _WIDEST * width
        while loss != "squares" and wide > width:
            state = self.descended(state, loss, wide, self.start, 3, _NEARLY).state
            wide *= 0.5
        return state

    def written(self, poses: Motor | Similarity, near: FloatArray) -> FloatArray:
        """Coordinates of poses ``(K,)``, on the branches nearest to others ``(K, D)``."""
        own = self.representation.coordinates(poses)
        return np.array(self.representation.continued(own, near))

    def _first_guess(self) -> PathState:
        """The poses to start from, and what lies between them."""
        poses, time_s = self.poses, self.time_s
        rigid = bridged(time_s, poses.rigid, self.start)
        guess: Motor | Similarity = rigid
        if isinstance(poses, Similarity):
            log_scale = np.interp(time_s, time_s[self.start], np.log(poses.scale[self.start]))
            guess = Similarity.from_motor_scale(rigid, np.exp(log_scale))
        coordinates = self.representation.coordinates(guess)
        steps = self.representation.local(coordinates[1:], coordinates[:-1])
        rate = steps / self.interval_s[:, None]
        velocity = np.concatenate([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
        return PathState(coordinates, velocity)

    def charged(
        self, state: PathState, loss: str, width: float, among: NDArray[np.bool_]
    ) -> Charged:
        """What the prior and some of the poses charge at a state."""
        return self.descended(state, loss, width, among, steps=0)

    def descended(
        self,
        state: PathState,
        loss: str,
        width: float,
        among: NDArray[np.bool_],
        steps: int,
        converged: float = _CONVERGED,
    ) -> Charged:
        """Lower the cost of a loss over some of the poses until it does not fall any more."""
        moved = PathState(*(np.array(one, order="C") for one in state))
        squares = np.empty(len(self.time_s))
        cost = _robust_map.descend(
            self._kind(), self._given(among), (loss, width), moved, steps, converged, squares
        )
        return Charged(moved, cost, squares)

    def stepped(
        self, state: PathState, loss: str, width: float, pull: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The step downhill ``(N, 2 d)``, and those that pulls ``(N, 2 d, k)`` would make."""
        alone = np.empty((len(self.time_s), 2 * len(self.noise)))
        along = np.array(pull, order="C")
        inputs = self._given(np.ones(len(self.time_s), np.bool_))
        _robust_map.step(self._kind(), inputs, (loss, width), state, alone, along)
        return alone, along

    def retract(self, state: PathState, move: FloatArray) -> PathState:
        """The state a step ``(N, 2 d)`` on."""
        d = state.velocity.shape[1]
        coordinates = self.representation.retract(state.coordinates, move[:, :d])
        return PathState(coordinates, state.velocity + move[:, d:])

    def _kind(self) -> tuple[str, bool]:
        beside = self.representation.scale_beside and isinstance(self.poses, Similarity)
        return self.representation.compiled, beside

    def _given(
        self, among: NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray, NDArray[np.bool_], FloatArray, FloatArray]:
        measured = np.ascontiguousarray(self.measured)
        return self.interval_s, measured, among, self.noise, self.density


def with_rigid(poses: Motor | Similarity, rigid: Motor) -> Motor | Similarity:
    """Other rigid poses with the scale of these, where they have one."""
    if isinstance(poses, Similarity):
        return Similarity.from_motor_scale(rigid, poses.scale)
    return rigid


def loss_weights(squares: FloatArray, loss: str, width: float) -> FloatArray:
    """``ρ'(s)``."""
    if loss == "cauchy":
        return np.asarray(1.0 / (1.0 + squares / width**2), dtype=np.float64)
    if loss == "huber":
        return np.asarray(width / np.sqrt(np.maximum(squares, width**2)), dtype=np.float64)
    return np.ones_like(squares)
