"""Axes of a sensor that are dead, frozen or saturated, told from readings that repeat exactly.

A converter's last digit changes with the sensor's own noise. Readings that stay the same for two
seconds while the camera beside them turns are none, whichever number they show.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.health.verdict import HealthFinding
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

_LEAST_S = 2.0
# Turns are looked at over so long a time: noise of poses is then small beside them.
_OVER_S = 1.0
# Three degrees: one in five of the changes must be larger.
_CHANGED, _CHANGED_QUANTILE = 0.05, 0.8


def find_stuck_axes(
    camera: Trajectory, imu: ImuStream, imu_T_camera: Motor, offset_s: float, *, up: bool
) -> list[HealthFinding]:
    """Findings of axes that repeat one reading while what they measure changes.

    Of the gyroscope, turns about the axis; of the accelerometer, how far the world's up, where that
    is known, is along it.
    """
    sensors = [("gyroscope", "rad/s", imu.angular_rate_rad_s, _turns_between)]
    if up:
        sensors.append(("accelerometer", "m/s²", imu.specific_force_m_s2, _changes_of_up))
    findings = []
    for sensor, unit, readings, changes_between in sensors:
        lines = []
        for axis, name in enumerate("xyz"):
            first, last = _longest_repeat(readings[:, axis])
            seconds = 1e-9 * float(imu.time_ns[last] - imu.time_ns[first])
            values = readings[:, axis]
            ends = values[first] in (np.min(values), np.max(values))
            cut_off = ends and last - first < len(values) // 2
            if seconds < _LEAST_S or cut_off:
                continue
            span_ns = imu.time_ns[[first, last]] - round(1e9 * offset_s)
            changes = changes_between(camera, imu_T_camera, span_ns)[:, axis]
            if changes.size and np.quantile(np.abs(changes), _CHANGED_QUANTILE) > _CHANGED:
                lines.append(f"{name} {values[first]:.6g} {unit} for {seconds:.1f} s")
        if lines:
            line = (
                f"the {sensor} reads the same again and again while the camera turns "
                f"({', '.join(lines)}): it is dead or frozen there; leave that time out, or record "
                "anew"
            )
            findings.append(HealthFinding("stuck", line))
    return findings


def _longest_repeat(readings: FloatArray) -> tuple[int, int]:
    """First and last row of the longest run of one reading."""
    ends = np.flatnonzero(np.append(np.diff(readings) != 0.0, True))
    starts = np.append(0, ends[:-1] + 1)
    longest = int(np.argmax(ends - starts))
    return int(starts[longest]), int(ends[longest])


def _pairs(camera: Trajectory, span_ns: IntArray) -> tuple[IntArray, IntArray]:
    """Rows of poses a second apart, within a span of the camera's time."""
    stamps = camera.time_ns
    later = np.searchsorted(stamps, stamps + round(1e9 * _OVER_S))
    earlier = np.flatnonzero((stamps >= span_ns[0]) & (later < len(stamps)))
    earlier = earlier[stamps[later[earlier]] <= span_ns[1]]
    return earlier, later[earlier]


def _turns_between(camera: Trajectory, imu_T_camera: Motor, span_ns: IntArray) -> FloatArray:
    """Rotation vectors ``(M, 3)`` in the IMU's axes."""
    earlier, later = _pairs(camera, span_ns)
    rotors = camera.motors.rotor
    turns = (rotors[earlier].inverse() @ rotors[later]).as_rotation_vector()
    vectors: FloatArray = imu_T_camera.rotor.apply(turns)
    return vectors


def _changes_of_up(camera: Trajectory, imu_T_camera: Motor, span_ns: IntArray) -> FloatArray:
    """By how much the world's up ``(M, 3)`` in the IMU's axes changes."""
    earlier, later = _pairs(camera, span_ns)
    rotors = camera.motors.rotor.inverse()
    up = imu_T_camera.rotor.apply(rotors.apply(np.array([0.0, 0.0, 1.0])))
    changes: FloatArray = up[later] - up[earlier]
    return changes
