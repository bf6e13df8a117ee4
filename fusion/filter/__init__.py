"""Filtering: camera poses fused with an IMU on the group of extended poses."""

from motorcade.fusion.filter.fuse import Fused, fuse
from motorcade.fusion.filter.settings import FilterSettings, RestDetection

__all__ = ["FilterSettings", "Fused", "RestDetection", "fuse"]
