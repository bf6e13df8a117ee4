"""What the filter is given: noise as it is assumed of an IMU, and poses in a level world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.health import Health, check_health
from motorcade.fusion.imu import ImuNoise, ImuStream
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.inertial import ImuOrigin, UsedImu
from motorcade.tracking import PoseMeasurements
from motorcade.tracking.audit import AuditFinding

NOISE_FACTORS: dict[ImuOrigin, tuple[float, float]] = {
    "recorded": (10.0, 1.0),
    "reference": (1.0, 1.0),
}
"""On white densities and on bias walks, by where the IMU came from. Data sheets describe a sensor
at rest on a bench: one that is carried or flown feels what shakes it, and its scales and axes are
a little off, which looks like white noise. Tenfold is what Kalibr's authors advise, and brings the
filter's NIS to six on EuRoC's flights; biases walk as the sheet says. A simulated stream has the
noise that it was drawn with."""


def assumed_noise(
    noise: ImuNoise, origin: ImuOrigin, white: float | None = None, walk: float | None = None
) -> ImuNoise:
    """The sensor's noise times the factors of its origin, or times those given."""
    usual_white, usual_walk = NOISE_FACTORS[origin]
    white = usual_white if white is None else white
    walk = usual_walk if walk is None else walk
    return ImuNoise(
        white * noise.gyro_density_rad_s_rthz,
        walk * noise.gyro_walk_rad_s2_rthz,
        white * noise.accel_density_m_s2_rthz,
        walk * noise.accel_walk_m_s3_rthz,
    )


def inertial_health(recording: Recording, camera_poses: CameraPoses, imu: UsedImu) -> Health:
    """Faults that the readings show beside the measured poses, whose world may lean."""
    path, stream = camera_poses.measurements.trajectory, imu.stream(recording)
    return check_health(path, stream, imu.imu_T_camera, up=camera_poses.origin == "simulated")


_RATES_HZ = (5.0, 10.0, 12.5, 15.0, 20.0, 24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0)
_STEP_RAD, _CLIPPED, _SEPARABLE = 0.01, 9.0, 9.2
"""By how much angles between poses and those of a gyroscope may differ; bound on its square, in
deviations; log likelihood ratio of 10,000 to 1."""


def other_rate(camera_poses: CameraPoses, stream: ImuStream) -> list[AuditFinding]:
    """Another rate of frames than stated, at which the images turn as the gyroscope does.

    By how much a camera turns does not depend on where it sits. Nothing where frames have stamps of
    their own, where the stated rate explains the angles, or where no other one does.
    """
    frames_ns, path = camera_poses.frame_times_ns, camera_poses.measurements.trajectory
    intervals_ns = np.diff(frames_ns)
    if len(path) < 2 or np.ptp(intervals_ns) > 1:
        return []
    stated_hz = float(1e9 / np.mean(intervals_ns))
    turned_rad = (path.motors[:-1].inverse() @ path.motors[1:]).rotor.angle()
    time_s, read_s = 1e-9 * (path.time_ns - frames_ns[0]), 1e-9 * (stream.time_ns - frames_ns[0])
    rate_rad_s = stream.angular_rate_rad_s
    means_rad = 0.5 * (rate_rad_s[1:] + rate_rad_s[:-1]) * np.diff(read_s)[:, None]
    read_rad = np.concatenate([np.zeros((1, 3)), np.cumsum(means_rad, axis=0)])

    def missed(rate_hz: float) -> float:
        at_s = time_s * stated_hz / rate_hz
        covered = at_s[1:] <= read_s[-1]
        if 2 * np.count_nonzero(covered) < len(covered):
            return np.inf
        read = np.diff([np.interp(at_s, read_s, axis) for axis in read_rad.T], axis=1)
        squares = ((np.linalg.norm(read, axis=0) - turned_rad) / _STEP_RAD)[covered] ** 2
        return float(np.mean(np.minimum(squares, _CLIPPED)))

    misses = [missed(rate_hz) for rate_hz in _RATES_HZ]
    best = int(np.argmin(misses))
    clearly = 0.5 * len(turned_rad) * (missed(stated_hz) - misses[best]) > _SEPARABLE
    if not clearly or misses[best] >= 1.0:
        return []
    other_hz = _RATES_HZ[best]
    summary = (
        f"the images turn as the gyroscope does where {other_hz:g} of them are a second, and not "
        f"at {stated_hz:.4g}"
    )
    advice, ratio = f"say rate_hz = {other_hz:g}", other_hz / stated_hz
    return [AuditFinding("frame_rate", "contradicted", ratio, "times", summary, advice)]


_UPRIGHT_DEG = 3.0
_MOST_SAMPLES = 20_000


@dataclass(frozen=True, eq=False)
class Levelled:
    """Measurements in the level world, where that stands, and how far z was from up.

    `leaned` is false where the world was upright as it came; `level_T_world` is then the identity.
    """

    measurements: PoseMeasurements
    level_T_world: Motor
    lean_deg: float
    leaned: bool


def levelled(camera_poses: CameraPoses, imu: UsedImu, stream: ImuStream) -> Levelled:
    """Turn a world upright whose z is more than 3° from up by a recorded IMU.

    Poses simulated from a ground truth keep its world, and an IMU simulated along it has z for up
    anyway. The mean is off by the change of velocity over the time, in units of gravity.
    """
    measured = camera_poses.measurements
    upright = Levelled(measured, Motor.identity(), 0.0, leaned=False)
    up = _mean_up(camera_poses, imu, stream)
    if imu.origin != "recorded" or camera_poses.origin == "simulated" or up is None:
        return upright
    lean_rad = float(np.arctan2(np.hypot(up[0], up[1]), up[2]))
    if np.rad2deg(lean_rad) <= _UPRIGHT_DEG:
        return upright
    across = float(np.hypot(up[0], up[1]))
    axis = np.array([up[1], -up[0], 0.0]) / across if across > 0.0 else np.array([1.0, 0.0, 0.0])
    turn = Motor.from_rotor_translation(Rotor.from_rotation_vector(lean_rad * axis), np.zeros(3))
    turned = PoseMeasurements(measured.trajectory.transformed_by(left=turn), measured.covariance)
    return Levelled(turned, turn, float(np.rad2deg(lean_rad)), leaned=True)


def _mean_up(camera_poses: CameraPoses, imu: UsedImu, stream: ImuStream) -> FloatArray | None:
    """The mean specific force ``(3,)`` in the world; None where the IMU covers no pose."""
    path = camera_poses.measurements.trajectory
    rows = np.flatnonzero(
        (stream.time_ns >= path.time_ns[0]) & (stream.time_ns <= path.time_ns[-1])
    )
    rows = rows[:: max(1, len(rows) // _MOST_SAMPLES)]
    if not len(rows):
        return None
    world_T_imu = path.motors_at(stream.time_ns[rows]) @ imu.imu_T_camera.inverse()
    mean: FloatArray = world_T_imu.rotor.apply(stream.specific_force_m_s2[rows]).mean(axis=0)
    return mean
