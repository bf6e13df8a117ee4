"""Filtering: poses fused with an IMU on the group of extended poses, live and over recordings."""

from motorcade.fusion.filter.findings import LearntNoise
from motorcade.fusion.filter.fuse import fuse
from motorcade.fusion.filter.fused import Fused, latency_curve
from motorcade.fusion.filter.learning import learn_noise
from motorcade.fusion.filter.pose_filter import PoseFilter
from motorcade.fusion.filter.settings import FilterSettings

__all__ = [
    "FilterSettings",
    "Fused",
    "LearntNoise",
    "PoseFilter",
    "fuse",
    "latency_curve",
    "learn_noise",
]
