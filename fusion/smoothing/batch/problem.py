"""The most probable path as a problem of least squares, and its descent; see `robust_map`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.batch.inliers import Sizes, bridged
from motorcade.fusion.smoothing.batch.tridiagonal import (
    Between,
    Equations,
    between,
    component_sizes,
    prior_cost,
    solved,
)
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray

# The loss is this much wider than its own width at first, and halves until it is not.
_WIDEST = 8.0
LAST_STEPS = 60
# Largest move of a last step, in deviations of the noise.
_CONVERGED = 1e-5
_NO_MORE_DAMPING = 1e8


class PathState(NamedTuple):
    """Coordinates ``(N, D)`` and velocities ``(N, d)``."""

    coordinates: FloatArray
    velocity: FloatArray


class Linear(NamedTuple):
    """A state with its residuals and their derivatives."""

    state: PathState
    steps: Between
    measured: Between
    squares: FloatArray


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

    def narrowed(self, loss: str, width: float) -> Linear:
        """The path of the poses to start from alone, by a loss that narrows down to its width."""
        guess = self._first_guess()
        self.measured = self.written(self.poses, guess.coordinates)
        linear = self.linearised(guess)
        wide = _WIDEST * width
        while loss != "squares" and wide > width:
            linear = self.descended(linear, loss, wide, self.start, steps=3)
            wide *= 0.5
        return linear

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

    def linearised(self, state: PathState) -> Linear:
        """Residuals and derivatives at a state."""
        x = state.coordinates
        measured = between(self.representation, self.measured, x)
        squares = np.sum((measured.vector / self.noise) ** 2, axis=1)
        return Linear(state, between(self.representation, x[:-1], x[1:]), measured, squares)

    def information(
        self, linear: Linear, loss: str, width: float, among: NDArray[np.bool_]
    ) -> FloatArray:
        """Of the components of each measured pose ``(N, d)``, weights included."""
        weight = loss_weights(linear.squares, loss, width) * among
        return np.asarray(weight[:, None] * self.noise**-2.0, dtype=np.float64)

    def equations(self, linear: Linear, information: FloatArray) -> Equations:
        """The normal equations of a step."""
        return Equations.of(
            self.interval_s,
            self.density,
            linear.steps,
            linear.state.velocity,
            linear.measured,
            information,
        )

    def descended(
        self, linear: Linear, loss: str, width: float, among: NDArray[np.bool_], steps: int
    ) -> Linear:
        """Lower the cost of a loss over some of the poses until it does not fall any more."""
        damping = 0.0
        cost = self.cost(linear, loss, width, among)
        for _ in range(steps):
            equations = self.equations(linear, self.information(linear, loss, width, among))
            while True:
                move = solved(equations, damping)
                tried = self.linearised(self.retract(linear.state, move))
                found = self.cost(tried, loss, width, among)
                if found <= cost * (1.0 + 1e-12) or damping > _NO_MORE_DAMPING:
                    break
                damping = max(10.0 * damping, 1e-6)
            if found > cost * (1.0 + 1e-12):
                return linear
            linear, cost, damping = tried, found, 0.1 * damping
            if np.max(np.abs(move[:, : len(self.noise)]) / self.noise) < _CONVERGED:
                break
        return linear

    def retract(self, state: PathState, move: FloatArray) -> PathState:
        """The state a step ``(N, 2 d)`` on."""
        d = state.velocity.shape[1]
        coordinates = self.representation.retract(state.coordinates, move[:, :d])
        return PathState(coordinates, state.velocity + move[:, d:])

    def cost(self, linear: Linear, loss: str, width: float, among: NDArray[np.bool_]) -> float:
        """What the prior and some of the poses charge."""
        prior = prior_cost(self.interval_s, self.density, linear.steps, linear.state.velocity)
        return prior + float(np.sum(_charged(linear.squares, loss, width)[among]))


def with_rigid(poses: Motor | Similarity, rigid: Motor) -> Motor | Similarity:
    """Other rigid poses with the scale of these, where they have one."""
    if isinstance(poses, Similarity):
        return Similarity.from_motor_scale(rigid, poses.scale)
    return rigid


def _charged(squares: FloatArray, loss: str, width: float) -> FloatArray:
    """``ρ(s)``, equal to s where it is small."""
    if loss == "cauchy":
        return np.asarray(width**2 * np.log1p(squares / width**2), dtype=np.float64)
    if loss == "huber":
        beyond = 2.0 * width * np.sqrt(squares) - width**2
        return np.where(squares <= width**2, squares, beyond)
    return squares


def loss_weights(squares: FloatArray, loss: str, width: float) -> FloatArray:
    """``ρ'(s)``."""
    if loss == "cauchy":
        return np.asarray(1.0 / (1.0 + squares / width**2), dtype=np.float64)
    if loss == "huber":
        return np.asarray(width / np.sqrt(np.maximum(squares, width**2)), dtype=np.float64)
    return np.ones_like(squares)
