"""`start_inertial`: a camera path of unknown scale and lean made metric and upright by an IMU.

Linear alignment gives a start, then everything is estimated together: C. Campos, J. Montiel,
J. Tardós, Inertial-only optimization for visual-inertial initialization, ICRA 2020; here the poses
are unknowns as well, so that their noise does not enter the scale.

The linear start: with the rotations known, position and velocity at the end of an interval are
linear in velocities, gravity and scale. Biases of the gyroscope are taken from the rotations first.
Source: T. Qin, P. Li, S. Shen, VINS-Mono, IEEE TRO 34(4), 2018, V-B; gravity's size is left to what
comes after.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import (
    GRAVITY_SIGMA_M_S2,
    STANDARD_GRAVITY_M_S2,
    ImuStream,
    upright,
)
from motorcade.fusion.preintegration import Preintegrated, preintegrate
from motorcade.fusion.sync.alignment import GRAVITY, SCALE, Beliefs, Shared, align
from motorcade.fusion.sync.synchronise import covered
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.measurements import PoseMeasurements

# The linear start looks at poses so far apart: over less time noise outweighs acceleration.
_SPACING_S = 0.25
_MOST_LINEAR = 120


@dataclass(frozen=True, eq=False)
class InertialStart:
    """A metric, upright world for a camera path, and the IMU's state along it.

    Fields:
        world_T_visual: Similarity from the camera's world to one in metres with z up; its origin
            stays, and its turn is the shortest.
        log_scale_sigma: deviation of the logarithm of the scale: 0.01 is one per cent.
        tilt_sigma_rad: deviation of up, about each of two axes.
        time_ns: ``(N,)`` stamps of the poses that were used.
        world_T_camera: Motor ``(N,)`` there, in the new world.
        velocity_m_s: ``(N, 3)`` of the IMU, in the new world.
        gyro_bias_rad_s: ``(N, 3)``; accel_bias_m_s2: ``(N, 3)``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import start_inertial
        >>> from motorcade.ga import Motor
        >>> started = start_inertial(measured, sensor.stream, ADIS16448, Motor.identity())

        >>> started.in_metres(measured.trajectory)
        Trajectory(world_T_imu, 61 poses, 3.000 s)
    """

    world_T_visual: Similarity
    log_scale_sigma: float
    tilt_sigma_rad: float
    time_ns: IntArray
    world_T_camera: Motor
    velocity_m_s: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray

    def in_metres(self, camera: Trajectory) -> Trajectory:
        """Any poses of the camera's world as rigid poses of the new one."""
        turned = self.world_T_visual.rotor @ camera.motors.rotor
        places = self.world_T_visual.apply(camera.motors.translation_m)
        poses = Motor.from_rotor_translation(turned, places)
        return Trajectory(camera.time_ns, poses, camera.parent, camera.child)


def start_inertial(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    *,
    metric: bool = False,
) -> InertialStart:
    """Find scale, up, velocities and biases from poses of a camera and the IMU it sits on.

    The scale comes from accelerations alone: an even pace tells nothing of it, and
    `log_scale_sigma` says so. It believes the stated covariances, and that errors of the poses are
    independent; wrong poses lose their weight. A map's scale that drifts is not foreseen.

    Args:
        measurements: ``world_T_camera`` in units and axes of its own, with covariances.
        imu: the stream, on the same clock.
        noise: its densities and walks.
        imu_T_camera: pose of the camera on the IMU, metres.
        metric: whether the poses are in metres already, as by a stereo pair: the scale is 1 then.

    Raises:
        ValueError: fewer than four poses within the IMU's span, motion that gives no scale, or an
            estimate that does not settle.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import start_inertial
        >>> from motorcade.ga import Motor
        >>> started = start_inertial(measured, sensor.stream, ADIS16448, Motor.identity())

        >>> bool(abs(np.log(started.world_T_visual.scale)) < 2.0 * started.log_scale_sigma)
        True
    """
    used, imu = covered(measurements.trajectory, imu, 0.0, 0.0)
    known = 1.0 if metric else None
    scale, gravity = linear_start(_spaced(used), imu, noise, imu_T_camera, known)
    fall = STANDARD_GRAVITY_M_S2 / float(np.linalg.norm(gravity)) * gravity
    beliefs = Beliefs(0.0, 0.0, 0.0, GRAVITY_SIGMA_M_S2, 0.0 if metric else np.inf)
    start = Shared(0.0, imu_T_camera, fall, scale)
    variances = np.median(np.einsum("kii->ki", measurements.covariance), axis=0)
    turn, shift = np.sqrt(variances.reshape(2, 3).mean(axis=-1))
    sigma = float(turn), scale * float(shift)
    aligned = align(used, imu, noise, start, beliefs, sigma, adapt=False)
    up = upright(aligned.shared.gravity_m_s2)
    size = float(np.linalg.norm(aligned.shared.gravity_m_s2))
    lean = up.as_matrix()[:2] @ aligned.covariance[GRAVITY, GRAVITY] @ up.as_matrix()[:2].T
    turned = Motor.from_rotor_translation(up, np.zeros(3))
    return InertialStart(
        Similarity.from_motor_scale(turned, aligned.shared.scale),
        float(np.sqrt(aligned.covariance[SCALE, SCALE][0, 0])),
        float(np.sqrt(np.trace(lean) / 2.0)) / size,
        aligned.time_ns,
        turned @ aligned.world_T_imu @ imu_T_camera,
        up.apply(aligned.velocity_m_s),
        aligned.bias[:, :3],
        aligned.bias[:, 3:],
    )


def _spaced(camera: Trajectory) -> Trajectory:
    """Poses at least a spacing apart, and not too many, from the whole path."""
    spacing = max(_SPACING_S, camera.duration_s / _MOST_LINEAR)
    chosen, last = [0], float(camera.time_s[0])
    for k, now in enumerate(camera.time_s.tolist()):
        if now - last >= spacing - 1e-6:
            chosen.append(k)
            last = now
    return camera[chosen]


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
        at, after = slice(3 * k, 3 * k + 3), slice(3 * k + 3, 3 * k + 6)
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
