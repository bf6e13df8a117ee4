"""What stamps and readings show by themselves: other units than nanoseconds, axes that are stuck.

A converter's last digit changes with the sensor's own noise. Readings that stay the same for two
seconds while the camera beside them turns are none, whichever number they show.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.health.verdict import HealthFinding
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

# No sensor of this kind is read out faster (the fastest MEMS parts give 32 kHz) or slower.
_IMU_HZ = (4.0, 33_000.0)
# Cameras and trackers.
_POSES_HZ = (0.05, 5_000.0)
_UNITS = {1_000: "µs", 1_000_000: "ms", 1_000_000_000: "s"}
_LEAST_COMMON = 0.5  # of the shorter span


def check_stamps(poses_ns: IntArray, imu_ns: IntArray) -> HealthFinding | None:
    """Whether stamps of either stream look like microseconds, milliseconds or seconds.

    They do where the rate is none that a sensor has and another unit makes it one, or where the
    streams do not overlap and another unit of one of them makes them.
    """
    factors = [1, *_UNITS]
    plain = _plausible(poses_ns, 1, _POSES_HZ) and _plausible(imu_ns, 1, _IMU_HZ)
    if plain and _common(poses_ns, imu_ns, 1, 1) >= _LEAST_COMMON:
        return None
    pairs = [(a, b) for a in factors for b in factors if (a, b) != (1, 1)]
    for of_poses, of_imu in sorted(pairs, key=lambda pair: (pair[0] * pair[1], pair[0])):
        if (
            _plausible(poses_ns, of_poses, _POSES_HZ)
            and _plausible(imu_ns, of_imu, _IMU_HZ)
            and _common(poses_ns, imu_ns, of_poses, of_imu) >= _LEAST_COMMON
        ):
            return HealthFinding("stamp_unit", _line(of_poses, of_imu))
    return None


def _line(of_poses: int, of_imu: int) -> str:
    wrong = {"the poses'": of_poses, "the IMU's": of_imu}
    each = [f"{whose} stamps are in {_UNITS[by]}" for whose, by in wrong.items() if by > 1]
    mend = " and ".join(f"{by:,}" for by in dict.fromkeys(wrong.values()) if by > 1)
    return f"{' and '.join(each)}, where nanoseconds are expected: multiply them by {mend}"


def _plausible(stamps: IntArray, factor: int, bounds: tuple[float, float]) -> bool:
    if len(stamps) < 2:
        return True
    rate = 1e9 / (float(np.median(np.diff(stamps))) * factor)
    return bounds[0] <= rate <= bounds[1]


def _common(poses_ns: IntArray, imu_ns: IntArray, of_poses: int, of_imu: int) -> float:
    """What both have in common, as a share of the shorter."""
    a, b = (float(value) * of_poses for value in poses_ns[[0, -1]])
    c, d = (float(value) * of_imu for value in imu_ns[[0, -1]])
    shorter = min(b - a, d - c)
    return (min(b, d) - max(a, c)) / shorter if shorter > 0.0 else 1.0


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
    return imu_T_camera.rotor.apply(turns)


def _changes_of_up(camera: Trajectory, imu_T_camera: Motor, span_ns: IntArray) -> FloatArray:
    """By how much the world's up ``(M, 3)`` in the IMU's axes changes."""
    earlier, later = _pairs(camera, span_ns)
    rotors = camera.motors.rotor.inverse()
    up = imu_T_camera.rotor.apply(rotors.apply(np.array([0.0, 0.0, 1.0])))
    return up[later] - up[earlier]
