"""Which measurements an IMU covers, and at which stamps a path can be told."""

from __future__ import annotations

import numpy as np

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import IntArray
from motorcade.tracking.measurements import PoseMeasurements

__all__ = ["covered", "wanted_stamps"]


def covered(measurements: PoseMeasurements, imu: ImuStream, shift_ns: int = 0) -> PoseMeasurements:
    """The measurements within the IMU's span, their stamps `shift_ns` later on its clock.

    Raises:
        ValueError: spans that do not overlap.
    """
    first, last = int(imu.time_ns[0]), int(imu.time_ns[-1])
    stamps = measurements.trajectory.time_ns + shift_ns
    inside = (stamps >= first) & (stamps <= last)
    if not np.any(inside):
        raise ValueError(
            f"measurements and imu: expected spans that overlap, got {stamps[0]} to {stamps[-1]} "
            f"ns and {first} to {last} ns"
        )
    if np.all(inside):
        return measurements
    return PoseMeasurements(measurements.trajectory[inside], measurements.covariance[inside])


def wanted_stamps(
    measured_ns: IntArray, imu: ImuStream, stamps_ns: IntArray | None = None
) -> IntArray:
    """The stamps asked for that lie between the first measurement and the IMU's end.

    Args:
        measured_ns: on the IMU's clock; all of them where no others are asked for.
        imu: whose span bounds the path.
        stamps_ns: rising integers.

    Raises:
        ValueError: stamps that are no rising integers, or none that can be served.
    """
    if stamps_ns is None:
        return measured_ns
    start, last = measured_ns[0], imu.time_ns[-1]
    given = np.asarray(stamps_ns)
    if given.dtype.kind != "i" or given.ndim != 1 or np.any(np.diff(given) <= 0):
        raise ValueError("stamps_ns: expected rising integer nanoseconds (M,), got others")
    wanted: IntArray = given[(given >= start) & (given <= last)].astype(np.int64)
    if wanted.size == 0:
        raise ValueError(f"stamps_ns: expected some within [{start}, {last}], got none")
    return wanted
