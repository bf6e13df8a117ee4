"""Orientation from gyroscope and accelerometer alone, with gyro bias and rest."""

from __future__ import annotations

from motorcade.fusion.orientation.estimate import (
    Orientation,
    OrientationFilter,
    OrientationModel,
    estimate_orientation,
)

__all__ = ["Orientation", "OrientationFilter", "OrientationModel", "estimate_orientation"]
