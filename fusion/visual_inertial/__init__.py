"""Visual-inertial: metres, up and velocity for a camera's own map, and both adjusted together."""

from __future__ import annotations

from motorcade.fusion.visual_inertial.online import InertialSlam, InertialSlamResult
from motorcade.fusion.visual_inertial.sequence import (
    MetricMap,
    adjust_visual_inertial,
    metric_map,
)
from motorcade.fusion.visual_inertial.start import start_inertial

__all__ = [
    "InertialSlam",
    "InertialSlamResult",
    "MetricMap",
    "adjust_visual_inertial",
    "metric_map",
    "start_inertial",
]
