"""Orientation from gyroscope and accelerometer alone, with gyro bias and rest."""

from __future__ import annotations

from motorcade.fusion.orientation.estimate import (
    Orientation,
    OrientationFilter,
    estimate_orientation,
)
from motorcade.fusion.orientation.model import OrientationModel

__all__ = ["Orientation", "OrientationFilter", "OrientationModel", "estimate_orientation"]
