"""Whether an IMU and a camera's path belong together as stated, and what is wrong where not."""

from __future__ import annotations

from motorcade.fusion.health.check import check_health
from motorcade.fusion.health.verdict import Finding, Health

__all__ = ["Finding", "Health", "check_health"]
