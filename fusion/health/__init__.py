"""Whether an IMU and a camera's path belong together as stated, and what is wrong where not."""

from __future__ import annotations

from motorcade.fusion.health.check import check_health
from motorcade.fusion.health.verdict import Health, HealthFinding

__all__ = ["Health", "HealthFinding", "check_health"]
