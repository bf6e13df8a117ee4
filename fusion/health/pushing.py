"""Accelerations of a camera's path beside the specific force that an accelerometer read.

The second difference of three positions is the path's acceleration under a hat-shaped window,
exactly, whatever the motion between them; so is the force when it is turned into the world and
taken under the same window. Nothing is differentiated but the positions, over half a second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.health.turning import LONGEST_STEP_S, RunningIntegral
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# From one position to the next: poses good to a centimetre then give accelerations to 0.1 m/s²,
# a hundredth of gravity and a tenth of what a hand does.
_HALF_S = 0.5
_LEAST_STEPS = 3
# Poses farther apart than so many of their usual steps leave the attitude between them open.
_MOST_GAP_STEPS = 3.5
# Parts of a window in which force and attitude are taken for constant.
_PARTS = 24


@dataclass(frozen=True, eq=False)
class Pushes:
    """K windows of the path.

    Fields:
        acceleration_m_s2: ``(K, 3)`` of the camera in the world.
        lever: ``(K, 3, 3)`` the same of a point a metre along each of the camera's axes, less that.
        attitude: ``(K, 3, 3)`` mean of the matrices `world_R_camera`.
        force: ``(K, 3, 3, 3)`` mean of the products of `world_R_camera` (first two) and the
            readings of the accelerometer (last).
    """

    acceleration_m_s2: FloatArray
    lever: FloatArray
    attitude: FloatArray
    force: FloatArray

    def __len__(self) -> int:
        return len(self.acceleration_m_s2)

    @classmethod
    def of(cls, camera: Trajectory, imu: ImuStream, offset_s: float, most: int) -> Pushes:
        """At most so many windows, spread evenly, that the IMU covers and no gap interrupts."""
        rows = _windows(camera)
        shift = round(offset_s * 1e9)
        stamps = camera.time_ns
        rows = rows[_covered(imu, stamps[rows[:, 0]] + shift, stamps[rows[:, 2]] + shift)]
        rows = rows[:: -(-len(rows) // most) or 1]
        first, middle, last = (stamps[column] for column in rows.T)
        before, after = (middle - first) * 1e-9, (last - middle) * 1e-9
        ends = first[:, None] + np.round(
            np.linspace(0.0, 1.0, _PARTS + 1) * (last - first)[:, None]
        ).astype(np.int64)
        middles = (ends[:, :-1] + ends[:, 1:]) // 2
        weight = _hat(middles, first, middle, last)
        turned = camera.motors_at(middles.ravel()).rotor.as_matrix().reshape(*middles.shape, 3, 3)
        force = _mean_force(imu, ends + shift)
        return cls(
            _second_difference(camera.motors.translation_m, rows, before, after),
            _second_difference(camera.motors.rotor.as_matrix(), rows, before, after),
            np.einsum("kb,kbij->kij", weight, turned),
            np.einsum("kb,kbij,kbl->kijl", weight, turned, force, optimize=True),
        )


def _windows(camera: Trajectory) -> IntArray:
    """Rows ``(K, 3)`` of poses at start, middle and end of windows that overlap by half."""
    stamps = camera.time_ns
    if len(stamps) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    steps = np.diff(stamps)
    usual = int(np.median(steps))
    half = max(round(_HALF_S * 1e9), _LEAST_STEPS * usual)
    longest = min(_MOST_GAP_STEPS * usual, LONGEST_STEP_S * 1e9)
    gaps = np.concatenate([[0], np.cumsum(steps > longest)])
    windows, start = [], 0
    while True:
        middle = int(np.searchsorted(stamps, stamps[start] + half))
        if middle >= len(stamps):
            break
        end = int(np.searchsorted(stamps, stamps[middle] + half))
        if end >= len(stamps):
            break
        if gaps[end] == gaps[start]:
            windows.append((start, middle, end))
            start = middle
        else:  # on behind the first gap in it
            start = int(np.searchsorted(gaps, gaps[start], side="right"))
    return np.array(windows, dtype=np.int64).reshape(-1, 3)


def _covered(imu: ImuStream, first_ns: IntArray, last_ns: IntArray) -> NDArray[np.intp]:
    parts = imu.segments()
    begin = np.array([one.time_ns[0] for one in parts])
    end = np.array([one.time_ns[-1] for one in parts])
    number = np.searchsorted(begin, first_ns, side="right") - 1
    return np.flatnonzero((number >= 0) & (last_ns <= end[number]))


def _second_difference(
    values: FloatArray, rows: IntArray, before: FloatArray, after: FloatArray
) -> FloatArray:
    """Of values ``(N, ...)``, divided so that it is the mean of the second derivative."""
    shape = (-1,) + (1,) * (values.ndim - 1)
    first, two, three = (values[column] for column in rows.T)
    before, after = before.reshape(shape), after.reshape(shape)
    slope: FloatArray = (three - two) / after - (two - first) / before
    return slope / (0.5 * (before + after))


def _hat(at: IntArray, first: IntArray, middle: IntArray, last: IntArray) -> FloatArray:
    """Weights ``(K, parts)`` of a hat from first to last whose tip is at the middle."""
    first, middle, last = first[:, None], middle[:, None], last[:, None]
    rising = (at - first) / (middle - first)
    falling = (last - at) / (last - middle)
    weight = np.minimum(rising, falling)
    normalised: FloatArray = weight / np.sum(weight, axis=1, keepdims=True)
    return normalised


def _mean_force(imu: ImuStream, ends_ns: IntArray) -> FloatArray:
    """Means ``(K, parts, 3)`` of the force between stamps ``(K, parts + 1)``."""
    at = RunningIntegral(imu.time_ns, imu.specific_force_m_s2).at(ends_ns.ravel())
    moved = np.diff(at.reshape(*ends_ns.shape, 3), axis=1)
    means: FloatArray = moved / (np.diff(ends_ns, axis=1) * 1e-9)[..., None]
    return means
