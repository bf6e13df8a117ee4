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

__all__ = ["AnalyticTruth", "RecordedTruth", "Truth", "truth_of"]

_TABLE_STEP_S = 1e-3
# The motions go on before and after; lags are sought within half a second.
_MARGIN_S = 1.5


class Truth(ABC):
    """True poses over time; times are seconds after `origin_ns`.

    Lags are found from a table of the truth at 1 kHz, between whose rows positions are taken on
    straight lines and rotations on normalised ones: off by 1e-7 s² of the acceleration.

    Fields:
        origin_ns: the stamp at which its time is zero.
        span_s: first and last time at which it is known.
    """

    origin_ns: int
    span_s: tuple[float, float]

    @abstractmethod
    def poses(self, time_s: FloatArray) -> tuple[Motor, FloatArray | None]:
        """Rigid poses ``(N,)`` at times ``(N,)``, and logarithms of scales where there are some."""

    def seconds(self, time_ns: IntArray) -> FloatArray:
        """Stamps ``(N,)`` as times of this truth."""
        return np.asarray((time_ns - self.origin_ns) * 1e-9, dtype=np.float64)

    def between_rows(self, time_s: FloatArray) -> tuple[FloatArray, Rotor]:
        """Positions ``(*, 3)`` and orientations ``(*)`` at times ``(*)``, from the table."""
        start_s, positions, rotors = self._table
        row = (time_s - start_s) / _TABLE_STEP_S
        before = np.clip(row.astype(np.int64), 0, len(positions) - 2)
        share = (row - before)[..., None]
        position = positions[before] + share * (positions[before + 1] - positions[before])
        rotor = rotors[before] + share * (rotors[before + 1] - rotors[before])
        return position, Rotor.normalize(rotor)

    @functools.cached_property
    def _table(self) -> tuple[float, FloatArray, FloatArray]:
        first_s, last_s = self.span_s
        count = int(np.ceil((last_s - first_s) / _TABLE_STEP_S)) + 1
        time_s = np.minimum(first_s + _TABLE_STEP_S * np.arange(count), last_s)
        motors, _ = self.poses(time_s)
        rotors = motors.rotor.coefficients
        flips = np.sum(rotors[1:] * rotors[:-1], axis=-1) < 0.0
        signs = np.where(np.concatenate([[False], np.cumsum(flips) % 2 == 1]), -1.0, 1.0)
        return first_s, motors.translation_m, signs[:, None] * rotors


class AnalyticTruth(Truth):
    """A motion of `MOTIONS`, exact at all times from a margin before 0 to one after its end."""

    def __init__(self, name: str, duration_s: float) -> None:
        self.motion = MOTIONS[name]
        self.origin_ns = 0
        self.span_s = (-_MARGIN_S, duration_s + _MARGIN_S)

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
        self._kept = trajectory  # the interpolation lives as long as this does

    def covers(self, time_s: FloatArray) -> NDArray[np.bool_]:
        """Which times do not lie in a hole of the reference, nor outside it."""
        return self._path.covers(time_s)

    def poses(self, time_s: FloatArray) -> tuple[Motor, FloatArray | None]:
        """See `Truth`."""
        return self._path.poses(time_s), None


@functools.cache
def truth_of(motion: str, duration_s: float) -> AnalyticTruth:
    """The truth of a named motion, made once in a process."""
    return AnalyticTruth(motion, duration_s)
