"""Metrics of trajectories: errors by evo's and KITTI's definitions, smoothness, lag, artifacts.

Estimate and ground truth are trajectories of the same moving frame in worlds that agree or are
aligned first. Errors are in metres and radians (`evaluate` states degrees and milliseconds, as its
keys say), jitter in m/s² and rad/s²; positive lag is late.

`evaluate` puts all that needs no more than an estimate and its ground truth into one value. What
the trajectories cannot tell raises `NotObservableError`.
"""

from __future__ import annotations

from motorcade.fusion.metrics.artifacts import (
    frame_change_defect,
    gimbal_index,
    position_overshoot_m,
    rotation_overshoot_rad,
)
from motorcade.fusion.metrics.consistency import (
    Consistency,
    chi2_bounds,
    most_by_chance,
    normalised_squared,
)
from motorcade.fusion.metrics.evaluation import (
    Evaluation,
    Matched,
    evaluate,
    evaluate_matched,
    match,
    seconds_per_pose,
)
from motorcade.fusion.metrics.jitter import (
    accelerations,
    energy_excess_above,
    jitter,
    jitter_above,
    log_dimensionless_jerk,
)
from motorcade.fusion.metrics.lag import angular_rate_lag_s, position_lag_s
from motorcade.fusion.metrics.poses.alignment import (
    Align,
    Plane,
    align,
    alignment_of,
    associate,
    cropped,
)
from motorcade.fusion.metrics.poses.pose_error import (
    KITTI_LENGTHS_M,
    Delta,
    Relation,
    absolute_errors,
    absolute_translation_m,
    drift_by_length,
    log_scales,
    relative_errors,
    rotation_rad,
    tilt_rad,
)
from motorcade.fusion.metrics.smooth_path import NotObservableError

__all__ = [
    "KITTI_LENGTHS_M",
    "Align",
    "Consistency",
    "Delta",
    "Evaluation",
    "Matched",
    "NotObservableError",
    "Plane",
    "Relation",
    "absolute_errors",
    "absolute_translation_m",
    "accelerations",
    "align",
    "alignment_of",
    "angular_rate_lag_s",
    "associate",
    "chi2_bounds",
    "cropped",
    "drift_by_length",
    "energy_excess_above",
    "evaluate",
    "evaluate_matched",
    "frame_change_defect",
    "gimbal_index",
    "jitter",
    "jitter_above",
    "log_dimensionless_jerk",
    "log_scales",
    "match",
    "most_by_chance",
    "normalised_squared",
    "position_lag_s",
    "position_overshoot_m",
    "relative_errors",
    "rotation_overshoot_rad",
    "rotation_rad",
    "seconds_per_pose",
    "tilt_rad",
]
