"""Filtering: poses fused with an IMU on the group of extended poses, live and over recordings."""

from motorcade.fusion.filter.findings import LatencyCurve, LearntNoise, NoiseScore
from motorcade.fusion.filter.fitting import fit_noise
from motorcade.fusion.filter.fuse import fuse
from motorcade.fusion.filter.fused import Fused, latency_curve
from motorcade.fusion.filter.learning import learn_noise
from motorcade.fusion.filter.pose_filter import FilterState, Innovation, PoseFilter
from motorcade.fusion.filter.settings import FilterSettings, RestDetection
from motorcade.fusion.filter.sourced import Judgement

__all__ = [
    "FilterSettings",
    "FilterState",
    "Fused",
    "Innovation",
    "Judgement",
    "LatencyCurve",
    "LearntNoise",
    "NoiseScore",
    "PoseFilter",
    "RestDetection",
    "fit_noise",
    "fuse",
    "latency_curve",
    "learn_noise",
]
