"""The residuals of camera and IMU with their derivatives, by the code that `model` generated.

That code is imported where it is called, so that it can be written again whatever state it is in.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray

# Enough that NumPy computes more than it is called.
_ROWS_AT_ONCE = 4096


def interval_residuals(
    poses: tuple[FloatArray, FloatArray],
    velocities: tuple[FloatArray, FloatArray],
    bias_steps: FloatArray,
    gravity: FloatArray,
    motion: FloatArray,
    bias_jacobian: FloatArray,
    duration_s: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """What K preintegrated intervals miss between the states at their ends.

    Args:
        poses: coefficients ``(K, 8)`` of ``world_T_imu`` at starts and ends.
        velocities: ``(K, 3)`` in the world at starts and ends.
        bias_steps: ``(K, 6)``, biases at the ends minus those at the starts.
        gravity: ``(3,)`` in the world.
        motion: ``(K, 16)`` coefficients of the preintegrated pair of motors, at the start's biases.
        bias_jacobian: ``(K, 9, 6)`` of it.
        duration_s: ``(K,)``.

    Returns:
        Residuals ``(K, 15)``, rotation, position, velocity, biases, and their derivatives
        ``(K, 15, 33)`` by the start's pose, velocity, biases, the end's, and gravity.
    """
    from motorcade.fusion.sync.generated import residuals as generated

    count = len(duration_s)
    jacobian = bias_jacobian.transpose(0, 2, 1).reshape(count, 54)  # CasADi's order is by columns
    gravities = np.broadcast_to(gravity, (count, 3))
    inputs = (*poses, *velocities, bias_steps, gravities, motion, jacobian, duration_s[:, None])
    return _by_parts(generated.interval_f64, generated.INTERVAL, (15, 33), inputs)


def pose_residuals(
    poses: FloatArray, twists: FloatArray, imu_T_camera: FloatArray, measured: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How far N measured poses of the camera are from those that the IMU's poses imply.

    Args:
        poses: coefficients ``(N, 8)`` of ``world_T_imu``.
        twists: ``(N, 6)`` of the IMU, rad/s and m/s: where a later time would find it.
        imu_T_camera: ``(8,)`` of ``imu_T_camera``.
        measured: ``(N, 8)`` of ``world_T_camera``, scaled to metres.

    Returns:
        Residuals ``(N, 6)`` in the camera's axes, and their derivatives ``(N, 6, 14)`` by the
        pose, the time offset (s), the extrinsics, and the logarithm of the measurements' scale.
    """
    from motorcade.fusion.sync.generated import residuals as generated

    extrinsics = np.broadcast_to(imu_T_camera, (len(poses), 8))
    inputs = (poses, twists, extrinsics, measured)
    return _by_parts(generated.pose_f64, generated.POSE, (6, 14), inputs)


def _by_parts(
    function: Callable[..., tuple[Any, ...]],
    places: tuple[tuple[int, int], ...],
    shape: tuple[int, int],
    inputs: tuple[FloatArray, ...],
) -> tuple[FloatArray, FloatArray]:
    """Residuals ``(n, r)`` and derivatives ``(n, r, u)`` of n rows of each input.

    The function gives r residuals, and the derivatives at `places` of `shape`; others are zero.
    """
    count = len(inputs[0])
    residual, derivative = np.empty((count, shape[0])), np.zeros((count, *shape))
    for first in range(0, count, _ROWS_AT_ONCE):
        part = slice(first, first + _ROWS_AT_ONCE)
        columns = function(*(np.asfortranarray(rows[part]) for rows in inputs))
        for i, value in enumerate(columns[: shape[0]]):
            residual[part, i] = value
        for (i, unknown), value in zip(places, columns[shape[0] :], strict=True):
            derivative[part, i, unknown] = value
    return residual, derivative
