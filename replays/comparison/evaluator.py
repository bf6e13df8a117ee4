"""The true motion of a comparison, and the metrics of many paths at the same stamps against it.

Definitions are those of `motorcade.fusion.metrics`, to which the tests hold every figure. What the
ground truth has to say (accelerations, stops, turns, its path at every lag that is tried) is
computed once, so a path costs a fraction of a millisecond, where each metric alone takes a hundred.

The lag is the peak of the correlation of what was measured with the ground truth read earlier,
unknown where the ground truth does not move, the peak lies at the edge, or it is too flat to place.
Between the lags of the table, 10 ms apart, the correlation is the quartic through five of them,
which places the peak to some microseconds.

The true motion is a formula, or a path from a file, such as a flight under motion capture; twelve
seconds of it, or how long a plan takes, are sampled and degraded like any other motion.
"""

from __future__ import annotations

import functools
import hashlib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.metrics import accelerations, log_scales
from motorcade.fusion.metrics.artifacts import (
    overshoots,
    position_way,
    rotation_way,
    steps_rad,
    winding_count,
)
from motorcade.fusion.metrics.jitter import rates
from motorcade.fusion.metrics.lag import fit_scores, standard_error_s
from motorcade.fusion.metrics.smooth_path import SmoothPath
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import check_count, near_steps, segments
from motorcade.replays.io.trajectories import read_trajectory

_TABLE_STEP_S = 1e-3
# The motions go on before and after; lags are sought within half a second.
_MARGIN_S = 1.5


class Truth(ABC):
    """True poses over time; times are seconds after `origin_ns`.

    Lags are found from a table of the ground truth at 1 kHz, between whose rows positions are taken
    on straight lines and rotations on normalised ones: off by 1e-7 s² of the acceleration.

    Fields:
        origin_ns: the stamp at which its time is zero.
        span_s: first and last time at which it is known.
        segments_s: ``(S, 2)`` first and last time of the segments between long gaps.
    """

    origin_ns: int
    span_s: tuple[float, float]
    segments_s: FloatArray

    @abstractmethod
    def poses(self, time_s: FloatArray) -> tuple[Motor, FloatArray | None]:
        """Rigid poses ``(N,)`` at times ``(N,)``, and logarithms of scales where there are some."""

    def seconds(self, time_ns: IntArray) -> FloatArray:
        """Stamps ``(N,)`` as times of this ground truth."""
        return np.asarray((time_ns - self.origin_ns) * 1e-9, dtype=np.float64)

    def between_rows(self, time_s: FloatArray) -> tuple[FloatArray, Rotor]:
        """Positions ``(*, 3)`` and orientations ``(*)`` at times ``(*)``, from the table."""
        first_s, offset, positions, rotors = self._table
        part = np.clip(np.searchsorted(first_s, time_s, side="right") - 1, 0, None)
        row = (time_s - first_s[part]) / _TABLE_STEP_S + offset[part]
        before = np.clip(row.astype(np.int64), 0, len(positions) - 2)
        share = (row - before)[..., None]
        position = positions[before] + share * (positions[before + 1] - positions[before])
        rotor = rotors[before] + share * (rotors[before + 1] - rotors[before])
        return position, Rotor.normalize(rotor)

    @functools.cached_property
    def _table(self) -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
        """First times ``(S,)`` of the segments, their first rows, positions and rotors."""
        first_s = np.maximum(self.segments_s[:, 0] - _MARGIN_S, self.span_s[0])
        last_s = np.minimum(self.segments_s[:, 1] + _MARGIN_S, self.span_s[1])
        counts = np.ceil((last_s - first_s) / _TABLE_STEP_S).astype(np.int64) + 1
        check_count(int(counts.sum()), f"truth of {self.span_s[1]:.6g} s in milliseconds")
        time_s = np.concatenate(
            [
                np.minimum(first + _TABLE_STEP_S * np.arange(count), last)
                for first, last, count in zip(first_s, last_s, counts, strict=True)
            ]
        )
        motors, _ = self.poses(time_s)
        rotors = motors.rotor.coefficients
        flips = np.sum(rotors[1:] * rotors[:-1], axis=-1) < 0.0
        signs = np.where(np.concatenate([[False], np.cumsum(flips) % 2 == 1]), -1.0, 1.0)
        offset = np.append(0, np.cumsum(counts)[:-1])
        return first_s, offset, motors.translation_m, signs[:, None] * rotors


class AnalyticTruth(Truth):
    """A motion of `MOTIONS`, exact at all times from a margin before 0 to one after its end."""

    def __init__(self, name: str, duration_s: float) -> None:
        self.motion = MOTIONS[name]
        self.origin_ns = 0
        self.span_s = (-_MARGIN_S, duration_s + _MARGIN_S)
        self.segments_s = np.array([self.span_s])

    @property
    def has_scale(self) -> bool:
        """Whether its poses are similarities."""
        return self.motion.versor is Similarity

    def sampled(self, rate_hz: float, duration_s: float) -> Trajectory:
        """True poses at an even rate from time 0 on."""
        return self.motion.sampled(rate_hz, duration_s)

    def poses(self, time_s: FloatArray) -> tuple[Motor, FloatArray | None]:
        """See `Truth`."""
        poses = self.motion.at(time_s).pose
        if isinstance(poses, Motor):
            return poses, None
        return poses.rigid, log_scales(poses)


class RecordedTruth(Truth):
    """A rigid reference trajectory, made smooth by cubic splines; see `SmoothPath`.

    Raises NotObservableError: fewer than two poses.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self._path = SmoothPath.through(trajectory)
        self.origin_ns = self._path.origin_ns
        self.span_s = self._path.span_s
        ends = [(part.start, part.stop - 1) for part in segments(trajectory.time_ns)]
        self.segments_s = self._path.seconds(trajectory.time_ns[np.array(ends)])
        self._kept = trajectory  # the interpolation lives as long as this does

    def covers(self, time_s: FloatArray) -> NDArray[np.bool_]:
        """Which times do not lie in a hole of the reference, nor outside it."""
        return self._path.covers(time_s)

    def poses(self, time_s: FloatArray) -> tuple[Motor, FloatArray | None]:
        """See `Truth`."""
        return self._path.poses(time_s), None


@dataclass(frozen=True)
class RecordedMotion:
    """A true path from a file, as a motion of a comparison.

    Fields:
        name: what tables call it.
        file: its absolute path; every process that computes reads it.
        digest: SHA-256 of its stamps and poses.
        rate_hz: of KITTI files, which have no stamps.
        times: or the absolute path of the file that holds their stamps.
    """

    name: str
    file: str
    digest: str
    rate_hz: float | None = None
    times: str | None = None

    @classmethod
    def of(
        cls, path: Path, rate_hz: float | None = None, times: Path | None = None
    ) -> RecordedMotion:
        """A trajectory file; named after it. Raises RecordingError: a file that cannot be read."""
        trajectory = read_trajectory(path, rate_hz=rate_hz, times=times)
        stamps = None if times is None else str(times.resolve())
        return cls(path.stem, str(path.resolve()), digest_of(trajectory), rate_hz, stamps)

    def read(self) -> Trajectory:
        """The whole path. Raises ValueError: the file holds another path by now."""
        trajectory = read_trajectory(self.file, rate_hz=self.rate_hz, times=self.times)
        if digest_of(trajectory) != self.digest:
            raise ValueError(f"{self.file}: changed since the comparison began")
        return trajectory


def digest_of(*paths: Trajectory) -> str:
    """SHA-256 of all stamps and poses."""
    content = hashlib.sha256()
    for path in paths:
        content.update(path.time_ns.tobytes() + path.motors.coefficients.tobytes())
    return content.hexdigest()


class RecordedMotionTruth(RecordedTruth):
    """The middle of a recorded motion's longest segment without a gap, and a margin about it.

    Raises ValueError: no segment is as long as the plan's duration and two margins.
    """

    has_scale = False

    def __init__(self, recorded: RecordedMotion, duration_s: float) -> None:
        path = recorded.read()
        longest = max(segments(path.time_ns), key=lambda part: _length_ns(path.time_ns[part]))
        stamps = path.time_ns[longest]
        spare_s = 1e-9 * _length_ns(stamps) - duration_s - 2.0 * _MARGIN_S
        if spare_s < 0.0:
            raise ValueError(
                f"{recorded.file}: expected {duration_s + 2.0 * _MARGIN_S:g} s without a gap of "
                f"10 s, got {1e-9 * _length_ns(stamps):.3g} s"
            )
        start_ns = int(stamps[0]) + round(1e9 * (0.5 * spare_s + _MARGIN_S))
        margin_ns = round(1e9 * _MARGIN_S)
        end_ns = start_ns + round(1e9 * duration_s) + margin_ns
        first, last = np.searchsorted(path.time_ns, [start_ns - margin_ns, end_ns]).tolist()
        super().__init__(path[max(first - 1, longest.start) : min(last + 1, longest.stop)])
        self._start_ns = start_ns

    def sampled(self, rate_hz: float, duration_s: float) -> Trajectory:
        """True poses at an even rate."""
        count = int(np.floor(duration_s * rate_hz * (1.0 + 1e-12))) + 1
        time_ns = self._start_ns + np.round(1e9 / rate_hz * np.arange(count)).astype(np.int64)
        poses, _ = self.poses(self.seconds(time_ns))
        return Trajectory(time_ns, poses, self._kept.parent, self._kept.child)


def _length_ns(time_ns: IntArray) -> int:
    return int(time_ns[-1] - time_ns[0])


@functools.cache
def truth_of(
    motion: str, duration_s: float, recorded: RecordedMotion | None = None
) -> AnalyticTruth | RecordedMotionTruth:
    """The ground truth of a motion, by its name or from a file, made once in a process."""
    if recorded is not None:
        return RecordedMotionTruth(recorded, duration_s)
    return AnalyticTruth(motion, duration_s)


ERRORS = (
    "ape_rmse_m",
    "rotation_rmse_deg",
    "linear_jitter_m_s2",
    "angular_jitter_rad_s2",
    "log_scale_rmse",
)
"""The metrics that parameters are tuned by; the last one of similarities only."""

METRICS = (
    *ERRORS,
    "lag_ms",
    "angular_rate_lag_ms",
    "overshoot_m",
    "rotation_overshoot_deg",
    "rotation_path_ratio",
    "peak_rate_ratio",
    "spurious_turns",
)
"""What `PathEvaluator.measure` tells, in order."""


class PathEvaluator:
    """Measures paths at given stamps against the ground truth there.

    Args:
        time_ns: stamps ``(N,)``, five or more, that the ground truth knows.
        truth: in the world of the paths.
    """

    def __init__(self, time_ns: IntArray, truth: Truth) -> None:
        self.truth = truth
        self.time_s = truth.seconds(time_ns)
        self.true, self.true_log_scale = truth.poses(self.time_s)
        steps = np.diff(self.time_s)
        near = near_steps(steps)
        self._whole = near[1:] & near[:-1]
        self._true_accelerations = self._accelerations(self.true)

    def errors(self, paths: Sequence[Trajectory]) -> FloatArray:
        """`ERRORS` ``(P, 5)`` of paths at these stamps; NaN where poses have no scale."""
        return self._errors(*_stacked(paths))

    def measure(self, paths: Sequence[Trajectory]) -> FloatArray:
        """`METRICS` ``(P, 12)`` of paths at these stamps; NaN where one cannot be told."""
        poses, log_scale = _stacked(paths)
        return np.concatenate(
            [
                self._errors(poses, log_scale),
                1e3 * self._positions.lags_s(poses.translation_m),
                1e3 * self._rates.lags_s(rates(self.time_s, poses)[1]),
                self._overshoot(poses),
                self._turning(poses),
            ],
            axis=1,
        )

    def _errors(self, poses: Motor, log_scale: FloatArray | None) -> FloatArray:
        away = np.sum((poses.translation_m - self.true.translation_m) ** 2, axis=-1)
        turned = np.rad2deg((self.true.rotor.inverse() @ poses.rotor).angle())
        ours = self._accelerations(poses)
        jitter = [
            np.sqrt(np.mean(np.sum((a - b) ** 2, axis=-1), axis=-1))
            for a, b in zip(ours, self._true_accelerations, strict=True)
        ]
        scale = np.full(len(away), np.nan)
        if log_scale is not None and self.true_log_scale is not None:
            scale = np.sqrt(np.mean((log_scale - self.true_log_scale) ** 2, axis=-1))
        ape, rotation = np.sqrt(np.mean(away, axis=-1)), np.sqrt(np.mean(turned**2, axis=-1))
        return np.stack([ape, rotation, *jitter, scale], axis=-1)

    def _accelerations(self, poses: Motor) -> tuple[FloatArray, FloatArray]:
        """Of many paths, without those across gaps."""
        linear, angular = accelerations(self.time_s, poses)
        return linear[..., self._whole, :], angular[..., self._whole, :]

    @functools.cached_property
    def _positions(self) -> LagTable:
        return LagTable.of_positions(self.truth, self.time_s)

    @functools.cached_property
    def _rates(self) -> LagTable:
        return LagTable.of_rates(self.truth, self.time_s)

    def _overshoot(self, poses: Motor) -> FloatArray:
        """Largest overshoot of position in metres and rotation in degrees ``(P, 2)``."""
        metres, radians = (
            overshoots(poses, self.true, self.time_s, way) for way in (position_way, rotation_way)
        )
        return np.stack([metres, np.rad2deg(radians)], axis=-1)

    def _turning(self, poses: Motor) -> FloatArray:
        """The gimbal index ``(P, 3)``."""
        steps_s = np.diff(self.time_s)
        turned, true = steps_rad(poses.rotor), steps_rad(self.true.rotor)
        if not np.sum(true) > 1e-9:
            return np.full((len(poses), 3), np.nan)
        error = self.true.rotor.inverse() @ poses.rotor
        turns = np.array([float(winding_count(error[i])) for i in range(len(poses))])
        path = np.sum(turned, axis=-1) / np.sum(true)
        peak = np.max(turned / steps_s, axis=-1) / np.max(true / steps_s)
        return np.stack([path, peak, turns], axis=-1)


def _stacked(paths: Sequence[Trajectory]) -> tuple[Motor, FloatArray | None]:
    """Rigid poses ``(P, N)`` and logarithms of scales ``(P, N)`` where there are some."""
    poses = paths[0].poses
    if isinstance(poses, Motor):
        return Motor.stack([path.motors for path in paths]), None
    parts = [path.poses.as_motor_scale() for path in paths if isinstance(path.poses, Similarity)]
    scales = np.stack([scale for _, scale in parts])
    return Motor.stack([motor for motor, _ in parts]), np.log(scales)


_STEP_S = 0.01
_LARGEST_S = 0.5
_FEWEST = 4
# Rates from the table are that even where the motion is.
_EVEN = 1e-6
_LONGEST_STEP_S = 0.25
_AROUND = np.arange(-2, 3)
# Coefficients of the quartic through values at -2 ... 2.
_QUARTIC = np.linalg.inv(np.vander(_AROUND.astype(np.float64), 5, increasing=True))
# Value and slope at x of the parabola through -1, 0, 1 are these rows times (1, x, x²).
_PARABOLA = np.linalg.inv(np.vander(np.arange(-1.0, 2.0), 3, increasing=True))


@dataclass(frozen=True, eq=False)
class LagTable:
    """The ground truth ``(L, K, 3)`` at lags ``(L,)`` for the stamps (or steps) `kept` ``(K,)``.

    `largest_error_s`, half the median interval, is how badly a peak may be known.
    """

    lag_s: FloatArray
    true: FloatArray
    kept: IntArray
    largest_error_s: float

    @classmethod
    def of_positions(cls, truth: Truth, time_s: FloatArray) -> LagTable:
        """For positions at stamps ``(N,)``."""
        lag_s, kept = _inner(truth, time_s, time_s, np.ones(time_s.size, dtype=np.bool_))
        true, _ = truth.between_rows(time_s[kept] - lag_s[:, None])
        return cls(lag_s, true, kept, _half_step(time_s))

    @classmethod
    def of_rates(cls, truth: Truth, time_s: FloatArray) -> LagTable:
        """For mean angular rates over the steps between stamps ``(N,)``."""
        steps = np.diff(time_s)
        near = near_steps(steps) & (steps <= _LONGEST_STEP_S)
        lag_s, kept = _inner(truth, time_s[:-1], time_s[1:], near)
        _, first = truth.between_rows(time_s[kept] - lag_s[:, None])
        _, second = truth.between_rows(time_s[kept + 1] - lag_s[:, None])
        turns = (first.inverse() @ second).as_rotation_vector()
        return cls(lag_s, turns / steps[kept, None], kept, _half_step(time_s))

    def lags_s(self, paths: FloatArray) -> FloatArray:
        """Lags ``(P, 1)`` of values ``(P, N, 3)`` at the stamps or steps; NaN where unknown."""
        ours = paths[:, self.kept]
        overshoots = np.full((len(paths), 1), np.nan)
        if len(self.kept) < _FEWEST or len(self.lag_s) < 5 or not _changes(self.true):
            return overshoots
        centred = ours - ours.mean(axis=1, keepdims=True)
        size = np.linalg.norm(centred, axis=(1, 2))
        true = self.true - self.true.mean(axis=1, keepdims=True)
        flat = true.reshape(len(true), -1)
        flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
        height = np.einsum("pk,lk->pl", centred.reshape(len(ours), -1), flat)
        for i, heights in enumerate(height):
            if size[i] > _EVEN * np.linalg.norm(ours[i]):
                overshoots[i, 0] = self._peak(centred[i], heights, true)
        return overshoots

    def _peak(self, ours: FloatArray, height: FloatArray, true: FloatArray) -> float:
        best = int(np.argmax(height))
        if best in (0, len(height) - 1) or not height[best] > 0.0:
            return np.nan
        centre = min(max(best, 2), len(height) - 3)
        place = centre + _top(height[centre + _AROUND], best - centre)
        nearest = min(max(round(place), 1), len(height) - 2)
        error_s = _standard_error_s(ours, true[nearest - 1 : nearest + 2], place - nearest)
        if not error_s <= self.largest_error_s:
            return np.nan
        return float(self.lag_s[0] + _STEP_S * place)


def _inner(
    truth: Truth, start_s: FloatArray, end_s: FloatArray, usable: NDArray[np.bool_]
) -> tuple[FloatArray, IntArray]:
    """Lags to try, and which segments stay in the ground truth at all of them."""
    first, last = truth.span_s
    overlap = min(last, float(end_s.max())) - max(first, float(start_s.min()))
    count = int(min(_LARGEST_S, 0.25 * overlap) / _STEP_S + 1e-9)
    lag_s: FloatArray = np.arange(-count, count + 1) * np.float64(_STEP_S)
    inside = (start_s - lag_s[-1] >= first) & (end_s + lag_s[-1] <= last)
    kept: IntArray = np.flatnonzero(inside & usable).astype(np.int64)
    return lag_s, kept


def _changes(true: FloatArray) -> bool:
    middle = true[len(true) // 2]
    centred = middle - middle.mean(axis=0)
    return bool(np.linalg.norm(centred) > _EVEN * np.linalg.norm(middle))


def _half_step(time_s: FloatArray) -> float:
    return 0.5 * float(np.median(np.diff(time_s)))


def _top(height: FloatArray, start: float) -> float:
    """Where the quartic through five values at -2 ... 2 is highest, near `start`."""
    c = _QUARTIC @ height
    x = float(start)
    for _ in range(20):
        slope = c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * 4.0 * c[4]))
        curvature = 2.0 * c[2] + x * (6.0 * c[3] + x * 12.0 * c[4])
        if not curvature < 0.0:
            break
        step = min(max(-slope / curvature, -0.5), 0.5)
        x = min(max(x + step, start - 1.0), start + 1.0)
        if abs(step) < 1e-12:
            break
    return x


def _standard_error_s(ours: FloatArray, true: FloatArray, x: float) -> float:
    """Standard error of a peak.

    `ours` ``(K, 3)`` is centred, and so is the ground truth ``(3, K, 3)`` at the lags around the
    peak, which lies `x` steps from the middle one.
    """
    value = np.array([1.0, x, x * x]) @ _PARABOLA
    rate = np.array([0.0, 1.0, 2.0 * x]) @ _PARABOLA / _STEP_S
    b, change = np.tensordot(value, true, 1), np.tensordot(rate, true, 1)
    return standard_error_s(ours, *fit_scores(ours, b, change))
