"""What inertial samples do to an extended pose: increments of motion, transition of its error.

Over an interval Δt the moving frame's rate and force are taken as constant at their means, and

    R' = R ΔR,   v' = v + g Δt + R Δv,   p' = p + v Δt + ½ g Δt² + R Δp

holds exactly. The error on the right of the estimate then moves by ``Ad(ΔR, Δp, Δv)⁻¹`` after
``ρ += Δt ν``, whatever the estimate is: only biases enter by linearisation (A. Barrau and S.
Bonnabel, The invariant extended Kalman filter as a stable observer, IEEE TAC 62(4), 2017).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.filter.extended_pose import ERROR_SIZE, skew
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.ga import FloatArray, Motor, Rotor, kernels

__all__ = ["Increments", "Intervals", "advance", "increments", "process_noise", "transitions"]

_SERIES_BELOW_RAD = 0.02
_R, _P, _V, _BG, _BA = (slice(3 * i, 3 * i + 3) for i in range(5))


@dataclass(frozen=True, eq=False)
class Intervals:
    """Data between consecutive stamps: lengths ``(K,)``, mean rate and force ``(K, 3)``."""

    dt_s: FloatArray
    rate_rad_s: FloatArray
    force_m_s2: FloatArray


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


def advance(
    rotor: Rotor, position_m: FloatArray, velocity_m_s: FloatArray, steps: Increments,
    gravity_m_s2: float,
) -> tuple[Rotor, FloatArray, FloatArray]:  # fmt: skip
    """Rotors ``(K,)``, positions and velocities ``(K, 3)`` after each step from one state."""
    twists = np.concatenate([steps.turn_rad, np.zeros_like(steps.turn_rad)], axis=-1)
    turned = _running(rotor, twists)
    starts = np.concatenate([rotor.as_matrix()[None], turned.as_matrix()[:-1]])
    dt = steps.dt_s[:, None]
    fall = np.array([0.0, 0.0, -gravity_m_s2])
    gained = fall * dt + np.einsum("kij,kj->ki", starts, steps.velocity_m_s)
    velocity = velocity_m_s + np.cumsum(gained, axis=0)
    before = velocity - gained
    moved = before * dt + 0.5 * fall * dt**2 + np.einsum("kij,kj->ki", starts, steps.position_m)
    return turned, position_m + np.cumsum(moved, axis=0), velocity


def transitions(steps: Increments) -> FloatArray:
    """Matrices ``(K, 15, 15)`` that carry the error over each interval."""
    dt = steps.dt_s[:, None, None]
    back = np.swapaxes(steps.turn, -1, -2)
    cross = skew(steps.force_m_s2)
    matrices = np.zeros((len(steps.dt_s), ERROR_SIZE, ERROR_SIZE))
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


def process_noise(dt_s: FloatArray, noise: ImuNoise) -> FloatArray:
    """Covariances ``(K, 15, 15)`` that white noise and bias walks add in each interval."""
    dt = dt_s[:, None]
    added = np.zeros((len(dt_s), ERROR_SIZE, ERROR_SIZE))
    every, three = np.arange(ERROR_SIZE), np.arange(3)
    force = noise.accel_density_m_s2_rthz**2
    diagonal = np.repeat(
        np.concatenate(
            [
                noise.gyro_density_rad_s_rthz**2 * dt,
                force * dt**3 / 3,
                force * dt,
                noise.gyro_walk_rad_s2_rthz**2 * dt,
                noise.accel_walk_m_s3_rthz**2 * dt,
            ],
            axis=1,
        ),
        3,
        axis=1,
    )
    added[:, every, every] = diagonal
    added[:, 3 + three, 6 + three] = added[:, 6 + three, 3 + three] = force * dt**2 / 2
    return added


def _running(rotor: Rotor, twists: FloatArray) -> Rotor:
    """Products of the rotor with the first 1, 2, … K turns, by doubling: log₂ K batched steps."""
    products = Motor.from_twist(twists).coefficients.copy()
    shift = 1
    while shift < len(products):
        products[shift:] = kernels.compose(products[:-shift], products[shift:])
        shift *= 2
    start = Motor.from_rotor_translation(rotor, np.zeros(3))
    return (start @ Motor(products)).rotor


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
