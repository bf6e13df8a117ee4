"""The true motion that smoothed paths are held against: a formula, or a recorded reference.

A recorded motion is a true path from a file, such as a flight under motion capture; twelve seconds
of it, or how long a plan takes, are sampled and degraded like any other motion.
"""

from __future__ import annotations

import functools
import hashlib
from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.metrics import log_scales
from motorcade.fusion.metrics.smooth_path import SmoothPath
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import check_count, segments
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
