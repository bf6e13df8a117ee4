"""`Fused`, a fused path with what is known along it and found beside it; what is fused at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.findings import LatencyCurve
from motorcade.fusion.filter.sourced import Judgement
from motorcade.fusion.health.check import check_stamps
from motorcade.fusion.health.verdict import Health
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.metrics.poses.pose_error import absolute_translation_m, rotation_rad
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.measurements import PoseMeasurements


def covered(measurements: PoseMeasurements, imu: ImuStream, shift_ns: int = 0) -> PoseMeasurements:
    """The measurements within the IMU's span, their stamps `shift_ns` later on its clock.

    Raises:
        ValueError: spans that do not overlap.
    """
    first, last = int(imu.time_ns[0]), int(imu.time_ns[-1])
    stamps = measurements.trajectory.time_ns + shift_ns
    inside = (stamps >= first) & (stamps <= last)
    if not np.any(inside):
        unit = check_stamps(stamps, imu.time_ns)
        raise ValueError(
            f"measurements and imu: expected spans that overlap, got {stamps[0]} to {stamps[-1]} "
            f"ns and {first} to {last} ns" + ("" if unit is None else f": {unit.summary}")
        )
    if np.all(inside):
        return measurements
    return PoseMeasurements(measurements.trajectory[inside], measurements.covariance[inside])


def wanted_stamps(
    measured_ns: IntArray, imu: ImuStream, stamps_ns: IntArray | None = None
) -> IntArray:
    """The stamps asked for that lie between the first measurement and the IMU's end.

    Args:
        measured_ns: on the IMU's clock; all of them where no others are asked for.
        imu: whose span bounds the path.
        stamps_ns: rising integers.

    Raises:
        ValueError: stamps that are no rising integers, or none that can be served.
    """
    if stamps_ns is None:
        return measured_ns
    start, last = measured_ns[0], imu.time_ns[-1]
    stamps = np.asarray(stamps_ns)
    if stamps.dtype.kind != "i" or stamps.ndim != 1 or np.any(np.diff(stamps) <= 0):
        raise ValueError("stamps_ns: expected rising integer nanoseconds (M,), got others")
    wanted: IntArray = stamps[(stamps >= start) & (stamps <= last)].astype(np.int64)
    if wanted.size == 0:
        raise ValueError(f"stamps_ns: expected some within [{start}, {last}], got none")
    return wanted


def by_segment(
    fused: Callable[[PoseMeasurements, ImuStream, IntArray | None], Fused],
    measurements: PoseMeasurements,
    imu: ImuStream,
    stamps_ns: IntArray | None,
    shift_ns: int = 0,
) -> Fused:
    """Fuse each segment of a stream that gaps split for itself, and join the results.

    Raises:
        ValueError: what `fused` refuses, or no measurement in any segment.
    """
    parts = imu.segments()
    if len(parts) == 1:
        return fused(measurements, parts[0], stamps_ns)
    measured_ns = measurements.trajectory.time_ns + shift_ns
    wanted = measured_ns if stamps_ns is None else wanted_stamps(measured_ns, imu, stamps_ns)
    paths = []
    for part in parts:
        first, last = part.time_ns[[0, -1]]
        inside = np.flatnonzero((measured_ns >= first) & (measured_ns <= last))
        if not inside.size:
            continue
        here = wanted[(wanted >= measured_ns[inside[0]]) & (wanted <= last)]
        if here.size:
            own = PoseMeasurements(measurements.trajectory[inside], measurements.covariance[inside])
            paths.append(fused(own, part, here))
    if not paths:
        raise ValueError(
            f"measurements and imu: expected stamps in one of the {len(parts)} segments between "
            "gaps of the imu, got none"
        )
    return paths[0] if len(paths) == 1 else Fused.joined(paths)


_EXTRINSICS = slice(17, 23)


@dataclass(frozen=True, eq=False)
class Fused:
    """A fused path and what was known along it, at N stamps.

    Fields:
        trajectory: ``world_T_camera``.
        velocity_m_s: ``(N, 3)`` of the IMU, in the world.
        gyro_bias_rad_s, accel_bias_m_s2: ``(N, 3)``.
        covariance: ``(N, 6, 6)`` of the camera pose, right perturbation, rotation (rad) first.
        state_covariance: ``(N, 15, 15)`` of the IMU's state: rotation (rad), position (m) and
            velocity (m/s) of the right perturbation, in the IMU's axes, then both biases. Where
            more is estimated ``(N, 24, 24)``: tilt of gravity (2, rad), right perturbation of
            `imu_T_camera` (6), time offset (s); variances of what is not estimated are zero. Those
            of extrinsics and offset hold for a sensor that errs by noise and biases alone
            (`doubts`): axes of the accelerometer that differ from the gyroscope's by tenths of a
            degree, and positions whose clock differs from the orientations', move them by up to 16
            deviations on EuRoC's flights. It has no rows where it was not asked for.
        nis: ``(N,)`` normalised innovations squared of the forward pass, six degrees of freedom;
            NaN where nothing was measured and at the start.
        accepted: ``(N,)`` false where a measurement was left out.
        gravity_m_s2: ``(N, 3)`` in the world.
        imu_T_camera: Motor ``(N,)``.
        time_offset_s: ``(N,)``; a camera's stamp plus this is the IMU's time.
        also: what became of the other kinds of measurements, in their order.
        given_up_ns: ``(K, 2)`` first and last stamps of spans in which a filter that runs live is
            wrong, as it knows afterwards: until it finds that the start was, that the map was
            relocated, or that what it took for a relocated map was not.
        health: the verdict: whether IMU and poses belong together as stated, what is wrong where
            not, and what the covariances do not cover. Where it `failed`, more poses were refused
            than accepted, and nothing here is to be believed. It is written to the log besides.
        noise: the IMU's as `fuse` used it: as stated, or fitted; None of what does not choose.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> from motorcade.fusion import fuse
        >>> from motorcade.ga import Motor
        >>> fused = fuse(measured, sensor.stream, ADIS16448, imu_T_camera=Motor.identity())
        >>> sigma_m = np.sqrt(np.einsum("nii->ni", fused.covariance)[:, 3:])
        >>> bool(np.all(sigma_m < 0.01)), fused.state_covariance.shape
        (True, (61, 15, 15))
    """

    trajectory: Trajectory
    velocity_m_s: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    covariance: FloatArray
    state_covariance: FloatArray
    nis: FloatArray
    accepted: NDArray[np.bool_]
    gravity_m_s2: FloatArray
    imu_T_camera: Motor
    time_offset_s: FloatArray
    also: tuple[Judgement, ...] = ()
    given_up_ns: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    health: Health = field(default_factory=Health)
    noise: ImuNoise | None = None

    @property
    def doubts(self) -> tuple[str, ...]:
        """What `health` has found, a line each, worst first; none on most paths."""
        return tuple(one.summary for one in self.health.findings)

    @classmethod
    def joined(cls, parts: Sequence[Fused]) -> Fused:
        """One path of several, one after another."""
        first = parts[0].trajectory
        whole = {
            each.name: np.concatenate([getattr(one, each.name) for one in parts])
            for each in fields(cls)
            if each.name not in ("trajectory", "imu_T_camera", "also", "health", "noise")
        }
        poses = Motor.concatenate([one.trajectory.motors for one in parts])
        stamps = np.concatenate([one.trajectory.time_ns for one in parts])
        return cls(
            trajectory=Trajectory(stamps, poses, first.parent, first.child),
            imu_T_camera=Motor.concatenate([one.imu_T_camera for one in parts]),
            also=tuple(map(Judgement.joined, zip(*(one.also for one in parts), strict=True))),
            health=Health(),
            noise=parts[0].noise,
            **whole,
        )


def camera_covariance(covariance: FloatArray, imu_T_camera: Motor) -> FloatArray:
    """Covariance ``(*, 6, 6)`` of the camera's pose from that of the state ``(*, N, N)``."""
    adjoint = imu_T_camera.inverse().adjoint()
    effect = np.zeros((*adjoint.shape[:-1], covariance.shape[-1]))
    effect[..., :6] = adjoint
    if covariance.shape[-1] > _EXTRINSICS.stop:
        effect[..., _EXTRINSICS] = np.eye(6)
    seen: FloatArray = effect @ covariance @ np.swapaxes(effect, -1, -2)
    return seen


LAGS_S = (0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0)
"""From no lag to where the curve is flat: a few seconds after it nothing tells of a pose any more,
as velocity and tilt are forgotten by then."""


def latency_curve(
    fused_with: Callable[[float], Fused],
    reference: Trajectory | None = None,
    lags_s: Sequence[float] = LAGS_S,
) -> LatencyCurve:
    """Fuse with one lag after another.

    Args:
        fused_with: fuses with a lag in seconds, always at the same stamps.
        reference: what errors are measured against, in the same world, at all stamps; None: the
            path of the whole recording, so that they are what looking ahead still changes.
        lags_s: lags that are tried, besides the whole recording.

    Examples:
        >>> import numpy as np
        >>> from functools import partial
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, fuse
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.filter import latency_curve
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> from motorcade.ga import Motor
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 2.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)
        >>> by = partial(fuse, measured, sensor.stream, ADIS16448, Motor.identity())
        >>> curve = latency_curve(lambda lag_s: by(lag_s=lag_s), sensor.path, (0.0, 0.5))
        >>> bool(np.all(np.diff(curve.position_m) < 0.0))
        True
    """
    lags = np.array([*lags_s, np.inf])
    whole = fused_with(np.inf).trajectory
    true = whole.motors if reference is None else reference.motors_at(whole.time_ns)
    errors = []
    for lag_s in lags:
        estimated = (whole if lag_s == np.inf else fused_with(float(lag_s)).trajectory).motors
        metres = absolute_translation_m(estimated, true)
        degrees = np.rad2deg(rotation_rad(estimated, true))
        errors.append([np.sqrt(np.mean(metres**2)), np.sqrt(np.mean(degrees**2))])
    position_m, rotation_deg = np.array(errors).T
    return LatencyCurve(lags, position_m, rotation_deg)
