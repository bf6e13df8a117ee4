"""Stamps in another unit than nanoseconds, told by what no sensor does and by spans that miss."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.health.verdict import HealthFinding
from motorcade.ga.arrays import IntArray

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
