"""Robust batch estimation: the most probable path under a motion model, outliers told apart.

Maximised is the posterior of poses ``X_i`` and velocities ``v_i`` at the stamps. Between them the
motion has white acceleration: with ``e = difference(X_{i+1}, X_i) - dt v_i`` and ``f = v_{i+1} -
v_i`` the prior charges ``[e f] Q⁻¹ [e f]ᵀ``, ``Q = q² [[dt³/3, dt²/2], [dt²/2, dt]]``, for each
component and any dt: gaps are long steps. A measured pose ``Z_i`` charges ``ρ(s)``, where s is the
squared length of ``difference(X_i, Z_i)`` in deviations of the noise. On motors the vectors are
twists, and a constant screw costs nothing (T. D. Barfoot, State Estimation for Robotics, 2nd ed.,
2024, ch. 11; velocities are the representation's own, and the right Jacobian of one step is taken
for 1).

Solved by Gauss-Newton with Marquardt's damping, weights following the residuals (P. W. Holland,
R. E. Welsch, Robust regression using iteratively reweighted least-squares, 1977). It starts from
the poses that make up the longest smooth chain (see `consistent`), and the loss narrows in steps
from wide to its own width (graduated non-convexity: A. Blake, A. Zisserman, Visual Reconstruction,
1987); only then are the poses left out judged by their residuals as all others are.

Across a run of wrong poses nothing is known but the motion model, so that the error there grows
with the length of the run. A path that leaps for good, as when a map is corrected, is torn smooth.
Time is linear in the poses, and some 11 KiB a pose are needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smooth.batch.charts import Between, Chart, component_sizes
from motorcade.fusion.smooth.batch.consistent import Sizes, bridged, consistent_poses
from motorcade.fusion.smooth.batch.tridiagonal import Equations, prior_cost, solved
from motorcade.fusion.smooth.checks import checked_length, checked_positive
from motorcade.fusion.smooth.representations import Representation, representation_named, restored
from motorcade.ga import FloatArray, Motor, Similarity, Trajectory

__all__ = ["LOSSES", "RobustPath", "estimate_path", "robust_map"]

LOSSES = ("cauchy", "huber", "squares")
# The loss is this much wider than its own width at first, and halves until it is not.
_WIDEST = 8.0
_MAX_STEPS = 60
# Largest move of a last step, in deviations of the noise.
_CONVERGED = 1e-5
_NO_MORE_DAMPING = 1e8


@dataclass(frozen=True, eq=False)
class RobustPath:
    """The most probable path, and how much each measured pose had to say in it.

    Fields:
        trajectory: the estimate, with the stamps and frames of the measured one.
        weight: ``(N,)`` 1 where a measured pose counts fully, towards 0 where it is rejected.
        distance: ``(N,)`` of measured from estimated poses, in deviations of the noise.
        velocity: ``(N, d)`` in the representation's vectors; on motors the body twist.
    """

    trajectory: Trajectory
    weight: FloatArray
    distance: FloatArray
    velocity: FloatArray

    @property
    def rejected(self) -> NDArray[np.bool_]:
        """Poses ``(N,)`` that count less than a tenth."""
        return np.asarray(self.weight < 0.1, dtype=np.bool_)


def robust_map(
    trajectory: Trajectory,
    representation: Representation,
    *,
    acceleration_m_s2: float = 0.5,
    angular_acceleration_rad_s2: float = 1.0,
    noise_m: float = 0.005,
    noise_rad: float = 0.01,
    scale_acceleration_s2: float = 1.0,
    noise_scale: float = 0.005,
    loss: str = "cauchy",
    width: float = 3.5,
) -> Trajectory:
    """The most probable path; see the module. `estimate_path` also tells which poses it rejected.

    Args:
        trajectory: two poses or more, at any sampling.
        representation: in whose vectors residuals and velocities are.
        acceleration_m_s2: density of the white acceleration an axis in m/s²/√Hz: in T seconds the
            velocity wanders by it times √T. Too small, and true motion is rejected as outliers.
        angular_acceleration_rad_s2: the same of the rotation in rad/s²/√Hz.
        noise_m: standard deviation of a good position an axis.
        noise_rad: the same of a rotation, about an axis.
        scale_acceleration_s2: the same of the scale in 1/s²/√Hz; rigid poses have none.
        noise_scale: the same of the scale.
        loss: "cauchy" ``w² ln(1 + s / w²)`` rejects outliers, "huber" (``s`` up to ``w²``, then
            ``2 w √s - w²``) bounds their pull, "squares" does neither.
        width: w, in deviations of the whole pose. Good poses have s near 6.

    Raises:
        ValueError: a size that is not positive, an unknown loss, a single pose.
        ModuleNotFoundError: scipy or CasADi is missing.
    """
    return estimate_path(
        trajectory, representation.name,
        acceleration_m_s2=acceleration_m_s2,
        angular_acceleration_rad_s2=angular_acceleration_rad_s2,
        noise_m=noise_m, noise_rad=noise_rad,
        scale_acceleration_s2=scale_acceleration_s2, noise_scale=noise_scale,
        loss=loss, width=width,
    ).trajectory  # fmt: skip


def estimate_path(
    trajectory: Trajectory,
    representation: str = "motor",
    *,
    acceleration_m_s2: float = 0.5,
    angular_acceleration_rad_s2: float = 1.0,
    noise_m: float = 0.005,
    noise_rad: float = 0.01,
    scale_acceleration_s2: float = 1.0,
    noise_scale: float = 0.005,
    loss: str = "cauchy",
    width: float = 3.5,
) -> RobustPath:
    """The most probable path with the weights of the measured poses; parameters of `robust_map`."""
    chosen = representation_named(representation)
    checked_length(trajectory, 2, "robust_map")
    if loss not in LOSSES:
        raise ValueError(f"loss: expected one of {', '.join(LOSSES)}, got {loss!r}")
    checked_positive(width, "width", "deviations")
    given = {
        "acceleration_m_s2": acceleration_m_s2,
        "angular_acceleration_rad_s2": angular_acceleration_rad_s2,
        "noise_m": noise_m,
        "noise_rad": noise_rad,
        "scale_acceleration_s2": scale_acceleration_s2,
        "noise_scale": noise_scale,
    }
    for name, value in given.items():
        checked_positive(value, name, "its unit")
    sizes = (
        Sizes(noise_rad, angular_acceleration_rad_s2),
        Sizes(noise_m, acceleration_m_s2),
        Sizes(noise_scale, scale_acceleration_s2),
    )
    return _Problem.of(trajectory, chosen, sizes).solved(trajectory, loss, width)


class _State(NamedTuple):
    """Coordinates ``(N, D)`` and velocities ``(N, d)``."""

    coordinates: FloatArray
    velocity: FloatArray


class _Linear(NamedTuple):
    """A state with its residuals and their derivatives."""

    state: _State
    steps: Between
    measured: Between
    squares: FloatArray


class _Problem:
    """Measured poses and the model; see the module."""

    def __init__(
        self,
        representation: Representation,
        time_s: FloatArray,
        measured: FloatArray,
        sizes: tuple[FloatArray, FloatArray],
        start: NDArray[np.bool_],
    ) -> None:
        self.representation = representation
        self.interval_s = np.diff(time_s)
        self.measured = measured
        self.noise, self.density = sizes
        self.start = start
        self.chart = Chart(representation)

    @classmethod
    def of(
        cls,
        trajectory: Trajectory,
        representation: Representation,
        sizes: tuple[Sizes, Sizes, Sizes],
    ) -> _Problem:
        poses = trajectory.poses
        start = consistent_poses(trajectory.time_s, _rigid(poses), sizes[0], sizes[1])
        measured = representation.coordinates(poses)
        d = representation.difference(measured[:1], measured[:1]).shape[-1]
        noise = component_sizes(representation, d, *(size.noise for size in sizes))
        density = component_sizes(representation, d, *(size.acceleration for size in sizes))
        return cls(representation, trajectory.time_s, measured, (noise, density), start)

    def solved(self, trajectory: Trajectory, loss: str, width: float) -> RobustPath:
        guess = self._first_guess(trajectory)
        follow = self.representation.following
        pairs = zip(self.measured, guess.coordinates, strict=True)
        self.measured = np.stack([follow(theirs, ours) for theirs, ours in pairs])
        linear = self._linearised(guess)
        wide = _WIDEST * width
        while loss != "squares" and wide > width:
            linear = self._descended(linear, loss, wide, self.start, steps=3)
            wide *= 0.5
        everyone = np.ones_like(self.start)
        linear = self._descended(linear, loss, width, everyone, _MAX_STEPS)
        return RobustPath(
            restored(self.representation, linear.state.coordinates, trajectory),
            _weights(linear.squares, loss, width),
            np.sqrt(linear.squares),
            linear.state.velocity,
        )

    def _first_guess(self, trajectory: Trajectory) -> _State:
        """The poses of the chain, and what lies between them."""
        poses, time_s = trajectory.poses, trajectory.time_s
        rigid = bridged(time_s, _rigid(poses), self.start)
        guess: Motor | Similarity = rigid
        if isinstance(poses, Similarity):
            log_scale = np.interp(time_s, time_s[self.start], np.log(poses.scale[self.start]))
            guess = Similarity.from_motor_scale(rigid, np.exp(log_scale))
        coordinates = self.representation.coordinates(guess)
        steps = self.representation.difference(coordinates[1:], coordinates[:-1])
        rate = steps / self.interval_s[:, None]
        velocity = np.concatenate([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
        return _State(coordinates, velocity)

    def _linearised(self, state: _State) -> _Linear:
        x = state.coordinates
        measured = self.chart.between(self.measured, x)
        squares = np.sum((measured.vector / self.noise) ** 2, axis=1)
        return _Linear(state, self.chart.between(x[:-1], x[1:]), measured, squares)

    def _descended(
        self, linear: _Linear, loss: str, width: float, among: NDArray[np.bool_], steps: int
    ) -> _Linear:
        """Lower the cost of a loss over some of the poses until it does not fall any more."""
        damping = 0.0
        cost = self._cost(linear, loss, width, among)
        for _ in range(steps):
            weight = _weights(linear.squares, loss, width) * among
            information = weight[:, None] * self.noise**-2.0
            equations = Equations.of(
                self.interval_s, self.density, linear.steps, linear.state.velocity,
                linear.measured, information,
            )  # fmt: skip
            while True:
                move = solved(equations, damping)
                tried = self._linearised(self._moved(linear.state, move))
                found = self._cost(tried, loss, width, among)
                if found <= cost * (1.0 + 1e-12) or damping > _NO_MORE_DAMPING:
                    break
                damping = max(10.0 * damping, 1e-6)
            if found > cost * (1.0 + 1e-12):
                return linear
            linear, cost, damping = tried, found, 0.1 * damping
            if np.max(np.abs(move[:, : len(self.noise)]) / self.noise) < _CONVERGED:
                break
        return linear

    def _moved(self, state: _State, move: FloatArray) -> _State:
        d = state.velocity.shape[1]
        coordinates = self.representation.moved(state.coordinates, move[:, :d])
        return _State(coordinates, state.velocity + move[:, d:])

    def _cost(self, linear: _Linear, loss: str, width: float, among: NDArray[np.bool_]) -> float:
        prior = prior_cost(self.interval_s, self.density, linear.steps, linear.state.velocity)
        return prior + float(np.sum(_charged(linear.squares, loss, width)[among]))


def _rigid(poses: Motor | Similarity) -> Motor:
    return poses.as_motor_scale()[0] if isinstance(poses, Similarity) else poses


def _charged(squares: FloatArray, loss: str, width: float) -> FloatArray:
    """``ρ(s)``, equal to s where it is small."""
    if loss == "cauchy":
        return np.asarray(width**2 * np.log1p(squares / width**2), dtype=np.float64)
    if loss == "huber":
        beyond = 2.0 * width * np.sqrt(squares) - width**2
        return np.where(squares <= width**2, squares, beyond)
    return squares


def _weights(squares: FloatArray, loss: str, width: float) -> FloatArray:
    """``ρ'(s)``."""
    if loss == "cauchy":
        return np.asarray(1.0 / (1.0 + squares / width**2), dtype=np.float64)
    if loss == "huber":
        return np.asarray(width / np.sqrt(np.maximum(squares, width**2)), dtype=np.float64)
    return np.ones_like(squares)
