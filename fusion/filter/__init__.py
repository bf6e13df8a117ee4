"""Filtering: camera poses fused with an IMU on the group of extended poses."""

from motorcade.fusion.filter.error_state import FilterSettings
from motorcade.fusion.filter.fuse import Fused, fuse

__all__ = ["FilterSettings", "Fused", "fuse"]
