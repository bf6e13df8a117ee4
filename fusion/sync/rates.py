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

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# Rates are means over so much time: longer than noise of single poses, shorter than motion.
_BASELINE_S = 0.15
_GRID_S = 0.005
_FEWEST = 20
_LEAST_OVERLAP_S = 2.0
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
    rates = _CameraRates.of(camera)
    turned = _Turned(imu)
    grid = np.arange(-round(search_s / _GRID_S), round(search_s / _GRID_S) + 1) * _GRID_S
    score = np.array([_norm_correlation(rates, turned, float(lag)) for lag in grid])
    if not np.any(np.isfinite(score)):
        raise ValueError(
            f"camera and imu: expected streams that overlap for {_LEAST_OVERLAP_S} s or more, got "
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
    rates: _CameraRates, turned: _Turned, offset_s: float, rotation: Rotor
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


@dataclass(frozen=True, eq=False)
class _CameraRates:
    """Mean rates ``(M, 3)`` in the camera's axes, from `start_ns` to `end_ns` ``(M,)``."""

    start_ns: IntArray
    end_ns: IntArray
    rate_rad_s: FloatArray

    @classmethod
    def of(cls, camera: Trajectory) -> _CameraRates:
        stamps = camera.time_ns
        end = np.searchsorted(stamps, stamps + round(_BASELINE_S * 1e9))
        end = np.maximum(end, np.arange(len(stamps)) + 1)
        start = np.flatnonzero(end < len(stamps))
        end = end[start]
        near = (stamps[end] - stamps[start]) * 1e-9 < 3.0 * _BASELINE_S  # no gap between
        start, end = start[near], end[near]
        rotors = camera.motors.rotor
        # Turns in the middle's axes: half of the turn carries neither forward nor back.
        turns = (rotors[start].inverse() @ rotors[end]).as_rotation_vector()
        seconds = (stamps[end] - stamps[start]) * 1e-9
        return cls(stamps[start], stamps[end], turns / seconds[:, None])

    def beside(self, turned: _Turned, offset_s: float) -> tuple[FloatArray, FloatArray]:
        """Rates ``(m, 3)`` of camera and IMU over the spans that the IMU covers."""
        used, shift = self.inside(turned, offset_s, 0.0), round(offset_s * 1e9)
        start, end = used.start_ns + shift, used.end_ns + shift
        angle = turned.at(end) - turned.at(start)
        return used.rate_rad_s, angle / ((end - start)[:, None] * 1e-9)

    def inside(self, turned: _Turned, offset_s: float, margin_s: float) -> _CameraRates:
        """Those over spans that the IMU covers, with a margin."""
        shift, margin = round(offset_s * 1e9), round(margin_s * 1e9)
        covered = turned.covers(self.start_ns + shift - margin, self.end_ns + shift + margin)
        return _CameraRates(self.start_ns[covered], self.end_ns[covered], self.rate_rad_s[covered])


class _Turned:
    """The gyroscope's running integral: good for mean rates over short times."""

    def __init__(self, imu: ImuStream) -> None:
        self.first_ns = int(imu.time_ns[0])
        parts = imu.stretches()
        self._begin_ns = np.array([one.time_ns[0] for one in parts])
        self._end_ns = np.array([one.time_ns[-1] for one in parts])
        rate = imu.angular_rate_rad_s
        steps = 0.5 * (rate[1:] + rate[:-1]) * (np.diff(imu.time_ns) * 1e-9)[:, None]
        self._angle = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        self._time = (imu.time_ns - self.first_ns).astype(np.float64)

    def covers(self, first_ns: IntArray, last_ns: IntArray) -> NDArray[np.bool_]:
        """Which spans ``(m,)`` lie in one stretch of the stream."""
        number = np.searchsorted(self._begin_ns, first_ns, side="right") - 1
        return np.asarray((number >= 0) & (last_ns <= self._end_ns[number]), dtype=np.bool_)

    def at(self, time_ns: IntArray) -> FloatArray:
        """Angles ``(m, 3)`` turned since the start."""
        wanted = (time_ns - self.first_ns).astype(np.float64)
        columns = [np.interp(wanted, self._time, column) for column in self._angle.T]
        return np.stack(columns, axis=-1)


def integrated_rate(imu: ImuStream, stamps_ns: IntArray) -> FloatArray:
    """Running integrals ``(N, 3)`` of the angular rate: differences are turns over short times."""
    return _Turned(imu).at(stamps_ns)


def _norm_correlation(rates: _CameraRates, turned: _Turned, offset_s: float) -> float:
    """Correlation of both norms at an offset, NaN where too little overlaps."""
    own, other = (np.linalg.norm(one, axis=-1) for one in rates.beside(turned, offset_s))
    if len(own) < _FEWEST:
        return np.nan
    if len(own) * float(np.median(np.diff(rates.start_ns))) * 1e-9 < _LEAST_OVERLAP_S:
        return np.nan
    # Of ranks, so that wrong poses count no more than others.
    return float(np.corrcoef(_ranks(own), _ranks(other))[0, 1])


def _ranks(values: FloatArray) -> FloatArray:
    ranks = np.empty(len(values))
    ranks[np.argsort(values, kind="stable")] = np.arange(len(values))
    return ranks


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
