"""Similarities apart: the rigid part, which all other metrics judge, and the scale."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

__all__ = ["log_scales", "without_scale"]


def without_scale(trajectory: Trajectory) -> Trajectory:
    """The same orientations and positions as rigid poses; the metrics take no others.

    Examples:
        >>> from motorcade.fusion.metrics import without_scale
        >>> from motorcade.fusion.motions import zoom
        >>> without_scale(zoom().sampled(30.0, 1.0)).motors.shape
        (31,)
    """
    if isinstance(trajectory.poses, Motor):
        return trajectory
    return Trajectory(
        trajectory.time_ns, trajectory.poses.rigid, trajectory.parent, trajectory.child
    )


def log_scales(poses: Motor | Similarity) -> FloatArray:
    """Logarithms of the scales ``(*)``; zero for rigid poses.

    Examples:
        >>> from motorcade.fusion.metrics import log_scales
        >>> from motorcade.ga import Motor, Similarity
        >>> log_scales(Similarity.from_motor_scale(Motor.identity((2,)), [1.0, 2.0])).round(6)
        array([0.      , 0.693147])
    """
    if isinstance(poses, Motor):
        return np.zeros(poses.shape)
    logarithms: FloatArray = np.log(poses.scale)
    return logarithms
