"""The true motion that smoothed paths are held against: a formula, or a recorded reference."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.metrics import log_scales
from motorcade.fusion.metrics.smooth_path import SmoothPath
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import check_count, stretches

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
        stretches_s: ``(S, 2)`` first and last time of the stretches between long gaps.
    """

    origin_ns: int
    span_s: tuple[float, float]
    stretches_s: FloatArray

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
        """First times ``(S,)`` of the stretches, their first rows, positions and rotors."""
        first_s = np.maximum(self.stretches_s[:, 0] - _MARGIN_S, self.span_s[0])
        last_s = np.minimum(self.stretches_s[:, 1] + _MARGIN_S, self.span_s[1])
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
        self.stretches_s = np.array([self.span_s])

    @property
    def has_scale(self) -> bool:
        """Whether its poses are similarities."""
        return self.motion.versor is Similarity

    def poses(self, time_s: FloatArray) -> tuple[Motor, FloatArray | None]:
        """See `Truth`."""
        poses = self.motion.at(time_s).pose
        if isinstance(poses, Motor):
            return poses, None
        return poses.rigid, log_scales(poses)


class RecordedTruth(Truth):
    """A rigid reference trajectory, made smooth by cubic splines; see `SmoothPath`.

    Raises:
        NotObservableError: fewer than two poses.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self._path = SmoothPath.through(trajectory)
        self.origin_ns = self._path.origin_ns
        self.span_s = self._path.span_s
        ends = [(part.start, part.stop - 1) for part in stretches(trajectory.time_ns)]
        self.stretches_s = self._path.seconds(trajectory.time_ns[np.array(ends)])
        self._kept = trajectory  # the interpolation lives as long as this does

    def covers(self, time_s: FloatArray) -> NDArray[np.bool_]:
        """Which times do not lie in a hole of the reference, nor outside it."""
        return self._path.covers(time_s)

    def poses(self, time_s: FloatArray) -> tuple[Motor, FloatArray | None]:
        """See `Truth`."""
        return self._path.poses(time_s), None


@functools.cache
def truth_of(motion: str, duration_s: float) -> AnalyticTruth:
    """The ground truth of a named motion, made once in a process."""
    return AnalyticTruth(motion, duration_s)
