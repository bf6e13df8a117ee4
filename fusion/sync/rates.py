"""A start from angular rates alone: time offset by correlation, rotation by Wahba's problem.

How fast a rigid body turns is the same number in every one of its frames, so the norms of both
angular rates match before anything is known of the extrinsics. Sources: E. Mair et al.,
Spatio-temporal initialization for IMU to camera registration, ROBIO 2011; G. Wahba, A least squares
estimate of satellite attitude, SIAM Review 7(3), 1965.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.turning import (
    LEAST_OVERLAP_S,
    CameraRates,
    TurnedAngle,
    norm_correlations,
)
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Rotor, Trajectory
from motorcade.ga.arrays import FloatArray

_GRID_S = 0.005
_LEAST_CORRELATION = 0.5
_REFINEMENTS = 8
_CAUCHY = 11.3  # χ² with three degrees of freedom exceeds it in one of a hundred rates
_MEDIAN_CHI2 = 2.366  # its median
# Deviations of offset, rotation and bias beforehand: what nothing tells keeps them.
_LOOSE = np.repeat([1.0, np.pi, 10.0], [1, 3, 3])
_WRONG = 4.0  # medians of the difference of both norms


@dataclass(frozen=True)
class RateMatch:
    """What angular rates tell of two streams.

    Fields:
        offset_s: IMU's clock minus the camera's.
        offset_sigma_s: deviation of it, as the rates tell.
        imu_R_camera: the camera's orientation on the IMU; about the axis of a motion that turns
            about one axis only it is arbitrary.
        correlation: of the ranks of both rates' norms at that offset, up to 1.
        gyro_rms_rad_s: RMS of the angular rate about its mean.
    """

    offset_s: float
    offset_sigma_s: float
    imu_R_camera: Rotor
    correlation: float
    gyro_rms_rad_s: float


def match_rates(camera: Trajectory, imu: ImuStream, search_s: float) -> RateMatch:
    """Match both angular rates.

    Args:
        camera: poses of the camera; the frame that they are in does not matter.
        imu: the sensor's stream.
        search_s: how far from zero the offset may be.

    Raises:
        ValueError: streams that overlap for less than 2 s or 20 poses, or whose rates do not
            match anywhere within the search: too little rotation, or not one motion.
    """
    rates = CameraRates.of(camera)
    turned = TurnedAngle(imu)
    steps = round(search_s / _GRID_S)
    grid = _GRID_S * np.arange(-steps, steps + 1).astype(np.float64)
    score = norm_correlations(rates, turned, grid)
    if not np.any(np.isfinite(score)):
        raise ValueError(
            f"camera and imu: expected streams that overlap for {LEAST_OVERLAP_S} s or more, got "
            f"{camera.time_ns[0]} to {camera.time_ns[-1]} ns and {imu.time_ns[0]} to "
            f"{imu.time_ns[-1]} ns"
        )
    best = int(np.nanargmax(score))
    gyro = imu.angular_rate_rad_s - imu.angular_rate_rad_s.mean(axis=0)
    spread = float(np.sqrt(np.mean(np.sum(gyro**2, axis=-1))))
    if score[best] < _LEAST_CORRELATION:
        raise ValueError(
            f"camera and imu: expected angular rates that match within {search_s} s, got a "
            f"correlation of {score[best]:.2f} at best (the gyroscope turns by {spread:.3f} rad/s "
            "RMS): too little rotation, or not one motion"
        )
    offset = float(grid[best]) + _GRID_S * _peak(score, best)
    own, other = rates.beside(turned, offset)
    alike = _alike(own, other)
    rotation = _wahba(own[alike], other[alike])
    refined = _refined(rates, turned, offset, rotation)
    return RateMatch(*refined, float(score[best]), spread)


def _refined(
    rates: CameraRates, turned: TurnedAngle, offset_s: float, rotation: Rotor
) -> tuple[float, float, Rotor]:
    """Offset, its deviation and rotation by the rates' vectors; wrong ones weigh less.

    Noise of single poses makes rates that overlap differ by as much as it makes them agree, so
    that the deviation takes them for independent.
    """
    bias, covariance = np.zeros(3), np.zeros((7, 7))
    for _ in range(_REFINEMENTS):
        inside = rates.inside(turned, offset_s, _GRID_S)
        lags = offset_s, offset_s - 0.5 * _GRID_S, offset_s + 0.5 * _GRID_S
        (own, now), (_, before), (_, after) = (inside.beside(turned, lag) for lag in lags)
        expected = rotation.apply(own)
        left = now - expected - bias
        slope = np.zeros((len(own), 3, 7))
        slope[..., 0] = (after - before) / _GRID_S
        slope[..., 1:4] = np.cross(expected[:, None, :], np.eye(3)).swapaxes(-1, -2)
        slope[..., 4:] = -np.eye(3)
        squares = np.sum(left**2, axis=-1)
        scale = max(float(np.median(squares)) / _MEDIAN_CHI2, np.finfo(float).tiny)
        weight = 1.0 / (1.0 + squares / (_CAUCHY * scale))
        matrix = np.einsum("n,nij,nik->jk", weight, slope, slope)
        step = -np.linalg.lstsq(matrix, np.einsum("n,nij,ni->j", weight, slope, left))[0]
        step[0] = np.clip(step[0], -_GRID_S, _GRID_S)
        offset_s += float(step[0])
        rotation = Rotor.from_rotation_vector(step[1:4]) @ rotation
        bias = bias + step[4:]
        covariance = np.linalg.inv(matrix / scale + np.diag(_LOOSE**-2.0))
    return offset_s, float(np.sqrt(covariance[0, 0])), rotation


def _alike(own: FloatArray, other: FloatArray) -> NDArray[np.bool_]:
    """Which rates have norms that match as most do: those of wrong poses have not."""
    apart = np.abs(np.linalg.norm(own, axis=-1) - np.linalg.norm(other, axis=-1))
    alike: NDArray[np.bool_] = apart <= _WRONG * np.median(apart)
    return alike


def _peak(score: FloatArray, best: int) -> float:
    """Where between its neighbours the top of a parabola lies, in steps."""
    if not 0 < best < len(score) - 1 or not np.all(np.isfinite(score[best - 1 : best + 2])):
        return 0.0
    before, top, after = score[best - 1 : best + 2]
    curvature = before - 2.0 * top + after
    return float(0.5 * (before - after) / curvature) if curvature < 0.0 else 0.0


def _wahba(camera: FloatArray, imu: FloatArray) -> Rotor:
    """The rotation that takes the camera's rates to the IMU's, their means (biases) apart."""
    camera, imu = camera - camera.mean(axis=0), imu - imu.mean(axis=0)
    u, _, vt = np.linalg.svd(imu.T @ camera)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return Rotor.from_matrix(u @ sign @ vt)
