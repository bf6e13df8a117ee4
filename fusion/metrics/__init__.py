"""Metrics of trajectories: errors by evo's and KITTI's definitions, smoothness, lag, artifacts.

Estimate and ground truth are trajectories of the same moving frame in worlds that agree or are
aligned first. Errors are in metres and radians (`evaluate` states degrees and milliseconds, as its
keys say), jitter in m/s² and rad/s²; positive lag is late.

`evaluate` puts all that needs no more than an estimate and its ground truth into one value. What
the trajectories cannot tell raises `NotObservableError`.
"""

from __future__ import annotations

from motorcade.fusion.metrics.artifacts import (
    FrameChangeDefect,
    GimbalIndex,
    frame_change_defect,
    gimbal_index,
    path_over_geodesic,
    position_overshoot_m,
    rotation_overshoot_rad,
    rotation_path_rad,
)
from motorcade.fusion.metrics.consistency import (
    Consistency,
    chi2_bounds,
    most_by_chance,
    normalised_squared,
)
from motorcade.fusion.metrics.cost import seconds_per_pose
from motorcade.fusion.metrics.evaluation import Evaluation, evaluate
from motorcade.fusion.metrics.jitter import (
    EnergyExcess,
    Jitter,
    Smoothness,
    accelerations,
    energy_excess_above,
    jitter,
    jitter_above,
    log_dimensionless_jerk,
)
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
    log_scales,
    relative_errors,
    rotation_rad,
    tilt_rad,
    without_scale,
)
from motorcade.fusion.metrics.relative_by_length import (
    Drift,
    drift_by_length,
    relative_errors_by_length,
)
from motorcade.fusion.metrics.smooth_path import NotObservableError

__all__ = [
    "Align",
    "Alignment",
    "Consistency",
    "Drift",
    "EnergyExcess",
    "Evaluation",
    "FrameChangeDefect",
    "GimbalIndex",
    "Jitter",
    "NotObservableError",
    "Pairs",
    "Smoothness",
    "Statistics",
    "absolute_translation_m",
    "accelerations",
    "align",
    "alignment_of",
    "angular_rate_lag_s",
    "associate",
    "chi2_bounds",
    "drift_by_length",
    "energy_excess_above",
    "evaluate",
    "frame_change_defect",
    "gimbal_index",
    "jitter",
    "jitter_above",
    "log_dimensionless_jerk",
    "log_scales",
    "most_by_chance",
    "normalised_squared",
    "path_over_geodesic",
    "position_lag_s",
    "position_overshoot_m",
    "relative_errors",
    "relative_errors_by_length",
    "rotation_overshoot_rad",
    "rotation_path_rad",
    "rotation_rad",
    "seconds_per_pose",
    "tilt_rad",
    "without_scale",
]
