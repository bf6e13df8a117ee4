"""Metrics: pose errors by evo's definitions, jitter, lag, and all of them in one value."""

from __future__ import annotations

from motorcade.fusion.metrics.evaluate import Evaluation, evaluate
from motorcade.fusion.metrics.jitter import Jitter, accelerations, jitter, jitter_above
from motorcade.fusion.metrics.lag import angular_rate_lag_s, position_lag_s
from motorcade.fusion.metrics.pose_error import (
    Align,
    Alignment,
    Pairs,
    Statistics,
    absolute_translation_m,
    align,
    alignment_of,
    associate,
    relative_errors,
    rotation_rad,
    tilt_rad,
)
from motorcade.fusion.metrics.smooth_path import NotObservableError

__all__ = [
    "Align",
    "Alignment",
    "Evaluation",
    "Jitter",
    "NotObservableError",
    "Pairs",
    "Statistics",
    "absolute_translation_m",
    "accelerations",
    "align",
    "alignment_of",
    "angular_rate_lag_s",
    "associate",
    "evaluate",
    "jitter",
    "jitter_above",
    "position_lag_s",
    "relative_errors",
    "rotation_rad",
    "tilt_rad",
]
