"""Single steps of preintegration: from one sample to the next, by either rule."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.filter.extended_pose import ERROR_SIZE, extended_pose, skew
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.preintegration.preintegrated import Preintegrated
from motorcade.ga import FloatArray, Rotor

__all__ = ["single_steps"]

_R, _P, _V, _BG, _BA = (slice(3 * i, 3 * i + 3) for i in range(5))
# Below this the closed forms lose digits; the series there are exact to the last one.
_SERIES_BELOW_RAD = 0.02


def single_steps(
    data: ImuStream, noise: ImuNoise, gyro_bias: FloatArray, accel_bias: FloatArray, held: bool
) -> Preintegrated:
    """One interval for each of the stream's M steps; biases ``(M, 3)``; rules: `preintegrate`."""
    dt_s = np.diff(data.time_ns) * 1e-9
    rate, force = data.angular_rate_rad_s, data.specific_force_m_s2
    if held:
        rate, force = rate[:-1], force[:-1]
    else:
        rate, force = 0.5 * (rate[1:] + rate[:-1]), 0.5 * (force[1:] + force[:-1])
    dt = dt_s[:, None]
    turn, force = (rate - gyro_bias) * dt, force - accel_bias
    rotor = Rotor.from_rotation_vector(turn)
    first, second = _turning_means(turn)
    slope = first.swapaxes(-1, -2)
    # How the turning frame's means change with the rate: a small turn grows linearly meanwhile.
    swing = 0.5 * skew(force), skew(force) / 6.0
    if held:
        first = np.broadcast_to(np.eye(3), first.shape)
        second, swing = 0.5 * first, (np.zeros_like(first), np.zeros_like(first))
    gained = np.einsum("kij,kj->ki", first, force) * dt
    moved = np.einsum("kij,kj->ki", second, force) * dt**2
    back = np.swapaxes(rotor.as_matrix(), -1, -2)
    step = dt[..., None]
    matrix = np.zeros((len(dt_s), ERROR_SIZE, ERROR_SIZE))
    matrix[:, _R, _R] = matrix[:, _P, _P] = matrix[:, _V, _V] = back
    matrix[:, _BG, _BG] = matrix[:, _BA, _BA] = np.eye(3)
    matrix[:, _P, _R], matrix[:, _V, _R] = -back @ skew(moved), -back @ skew(gained)
    matrix[:, _P, _V] = back * step
    matrix[:, _R, _BG] = -slope * step
    matrix[:, _V, _BG], matrix[:, _P, _BG] = back @ swing[0] * step**2, back @ swing[1] * step**3
    matrix[:, _V, _BA], matrix[:, _P, _BA] = -back @ first * step, -back @ second * step**2
    return Preintegrated(
        dt_s, extended_pose(rotor, moved, gained), gyro_bias, accel_bias, matrix,
        _added(matrix[:, :9, 9:], dt_s, noise),
    )  # fmt: skip


def _added(by_bias: FloatArray, dt_s: FloatArray, noise: ImuNoise) -> FloatArray:
    """Covariances of single steps: a sample's white noise acts as a bias of that step alone."""
    densities = [noise.gyro_density_rad_s_rthz, noise.accel_density_m_s2_rthz]
    walks = [noise.gyro_walk_rad_s2_rthz, noise.accel_walk_m_s3_rthz]
    white = np.repeat(np.square(densities), 3) / dt_s[:, None]
    added = np.zeros((len(dt_s), ERROR_SIZE, ERROR_SIZE))
    added[:, :9, :9] = (by_bias * white[:, None, :]) @ by_bias.swapaxes(-1, -2)
    biases = np.arange(9, ERROR_SIZE)
    added[:, biases, biases] = np.repeat(np.square(walks), 3) * dt_s[:, None]
    return added


def _turning_means(turn_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """``∫₀¹ Exp(sφ) ds`` and ``∫₀¹ (1-s) Exp(sφ) ds`` of turns ``(K, 3)``."""
    cross = skew(turn_rad)
    square = cross @ cross
    x2 = np.sum(turn_rad**2, axis=-1)[:, None, None]
    series = x2 < _SERIES_BELOW_RAD**2
    safe = np.where(series, 1.0, x2)
    x = np.sqrt(safe)
    # Coefficients of φ^n: (1 - cos x) / x², (x - sin x) / x³, (x²/2 - 1 + cos x) / x⁴
    b = np.where(series, 1 / 2 - x2 / 24 + x2**2 / 720, (1 - np.cos(x)) / safe)
    d = np.where(series, 1 / 6 - x2 / 120 + x2**2 / 5040, (x - np.sin(x)) / (safe * x))
    e = np.where(series, 1 / 24 - x2 / 720, (safe / 2 - 1 + np.cos(x)) / safe**2)
    identity = np.eye(3)
    return identity + b * cross + d * square, 0.5 * identity + d * cross + e * square
