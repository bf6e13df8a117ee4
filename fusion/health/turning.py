"""What a camera and a gyroscope turned over the same short spans of time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# Rates are means over so much time: longer than noise of single poses, shorter than motion.
_BASELINE_S = 0.15
# From a pose to the next; what turns between poses farther apart is open.
LONGEST_STEP_S = 3.0 * _BASELINE_S
# Three axes, and a tail heavier than the normal distribution's.
_STEADY_SIGMAS = 6.0
# A gyroscope's scale may be off by so much and be sound.
_STEADY_SHARE = 0.1
FEWEST_SPANS = 20
LEAST_OVERLAP_S = 2.0


@dataclass(frozen=True, eq=False)
class CameraRates:
    """Mean rates ``(M, 3)`` in the camera's axes, from `start_ns` to `end_ns` ``(M,)``."""

    start_ns: IntArray
    end_ns: IntArray
    rate_rad_s: FloatArray

    @classmethod
    def of(cls, camera: Trajectory) -> CameraRates:
        """Those of every span of 0.15 s, or from a pose to the next, that starts at a pose."""
        stamps = camera.time_ns
        end = np.searchsorted(stamps, stamps + round(_BASELINE_S * 1e9))
        end = np.maximum(end, np.arange(len(stamps)) + 1)
        start = np.flatnonzero(end < len(stamps))
        end = end[start]
        near = (stamps[end] - stamps[start]) * 1e-9 < LONGEST_STEP_S  # no gap between
        start, end = start[near], end[near]
        rotors = camera.motors.rotor
        # Turns in the middle's axes: half of the turn carries neither forward nor back.
        turns = (rotors[start].inverse() @ rotors[end]).as_rotation_vector()
        seconds = (stamps[end] - stamps[start]) * 1e-9
        return cls(stamps[start], stamps[end], turns / seconds[:, None])

    def __len__(self) -> int:
        return len(self.start_ns)

    def beside(self, turned: TurnedAngle, offset_s: float) -> tuple[FloatArray, FloatArray]:
        """Rates ``(m, 3)`` of camera and IMU over the spans that the IMU covers."""
        used, shift = self.inside(turned, offset_s, 0.0), round(offset_s * 1e9)
        start, end = used.start_ns + shift, used.end_ns + shift
        angle = turned.at(end) - turned.at(start)
        return used.rate_rad_s, angle / ((end - start)[:, None] * 1e-9)

    def inside(self, turned: TurnedAngle, offset_s: float, margin_s: float) -> CameraRates:
        """Those over spans that the IMU covers, with a margin."""
        shift, margin = round(offset_s * 1e9), round(margin_s * 1e9)
        covered = turned.covers(self.start_ns + shift - margin, self.end_ns + shift + margin)
        return self[np.flatnonzero(covered)]

    def disjoint(self, most: int) -> CameraRates:
        """At most so many that do not overlap, spread evenly over the whole."""
        if len(self) < 2:
            return self
        longest = np.median(self.end_ns - self.start_ns)
        step = max(1, round(float(longest / np.median(np.diff(self.start_ns)))))
        step = max(step, -(-len(self) // most))
        return self[np.arange(0, len(self), step)]

    def __getitem__(self, rows: IntArray) -> CameraRates:
        return CameraRates(self.start_ns[rows], self.end_ns[rows], self.rate_rad_s[rows])


class TurnedAngle:
    """The gyroscope's running integral: good for mean rates over short times."""

    def __init__(self, imu: ImuStream) -> None:
        parts = imu.segments()
        self._begin_ns = np.array([one.time_ns[0] for one in parts])
        self._end_ns = np.array([one.time_ns[-1] for one in parts])
        self._angle = RunningIntegral(imu.time_ns, imu.angular_rate_rad_s)

    def covers(self, first_ns: IntArray, last_ns: IntArray) -> NDArray[np.bool_]:
        """Which spans ``(m,)`` lie in one segment of the stream."""
        number = np.searchsorted(self._begin_ns, first_ns, side="right") - 1
        return np.asarray((number >= 0) & (last_ns <= self._end_ns[number]), dtype=np.bool_)

    def at(self, time_ns: IntArray) -> FloatArray:
        """Angles ``(m, 3)`` turned since the start."""
        return self._angle.at(time_ns)


def steady(
    camera: Trajectory,
    turned: TurnedAngle,
    offset_s: float,
    camera_R_read: FloatArray,
    bias_rad_s: FloatArray,
    sigma: float,
) -> NDArray[np.bool_]:
    """Which poses ``(N,)`` turned from one of their neighbours as the gyroscope says.

    Args:
        camera: the poses.
        turned: integral of the readings.
        offset_s: what is added to the poses' stamps.
        camera_R_read: ``(3, 3)`` from readings to rates in the camera's axes.
        bias_rad_s: ``(3,)`` of the readings.
        sigma: of the camera's mean rates over spans of 0.15 s, rad/s an axis.
    """
    rotors = camera.motors.rotor
    turns = (rotors[:-1].inverse() @ rotors[1:]).as_rotation_vector()
    read = np.diff(turned.at(camera.time_ns + round(offset_s * 1e9)), axis=0)
    read -= np.diff(camera.time_ns)[:, None] * 1e-9 * bias_rad_s
    read = read @ camera_R_read.T
    apart = np.linalg.norm(turns - read, axis=-1)
    allowed = _STEADY_SIGMAS * sigma * _BASELINE_S + _STEADY_SHARE * np.linalg.norm(read, axis=-1)
    right = np.concatenate([[False], apart < allowed, [False]])
    return np.asarray(right[:-1] | right[1:], dtype=np.bool_)


def integrated_rate(imu: ImuStream, stamps_ns: IntArray) -> FloatArray:
    """Running integrals ``(N, 3)`` of the angular rate: differences are turns over short times."""
    return TurnedAngle(imu).at(stamps_ns)


def norm_correlations(rates: CameraRates, turned: TurnedAngle, offsets_s: FloatArray) -> FloatArray:
    """Correlations ``(M,)`` of how fast both turn, NaN where too little overlaps.

    Of ranks, so that wrong poses count no more than others.
    """
    stamps, places = np.unique(np.stack([rates.start_ns, rates.end_ns]), return_inverse=True)
    first, last = places.reshape(2, -1)
    norms = np.linalg.norm(rates.rate_rad_s, axis=-1)
    ranks, seconds = _ranks(norms), (rates.end_ns - rates.start_ns) * 1e-9
    step_s = float(np.median(np.diff(rates.start_ns))) * 1e-9 if len(rates) > 1 else 0.0

    def correlation(offset_s: float) -> float:
        shift = round(offset_s * 1e9)
        covered = turned.covers(rates.start_ns + shift, rates.end_ns + shift)
        count = np.count_nonzero(covered)
        if count < FEWEST_SPANS or count * step_s < LEAST_OVERLAP_S:
            return np.nan
        angle = turned.at(stamps + shift)
        read = np.linalg.norm(angle[last] - angle[first], axis=-1) / seconds
        if count == len(covered):
            return _correlation(ranks, _ranks(read))
        return _correlation(_ranks(norms[covered]), _ranks(read[covered]))

    return np.array([correlation(float(one)) for one in offsets_s])


def _correlation(first: FloatArray, second: FloatArray) -> float:
    """Of ranks from 0 on, none twice: their mean and spread are known from their number."""
    count = len(first)
    mean, spread = 0.5 * (count - 1), count * (count * count - 1) / 12.0
    return float((first @ second - count * mean * mean) / spread)


def _ranks(values: FloatArray) -> FloatArray:
    ranks = np.empty(len(values))
    ranks[np.argsort(values, kind="stable")] = np.arange(len(values))
    return ranks


# Up to so many samples the sum at each is kept, in six megabytes; of more one in eight, and those
# between are made again where they are asked for.
_ALL_KEPT, _STRIDE = 1 << 18, 8
_BLOCK = 1 << 15  # samples at once


class RunningIntegral:
    """Integral from the first sample on, by trapezoids.

    Args:
        time_ns: ``(N,)`` rising.
        values: ``(N, 3)``; both are held, not copied.
    """

    def __init__(self, time_ns: IntArray, values: FloatArray) -> None:
        self._time_ns, self._values = time_ns, values
        self._stride = stride = 1 if len(time_ns) <= _ALL_KEPT else _STRIDE
        kept = np.zeros(((len(time_ns) - 1) // stride + 1, 3))
        for first in range(0, len(time_ns) - 1, _BLOCK):
            steps = self._steps(np.arange(first, min(first + _BLOCK, len(time_ns) - 1)))
            steps[0] += kept[first // stride]
            sums = np.cumsum(steps, axis=0)[stride - 1 :: stride]
            kept[first // stride + 1 : first // stride + 1 + len(sums)] = sums
        self._kept = kept

    def at(self, time_ns: IntArray) -> FloatArray:
        """The integral at stamps ``(m,)``, between samples by the line between their sums.

        Before the first sample it is zero, after the last as there.
        """
        most = _BLOCK // self._stride
        parts = [self._at(time_ns[k : k + most]) for k in range(0, len(time_ns), most)]
        return np.concatenate(parts) if parts else np.zeros((0, 3))

    def _at(self, time_ns: IntArray) -> FloatArray:
        known = self._time_ns
        wanted = np.clip(time_ns, known[0], known[-1])
        before = np.minimum(np.searchsorted(known, wanted, side="right"), len(known) - 1) - 1
        share = (wanted - known[before]) / (known[before + 1] - known[before])
        if self._stride == 1:
            sums = np.take(self._kept, before, axis=0)
            sums += share[:, None] * (np.take(self._kept, before + 1, axis=0) - sums)
            return sums
        number, left = np.divmod(before, self._stride)
        sums = self._kept[number]
        for k in range(self._stride - 1):  # in the order in which the kept ones were summed
            more = np.flatnonzero(left > k)
            sums[more] += self._steps(number[more] * self._stride + k)
        sums += share[:, None] * self._steps(before)
        return sums

    def _steps(self, rows: IntArray) -> FloatArray:
        """What is added from samples to the next ones ``(m, 3)``."""
        seconds = (self._time_ns[rows + 1] - self._time_ns[rows]) * 1e-9
        steps: FloatArray = 0.5 * (self._values[rows] + self._values[rows + 1]) * seconds[:, None]
        return steps
