"""`fuse_unjudged`: camera poses and an IMU through the compiled filter, without a verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.fused import Fused, by_segment, covered, wanted_stamps
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

    def fuse_part(measured: PoseMeasurements, stream: ImuStream, stamps: IntArray | None) -> Fused:
        return _fused(
            measured, stream, noise, imu_T_camera, stamps, kinds, chosen, lag_s, time_offset_s,
            state_covariances,
        )  # fmt: skip

    return by_segment(fuse_part, measurements, imu, stamps_ns, shift_ns)


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
    """Fuse along one segment of the stream."""
    shift_ns = round(time_offset_s * 1e9)
    used = covered(measurements, imu, shift_ns)
    wanted = wanted_stamps(used.trajectory.time_ns + shift_ns, imu, stamps_ns)
    relates = any(one.since_ns is not None for one in also)
    smoothed = ahead_s > 0.0
    lag_s = ahead_s if np.isfinite(ahead_s) else 0.0
    run = engine(chosen, noise, imu_T_camera, time_offset_s, keeps_earlier=relates, lag_s=lag_s)
    outputs = _Made.empty(len(wanted))
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
        *outputs.arrays,
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
    fused = outputs.fused(
        wanted, measurements.trajectory, whole, nis, accepted, chosen.gravity_m_s2
    )
    return replace(fused, also=others, given_up_ns=given_up_ns)


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
        np.ascontiguousarray(array)
        for array in (path.time_ns, path.motors.coefficients, measurements.covariance)
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
