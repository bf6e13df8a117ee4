"""`fuse`: camera poses and an IMU in, one trajectory with its uncertainty out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.error_state import (
    FilterSettings,
    filter_forwards,
    motor_adjoint,
)
from motorcade.fusion.filter.extended_pose import corrected
from motorcade.fusion.filter.smoother import smooth_backwards
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import FloatArray, IntArray, Motor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements

__all__ = ["Fused", "fuse"]


@dataclass(frozen=True, eq=False)
class Fused:
    """A fused path and what was known along it, at N stamps.

    Fields:
        trajectory: ``world_T_camera``.
        velocity_m_s: ``(N, 3)`` of the IMU, in the world.
        gyro_bias_rad_s, accel_bias_m_s2: ``(N, 3)``.
        covariance: ``(N, 6, 6)`` of the camera pose, right perturbation, rotation (rad) first.
        state_covariance: ``(N, 15, 15)`` of the IMU's state: rotation (rad), position (m) and
            velocity (m/s) of the right perturbation, in the IMU's axes, then both biases.
        nis: ``(N,)`` normalised innovations squared of the forward pass, six degrees of freedom;
            NaN where nothing was measured and at the start.
        accepted: ``(N,)`` false where a measurement was left out.
    """

    trajectory: Trajectory
    velocity_m_s: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    covariance: FloatArray
    state_covariance: FloatArray
    nis: FloatArray
    accepted: NDArray[np.bool_]


def fuse(
    measurements: PoseMeasurements,
    imu: ImuStream,
    noise: ImuNoise,
    imu_T_camera: Motor,
    stamps_ns: IntArray | None = None,
    *,
    settings: FilterSettings | None = None,
    smoothed: bool = True,
) -> Fused:
    """Fuse measured camera poses with an IMU.

    Inertial data are integrated at their full rate; memory grows by about 8 kB a sample (a
    quarter of an hour at 200 Hz: 1.4 GB). Where the world's z is not up the accelerometer
    contradicts the camera, and the tilt ends up in its bias as far as the motion allows.

    Args:
        measurements: ``world_T_camera`` with covariances; the world's z is up.
        imu: must cover the measurements that are to be used: the others are left out. A hole in
            it is bridged linearly, which nothing accounts for.
        noise: the IMU's densities and bias walks. Those of a data sheet are too small for a
            sensor that is carried or flown; `ImuNoise.scaled` until the mean NIS is about 6.
        imu_T_camera: pose of the camera on the IMU.
        stamps_ns: rising stamps at which the path is wanted, measured there or not; by default
            those of the measurements. Stamps before the first measurement or outside the IMU's
            span are left out.
        settings: gravity, gate, initial tilt error.
        smoothed: look ahead as well (backward pass); without it every estimate knows only its
            past, as if it ran live.

    Raises:
        ValueError: the IMU and the measurements do not overlap in time, or `stamps_ns` are no
            rising integers or none of them can be served.
    """
    used = _covered(measurements, imu)
    wanted = _wanted(used, imu, stamps_ns)
    run = filter_forwards(
        used, imu, noise, imu_T_camera, _nodes(used, imu, wanted), settings or FilterSettings()
    )
    chosen = np.searchsorted(run.time_ns, wanted)
    errors, covariance = smooth_backwards(run) if smoothed else (None, run.covariance)
    state = run.extended(slice(None))[chosen]
    bias, covariance = run.bias[chosen], covariance[chosen]
    if errors is not None:
        state, bias = corrected(state, errors[chosen]), bias + errors[chosen, 9:]
    adjoint = motor_adjoint(imu_T_camera.inverse())
    return Fused(
        trajectory=Trajectory(
            wanted,
            state[:, 0] @ imu_T_camera,
            measurements.trajectory.parent,
            measurements.trajectory.child,
        ),
        velocity_m_s=state[:, 1].translation_m,
        gyro_bias_rad_s=bias[:, :3],
        accel_bias_m_s2=bias[:, 3:],
        covariance=adjoint @ covariance[:, :6, :6] @ adjoint.T,
        state_covariance=covariance,
        nis=run.nis[chosen],
        accepted=run.accepted[chosen],
    )


def _covered(measurements: PoseMeasurements, imu: ImuStream) -> PoseMeasurements:
    first, last = int(imu.time_ns[0]), int(imu.time_ns[-1])
    stamps = measurements.trajectory.time_ns
    covered = (stamps >= first) & (stamps <= last)
    if not np.any(covered):
        raise ValueError(
            f"measurements and imu: expected spans that overlap, got {stamps[0]} to {stamps[-1]} "
            f"ns and {first} to {last} ns"
        )
    return PoseMeasurements(measurements.trajectory[covered], measurements.covariance[covered])


def _wanted(measurements: PoseMeasurements, imu: ImuStream, stamps_ns: IntArray | None) -> IntArray:
    start, last = measurements.trajectory.time_ns[0], imu.time_ns[-1]
    if stamps_ns is None:
        return measurements.trajectory.time_ns
    given = np.asarray(stamps_ns)
    if given.dtype.kind != "i" or given.ndim != 1 or np.any(np.diff(given) <= 0):
        raise ValueError("stamps_ns: expected rising integer nanoseconds (M,), got others")
    wanted: IntArray = given[(given >= start) & (given <= last)].astype(np.int64)
    if wanted.size == 0:
        raise ValueError(f"stamps_ns: expected some within [{start}, {last}], got none")
    return wanted


def _nodes(measurements: PoseMeasurements, imu: ImuStream, wanted: IntArray) -> IntArray:
    """All stamps the filter stops at: measured, wanted, and the IMU's own between them."""
    stops = np.union1d(measurements.trajectory.time_ns, wanted)
    own = imu.time_ns[(imu.time_ns > stops[0]) & (imu.time_ns < stops[-1])]
    return np.union1d(stops, own).astype(np.int64)
