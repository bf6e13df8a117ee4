"""`fuse`: camera poses and an IMU in, one trajectory with its uncertainty out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.fused import Fused, by_stretch, covered, wanted_stamps
from motorcade.fusion.filter.health import fused_health
from motorcade.fusion.filter.native._filter import Engine
from motorcade.fusion.filter.pose_filter import KINDS
from motorcade.fusion.filter.settings import FilterSettings, engine
from motorcade.fusion.filter.sourced import checked_also, judgements, schedule
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.measurements.interface import Measurements
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import checked_span_ns
from motorcade.tracking.measurements import PoseMeasurements


def fuse(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None = None,
    *,
    also: Sequence[Measurements] = (),
    settings: FilterSettings | None = None,
    smoothed: bool = True,
    lag_s: float = np.inf,
    time_offset_s: float = 0.0,
    state_covariances: bool = True,
) -> Fused:
    """Fuse measured camera poses with an IMU, by the code of `PoseFilter`.

    Inertial data are integrated at their full rate. Memory: about 0.3 kB a measurement, 0.9 kB a
    stamp asked for, and 1.8 or 4.6 kB more for its `state_covariance`; what the backward pass needs
    besides is made again, piece by piece. Where the world's z is not up the accelerometer
    contradicts the camera, and the tilt ends up in its bias as far as the motion allows, unless
    `FilterSettings.gravity_sigma_rad` is set.

    Args:
        measurements: ``world_T_camera`` with covariances; the world's z is up.
        imu: must cover the measurements that are to be used: the others are left out. A gap in
            it is bridged by the line between the samples on both sides, with the uncertainty that
            `FilterSettings` states; a gap of more than ten seconds splits the stream, and each
            stretch is fused for itself: stamps between them are left out.
        noise: the IMU's densities and bias walks. Those of a data sheet are too small for a
            sensor in the hand or in flight; `learn_noise` finds what the recording tells of them.
        imu_T_camera: pose of the camera on the IMU.
        stamps_ns: rising stamps of the IMU's clock at which the path is wanted, measured there or
            not; by default those of the measurements. Stamps before the first measurement or
            outside the IMU's span are left out.
        also: other kinds of measurements (`motorcade.fusion.measurements`), from the first pose on.
            Python predicts each, in about 50 µs, twice where `smoothed`.
        settings: gravity, gate, initial tilt error, what else to estimate.
        smoothed: look ahead as well (backward pass); without it every estimate knows only its
            past, as if it ran live, and `nis` and `accepted` are as judged live.
        lag_s: how far to look ahead at most. With 0 as without `smoothed`; with a recording's
            length or more to its end. Between these every estimate is that of a filter that runs
            live and answers so much later: measurements are weighed by what all others up to then
            say of them, and what was answered is not taken back. A burst of wrong poses, or a map
            that was relocated, is seen through only where it ends, with some poses after it,
            within the lag.
        time_offset_s: what is added to the measurements' stamps to be the IMU's time; a first
            guess where `FilterSettings.time_offset_sigma_s` is above zero.
        state_covariances: without them the result's `state_covariance` has no rows.

    Raises:
        ValueError: the IMU and the measurements do not overlap in time, or `stamps_ns` are no
            rising integers or none of them can be served; samples more than ten seconds apart; an
            offset of more than thirty years; a lag below zero, or without `smoothed`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import evaluate, fuse
        >>> from motorcade.ga import Motor
        >>> fused = fuse(measured, sensor.stream, ADIS16448, imu_T_camera=Motor.identity())
        >>> for found in (measured.trajectory, fused.trajectory):
        ...     print(f"{evaluate(found, sensor.path).rotation_deg.rmse:.1f}°")
        1.0°
        0.2°
    """
    chosen = settings or FilterSettings()
    found = fuse_unjudged(
        measurements,
        imu,
        noise,
        imu_T_camera,
        stamps_ns,
        also=also,
        settings=chosen,
        lag_s=checked_lag(lag_s, smoothed),
        time_offset_s=time_offset_s,
        state_covariances=state_covariances,
    )
    given = measurements.trajectory, imu, imu_T_camera, time_offset_s, chosen
    return replace(found, health=fused_health(*given, found))


def fuse_unjudged(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None = None,
    *,
    also: Sequence[Measurements] = (),
    settings: FilterSettings | None = None,
    lag_s: float = np.inf,
    time_offset_s: float = 0.0,
    state_covariances: bool = True,
) -> Fused:
    """What `fuse` does, for what fuses one recording many times: `health` is not looked into."""
    chosen, kinds = settings or FilterSettings(), checked_also(also)
    shift_ns = checked_span_ns(time_offset_s, "time_offset_s")

    def one(given: PoseMeasurements, stream: ImuStream, stamps: IntArray | None) -> Fused:
        return _fused(
            given, stream, noise, imu_T_camera, stamps, kinds, chosen, lag_s, time_offset_s,
            state_covariances,
        )  # fmt: skip

    return by_stretch(one, measurements, imu, stamps_ns, shift_ns)


def checked_lag(lag_s: float, smoothed: bool) -> float:
    """How far to look ahead, in seconds.

    Raises:
        ValueError: a lag that is not a number from zero on, or one without looking ahead.
    """
    if not lag_s >= 0.0:
        raise ValueError(f"lag_s: expected seconds from 0 on, got {lag_s}")
    if not smoothed and 0.0 < lag_s < np.inf:
        raise ValueError(f"lag_s: expected none where nothing looks ahead, got {lag_s}")
    return lag_s if smoothed else 0.0


def _fused(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None,
    also: Sequence[Measurements],
    chosen: FilterSettings,
    ahead_s: float,
    time_offset_s: float,
    state_covariances: bool,
) -> Fused:
    """Fuse along one stretch of the stream."""
    shift_ns = round(time_offset_s * 1e9)
    used = covered(measurements, imu, shift_ns)
    wanted = wanted_stamps(used.trajectory.time_ns + shift_ns, imu, stamps_ns)
    relates = any(one.since_ns is not None for one in also)
    smoothed = ahead_s > 0.0
    lag_s = ahead_s if np.isfinite(ahead_s) else 0.0
    run = engine(chosen, noise, imu_T_camera, time_offset_s, keeps_earlier=relates, lag_s=lag_s)
    made = _Made.empty(len(wanted))
    size = chosen.error_size
    whole = np.zeros((len(wanted) if state_covariances else 0, size, size))
    columns = [
        np.ascontiguousarray(values)
        for values in (imu.time_ns, imu.angular_rate_rad_s, imu.specific_force_m_s2)
    ]
    run.hold(*columns)
    _schedule(run, used)
    first_ns, last_ns = int(used.trajectory.time_ns[0]) + shift_ns, int(imu.time_ns[-1])
    schedule(run, also, first_ns, last_ns)
    run.outputs(
        np.ascontiguousarray(wanted),
        *made.arrays,
        whole=whole if state_covariances else None,
        final=smoothed and lag_s == 0.0,
    )
    run.play()
    if smoothed:
        run.smooth()
    nis, accepted = _judged(run, used.trajectory.time_ns + shift_ns, wanted, live=not smoothed)
    others = judgements(also, *run.judged(), live=not smoothed)
    given_up_ns = run.doubted()[0]
    del run  # which holds more than the result does
    found = made.fused(wanted, measurements.trajectory, whole, nis, accepted, chosen.gravity_m_s2)
    return replace(found, also=others, given_up_ns=given_up_ns)


@dataclass(frozen=True, eq=False)
class _Made:
    """What the compiled filter fills, one row a stamp.

    `others` are the rotor of gravity, the extrinsics and the time offset.
    """

    pose: FloatArray
    velocity: FloatArray
    bias: FloatArray
    covariance: FloatArray
    others: FloatArray

    @classmethod
    def empty(cls, count: int) -> _Made:
        shapes = ((count, 8), (count, 3), (count, 6), (count, 6, 6), (count, 13))
        return cls(*(np.zeros(shape) for shape in shapes))

    @property
    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        return self.pose, self.velocity, self.bias, self.covariance, self.others

    def fused(
        self,
        wanted: IntArray,
        measured: Trajectory,
        whole: FloatArray,
        nis: FloatArray,
        accepted: NDArray[np.bool_],
        gravity_m_s2: float,
    ) -> Fused:
        """The result, seen from the camera."""
        imu_T_camera = Motor.normalize(self.others[:, 4:12])
        poses = Motor.normalize(self.pose) @ imu_T_camera
        return Fused(
            trajectory=Trajectory(wanted, poses, measured.parent, measured.child),
            velocity_m_s=self.velocity,
            gyro_bias_rad_s=self.bias[:, :3],
            accel_bias_m_s2=self.bias[:, 3:],
            covariance=self.covariance,
            state_covariance=whole,
            nis=nis,
            accepted=accepted,
            gravity_m_s2=Rotor(self.others[:, :4]).apply(np.array([0.0, 0.0, -gravity_m_s2])),
            imu_T_camera=imu_T_camera,
            time_offset_s=self.others[:, 12],
        )


def _schedule(run: Engine, measurements: PoseMeasurements) -> None:
    path = measurements.trajectory
    stamps, poses, covariances = (
        np.ascontiguousarray(one)
        for one in (path.time_ns, path.motors.coefficients, measurements.covariance)
    )
    noise = covariances.reshape(-1, 36)
    run.schedule(KINDS["camera_pose"], stamps, poses, noise, None, None, -1)


def _judged(
    run: Engine, measured_ns: IntArray, wanted: IntArray, *, live: bool
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """By wanted stamp, the innovation of the measurement there and whether it was believed."""
    about, values = run.judged()
    nis, accepted = np.full(len(wanted), np.nan), np.ones(len(wanted), dtype=np.bool_)
    real = (about[:, 2] == KINDS["camera_pose"]) & (about[:, 1] >= 0)
    stamps, values = measured_ns[about[real, 1]], values[real, 2:] if live else values[real, :2]
    row = np.minimum(np.searchsorted(wanted, stamps), len(wanted) - 1)
    here = wanted[row] == stamps
    nis[row[here]], accepted[row[here]] = values[here, 0], values[here, 1] > 0.0
    return nis, accepted
