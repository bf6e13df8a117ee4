"""Poses that contradict their neighbours, told apart before anything is estimated from them.

Each of its neighbours foretells a pose: its orientation by theirs and by what the gyroscope turned
between, its place by the lines through pairs of them. Medians of what each of them misses outvote
neighbours that are wrong themselves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.turning import integrated_rate
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.sync.rates import RateMatch
from motorcade.ga import Rotor, Trajectory
from motorcade.ga.arrays import FloatArray

_REACH = 3  # neighbours to either side
_NEAR_S = 0.5  # beyond, neither gyroscope nor lines foretell
_OUTLIER_THRESHOLD = 6.0  # of the median's deviation
_MEDIAN_NORM = 1.538  # of three normal numbers
_LEAST_RAD, _LEAST_M = 1e-4, 1e-4


def plausible(camera: Trajectory, imu: ImuStream, match: RateMatch) -> NDArray[np.bool_]:
    """Which poses ``(N,)`` agree with their neighbours; those that have none nearby count as such.

    Args:
        camera: `world_T_camera`, which the IMU covers.
        imu: the stream.
        match: where its clock and axes stand.
    """
    turned = np.linalg.norm(_turn_errors(camera, imu, match), axis=-1)
    shifted = np.linalg.norm(_place_errors(camera), axis=-1)
    mask: NDArray[np.bool_] = ~(_outliers(turned, _LEAST_RAD) | _outliers(shifted, _LEAST_M))
    return mask


def _outliers(error: FloatArray, least: float) -> NDArray[np.bool_]:
    """Which are far beyond what most are; NaN is not."""
    known = error[np.isfinite(error)]
    if known.size == 0:
        return np.zeros(len(error), dtype=np.bool_)
    scale = max(float(np.median(known)) / _MEDIAN_NORM, least)
    beyond: NDArray[np.bool_] = error > _OUTLIER_THRESHOLD * scale
    return beyond


def _steps() -> list[int]:
    return [k for k in range(-_REACH, _REACH + 1) if k != 0]


def _neighbours(count: int, step: int) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Indices ``(N,)`` so many poses on, and which of them exist."""
    index = np.arange(count) + step
    return np.clip(index, 0, count - 1), (index >= 0) & (index < count)


def _turn_errors(camera: Trajectory, imu: ImuStream, match: RateMatch) -> FloatArray:
    """Medians ``(N, 3)`` of what neighbours and the gyroscope miss of the orientations, rad."""
    stamps = camera.time_ns + round(match.offset_s * 1e9)
    angle = match.imu_R_camera.inverse().apply(integrated_rate(imu, stamps))
    rotors, missed = camera.motors.rotor, []
    for step in _steps():
        index, there = _neighbours(len(camera), step)
        there &= np.abs(camera.time_ns[index] - camera.time_ns) <= _NEAR_S * 1e9
        foretold = rotors[index] @ Rotor.from_rotation_vector(angle - angle[index])
        error = (foretold.inverse() @ rotors).as_rotation_vector()
        missed.append(np.where(there[:, None], error, np.nan))
    return _medians(missed)


def _place_errors(camera: Trajectory) -> FloatArray:
    """Medians ``(N, 3)`` of what lines through pairs of neighbours miss of the places, m."""
    place, time_s = camera.motors.translation_m, camera.time_s
    missed = []
    for first in _steps():
        for second in (step for step in _steps() if step > first):
            (a, a_there), (b, b_there) = (_neighbours(len(camera), k) for k in (first, second))
            near = np.maximum(np.abs(time_s[a] - time_s), np.abs(time_s[b] - time_s)) <= _NEAR_S
            there = a_there & b_there & near & (a != b)
            span = np.where(there, time_s[b] - time_s[a], 1.0)
            part = ((time_s - time_s[a]) / span)[:, None]
            error = place - (1.0 - part) * place[a] - part * place[b]
            missed.append(np.where(there[:, None], error, np.nan))
    return _medians(missed)


def _medians(missed: list[FloatArray]) -> FloatArray:
    """Medians of those that are known, NaN where none is."""
    stacked = np.stack(missed)
    none = np.all(np.isnan(stacked), axis=0)
    medians: FloatArray = np.nanmedian(np.where(none, 0.0, stacked), axis=0)
    return np.where(none, np.nan, medians)
