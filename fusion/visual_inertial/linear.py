"""Scale, gravity and velocities from camera poses of unknown scale, by linear least squares.

With the rotations known, position and velocity at the end of an interval are linear in velocities,
gravity and scale. Biases of the gyroscope are taken from the rotations first. Source: T. Qin,
P. Li, S. Shen, VINS-Mono, IEEE TRO 34(4), 2018, V-B; gravity's size is left to what comes after.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.preintegration import Preintegrated, preintegrate
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

_BIAS_ROUNDS = 3


def linear_start(
    camera: Trajectory,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    scale: float | None = None,
) -> tuple[float, FloatArray]:
    """Metres a unit of the camera's world, unless they are known, and gravity ``(3,)`` in it.

    Raises:
        ValueError: fewer than four poses, or motion that gives no scale above zero.
    """
    if len(camera) < 4:
        raise ValueError(f"camera: expected four poses or more, got {len(camera)}")
    camera_T_imu = imu_T_camera.inverse()
    rotor = camera.motors.rotor @ camera_T_imu.rotor
    bias = np.zeros(3)
    for _ in range(_BIAS_ROUNDS):
        summed = preintegrate(imu, camera.time_ns, noise, bias)
        turned = rotor[:-1].inverse() @ rotor[1:]
        left = (summed.motion[:, 0].rotor.inverse() @ turned).as_rotation_vector()
        by_bias = summed.bias_jacobian[:, :3, :3]
        bias = bias + np.linalg.lstsq(by_bias.reshape(-1, 3), left.ravel(), rcond=None)[0]
    matrix, right = _system(camera, rotor.as_matrix(), camera_T_imu, summed)
    if scale is not None:
        matrix, right = matrix[:, :-1], right - scale * matrix[:, -1]
    solution: FloatArray = np.linalg.lstsq(matrix, right, rcond=None)[0].astype(np.float64)
    if scale is not None:
        return scale, solution[-3:]
    scale, gravity = float(solution[-1]), solution[-4:-1]
    if not scale > 0.0:
        raise ValueError(
            f"camera and imu: expected motion that tells the scale, got {scale:.3g} m a unit: too "
            "little acceleration, or not one motion"
        )
    return scale, gravity


def _system(
    camera: Trajectory, turn: FloatArray, camera_T_imu: Motor, summed: Preintegrated
) -> tuple[FloatArray, FloatArray]:
    """Rows ``(6 K, 3 (K + 1) + 4)``: positions, then velocities, of all intervals."""
    count = len(summed)
    lever = camera.motors.rotor.apply(camera_T_imu.translation_m)
    dt = summed.duration_s[:, None, None]
    shifted, gained = np.moveaxis(summed.motion.translation_m, 1, 0)
    back, identity = turn[:-1].swapaxes(-1, -2), np.eye(3)
    matrix = np.zeros((2, count, 3, 3 * (count + 1) + 4))
    for k in range(count):
        at = slice(3 * k, 3 * k + 3)
        after = slice(3 * k + 3, 3 * k + 6)
        matrix[0, k][:, at] = -back[k] * dt[k]
        matrix[1, k][:, at], matrix[1, k][:, after] = -back[k], back[k]
    matrix[0, :, :, -4:-1] = -0.5 * back @ identity * dt**2
    matrix[1, :, :, -4:-1] = -back * dt
    steps = np.diff(camera.motors.translation_m, axis=0)
    matrix[0, :, :, -1] = np.einsum("kij,kj->ki", back, steps)
    shift = np.einsum("kij,kj->ki", back, np.diff(lever, axis=0))
    right = np.stack([shifted - shift, gained])
    # Positions over an interval are as sure as velocities times its length.
    weight = np.stack([1.0 / dt[:, :, 0], np.ones_like(dt[:, :, 0])])
    return (matrix * weight[..., None]).reshape(6 * count, -1), (right * weight).ravel()
