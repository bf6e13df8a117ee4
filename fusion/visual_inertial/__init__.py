"""Visual-inertial: metres, up and velocity for a camera's own map, and both adjusted together."""

from __future__ import annotations

from motorcade.fusion.visual_inertial.online import (
    InertialFrame,
    InertialSlam,
    InertialSlamResult,
    InertialState,
)
from motorcade.fusion.visual_inertial.sequence import FusedMap, MetricMap, fuse_map, metric_map
from motorcade.fusion.visual_inertial.start import InertialStart, start_inertial
from motorcade.fusion.visual_inertial.tight import (
    LandmarkObservations,
    VisualInertial,
    adjust_visual_inertial,
)
from motorcade.fusion.visual_inertial.window import InertialAdjuster, KeyframeMotion

__all__ = [
    "FusedMap",
    "InertialAdjuster",
    "InertialFrame",
    "InertialSlam",
    "InertialSlamResult",
    "InertialStart",
    "InertialState",
    "KeyframeMotion",
    "LandmarkObservations",
    "MetricMap",
    "VisualInertial",
    "adjust_visual_inertial",
    "fuse_map",
    "metric_map",
    "start_inertial",
]
