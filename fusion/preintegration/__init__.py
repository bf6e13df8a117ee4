"""Preintegration: what an IMU says between two keyframes, summed up once and for all."""

from __future__ import annotations

from motorcade.fusion.preintegration.preintegrate import preintegrate
from motorcade.fusion.preintegration.preintegrated import Preintegrated

__all__ = ["Preintegrated", "preintegrate"]
