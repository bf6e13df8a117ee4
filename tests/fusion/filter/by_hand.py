"""What inertial samples do to an extended pose, by matrices of sines and cosines: a witness.

The product writes the same over multivectors (`motorcade.fusion.filter.model.definitions`). Here a
bias of the gyroscope turns the force to first order in the step only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.filter.extended_pose import extended_pose
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

_SERIES_BELOW_RAD = 0.02
_R, _P, _V, _BG, _BA = (slice(3 * i, 3 * i + 3) for i in range(5))
GRAVITY = np.array([0.0, 0.0, -9.81])


@dataclass(frozen=True, eq=False)
class Intervals:
    """Data between consecutive stamps: lengths ``(K,)``, mean rate and force ``(K, 3)``."""

    dt_s: FloatArray
    rate_rad_s: FloatArray
    force_m_s2: FloatArray


def skew(vectors: FloatArray) -> FloatArray:
    """Matrices ``(*, 3, 3)`` of the cross product with vectors ``(*, 3)``."""
    return np.cross(vectors[..., None, :], np.eye(3)).swapaxes(-1, -2)


@dataclass(frozen=True, eq=False)
class Increments:
    """Motion over K intervals, each in the frame at its start.

    Fields:
        turn_rad: rotation vectors ``(K, 3)``; `turn` their rotation matrices.
        first, second: ``(K, 3, 3)``, the mean of the turning frame over the interval and twice
            its weighted mean, so that Δv = first f Δt and Δp = second f Δt².
        force_m_s2: specific force ``(K, 3)``.
        velocity_m_s, position_m: Δv and Δp ``(K, 3)``.
    """

    dt_s: FloatArray
    force_m_s2: FloatArray
    turn_rad: FloatArray
    turn: FloatArray
    first: FloatArray
    second: FloatArray
    velocity_m_s: FloatArray
    position_m: FloatArray


def increments(data: Intervals, gyro_bias: FloatArray, accel_bias: FloatArray) -> Increments:
    """Increments of all intervals, with the biases taken off."""
    dt = data.dt_s[:, None]
    turn_rad = (data.rate_rad_s - gyro_bias) * dt
    force = data.force_m_s2 - accel_bias
    turn, first, second = _turning_means(turn_rad)
    velocity = np.einsum("kij,kj->ki", first, force) * dt
    position = np.einsum("kij,kj->ki", second, force) * dt**2
    return Increments(data.dt_s, force, turn_rad, turn, first, second, velocity, position)


def moved(start: Motor, bias: FloatArray, data: Intervals) -> Motor:
    """The extended pose ``(2,)`` after all intervals."""
    steps = increments(data, bias[:3], bias[3:])
    rotation, (position, velocity) = start[0].rotor.as_matrix(), start.translation_m
    for k, dt in enumerate(data.dt_s):
        position = position + velocity * dt + 0.5 * GRAVITY * dt**2 + rotation @ steps.position_m[k]
        velocity = velocity + GRAVITY * dt + rotation @ steps.velocity_m_s[k]
        rotation = rotation @ steps.turn[k]
    return extended_pose(Rotor.from_matrix(rotation), position, velocity)


def transitions(steps: Increments) -> FloatArray:
    """Matrices ``(K, 15, 15)`` that carry the error over each interval."""
    dt = steps.dt_s[:, None, None]
    back = np.swapaxes(steps.turn, -1, -2)
    cross = skew(steps.force_m_s2)
    matrices = np.zeros((len(steps.dt_s), 15, 15))
    matrices[:, _R, _R] = matrices[:, _P, _P] = matrices[:, _V, _V] = back
    matrices[:, _BG, _BG] = matrices[:, _BA, _BA] = np.eye(3)
    matrices[:, _P, _R] = -back @ skew(steps.position_m)
    matrices[:, _V, _R] = -back @ skew(steps.velocity_m_s)
    matrices[:, _P, _V] = back * dt
    matrices[:, _R, _BG] = -np.swapaxes(steps.first, -1, -2) * dt
    matrices[:, _V, _BG] = back @ cross * (dt**2 / 2)
    matrices[:, _P, _BG] = back @ cross * (dt**3 / 6)
    matrices[:, _V, _BA] = -back @ steps.first * dt
    matrices[:, _P, _BA] = -back @ steps.second * dt**2
    return matrices


def _turning_means(turn_rad: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """``Exp(φ)``, ``∫₀¹ Exp(sφ) ds`` and ``∫₀¹ (1-s) Exp(sφ) ds`` of turns ``(K, 3)``."""
    cross = skew(turn_rad)
    square = cross @ cross
    x2 = np.sum(turn_rad**2, axis=-1)[:, None, None]
    series = x2 < _SERIES_BELOW_RAD**2
    safe = np.where(series, 1.0, x2)
    x = np.sqrt(safe)
    s, c = np.sin(x), np.cos(x)
    # Coefficients of φ^n: sin x / x, (1 - cos x) / x², (x - sin x) / x³, (x²/2 - 1 + cos x) / x⁴
    a = np.where(series, 1 - x2 / 6 + x2**2 / 120, s / x)
    b = np.where(series, 1 / 2 - x2 / 24 + x2**2 / 720, (1 - c) / safe)
    d = np.where(series, 1 / 6 - x2 / 120 + x2**2 / 5040, (x - s) / (safe * x))
    e = np.where(series, 1 / 24 - x2 / 720, (safe / 2 - 1 + c) / safe**2)
    identity = np.eye(3)
    return (
        identity + a * cross + b * square,
        identity + b * cross + d * square,
        0.5 * identity + d * cross + e * square,
    )
