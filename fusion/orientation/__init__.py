"""Orientation from gyroscope, accelerometer and, where there is one, magnetometer.

`world_R_imu` maps coordinates of the sensor to those of the world, whose z points up and, with a
magnetometer, whose y points to magnetic north. Units are rad/s and m/s²; a field may have any.
"""

from __future__ import annotations

from motorcade.fusion.orientation.estimate import (
    Orientation,
    OrientationFilter,
    OrientationModel,
    estimate_orientation,
    orientation_doubts,
)

__all__ = [
    "Orientation",
    "OrientationFilter",
    "OrientationModel",
    "estimate_orientation",
    "orientation_doubts",
]
