"""Motors as gtsam's poses and back, which perturb on the right too; and its optimiser."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

if TYPE_CHECKING:
    import gtsam

__all__ = ["as_motor", "as_pose", "as_poses", "optimised"]


def as_pose(motor: Motor) -> gtsam.Pose3:
    """One motor as a Pose3."""
    import gtsam

    return gtsam.Pose3(motor.as_matrix())


def as_poses(motors: Motor) -> list[gtsam.Pose3]:
    """Motor ``(N,)`` as a list of Pose3."""
    import gtsam

    return [gtsam.Pose3(matrix) for matrix in motors.as_matrix()]


def optimised(
    factors: gtsam.NonlinearFactorGraph, start: gtsam.Values, iterations: int, relative: float
) -> gtsam.Values:
    """The most probable values, by Levenberg and Marquardt, until the error falls no more."""
    import gtsam

    params = gtsam.LevenbergMarquardtParams()
    params.setMaxIterations(iterations)
    params.setRelativeErrorTol(relative)
    return gtsam.LevenbergMarquardtOptimizer(factors, start, params).optimize()


def as_motor(poses: Sequence[gtsam.Pose3]) -> Motor:
    """Motor ``(N,)`` of N poses."""
    turns: FloatArray = np.array([pose.rotation().matrix() for pose in poses])
    places = np.array([pose.translation() for pose in poses])
    return Motor.from_rotor_translation(Rotor.from_matrix(turns), places)
