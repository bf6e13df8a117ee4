"""`start_inertial`: a camera path of unknown scale and lean made metric and upright by an IMU.

Linear alignment gives a start, then everything is estimated together: C. Campos, J. Montiel,
J. Tardós, Inertial-only optimization for visual-inertial initialization, ICRA 2020; here the poses
are unknowns as well, so that their noise does not enter the scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.imu.gravity import GRAVITY_SIGMA_M_S2, STANDARD_GRAVITY_M_S2, upright
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.sync.alignment import GRAVITY, SCALE, Beliefs, Shared, align
from motorcade.fusion.sync.synchronise import covered
from motorcade.fusion.visual_inertial.linear import linear_start
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
