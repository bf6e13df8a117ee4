"""`fuse`: camera poses and an IMU in, one trajectory with its uncertainty out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.filter.error_state import (
    Estimate,
    FilterSettings,
    filter_forwards,
)
from motorcade.fusion.filter.extended_pose import skew
from motorcade.fusion.filter.smoother import smooth_backwards
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga import FloatArray, IntArray, Motor, Rotor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements

__all__ = ["Fused", "fuse"]


@dataclass(frozen=True, eq=False)
class Fused:
    """A fused path and what the filter knew along it, at N stamps.

    Fields:
        trajectory: ``world_T_camera``.
        velocity_m_s: ``(N, 3)`` of the IMU, in the world.
        gyro_bias_rad_s, accel_bias_m_s2: ``(N, 3)``.
        covariance: ``(N, 6, 6)`` of the camera pose, right perturbation, rotation (rad) first.
        nis: ``(N,)`` normalised innovations squared of the forward pass, six degrees of freedom;
            NaN where nothing was measured.
        accepted: ``(N,)`` false where a measurement was gated out.
    """

    trajectory: Trajectory
    velocity_m_s: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    covariance: FloatArray
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

    Args:
        measurements: ``world_T_camera`` with covariances; the world's z is up.
        imu: must cover the measurements that are to be used: the others are left out.
        noise: the IMU's densities and bias walks.
        imu_T_camera: pose of the camera on the IMU.
        stamps_ns: rising stamps at which the path is wanted, measured there or not; by default
            those of the measurements. Stamps before the first measurement or outside the IMU's
            span are left out.
        settings: gravity, gate, initial tilt error.
        smoothed: look ahead as well (backward pass); without it every estimate knows only its
            past, as if it ran live.

    Raises:
        ValueError: the IMU and the measurements do not overlap in time.
    """
    first, last = int(imu.time_ns[0]), int(imu.time_ns[-1])
    stamps = measurements.trajectory.time_ns
    covered = (stamps >= first) & (stamps <= last)
    if not np.any(covered):
        raise ValueError(
            f"measurements and imu: expected spans that overlap, got {stamps[0]} to {stamps[-1]} "
            f"ns and {first} to {last} ns"
        )
    used = PoseMeasurements(measurements.trajectory[covered], measurements.covariance[covered])
    start = int(used.trajectory.time_ns[0])
    wanted = used.trajectory.time_ns if stamps_ns is None else np.asarray(stamps_ns, np.int64)
    wanted = wanted[(wanted >= start) & (wanted <= last)]
    nodes = filter_forwards(
        used, imu, noise, imu_T_camera, np.union1d(used.trajectory.time_ns, wanted),
        settings or FilterSettings(),
    )  # fmt: skip
    estimates = smooth_backwards(nodes) if smoothed else [node.updated for node in nodes]
    chosen = np.isin([node.time_ns for node in nodes], wanted)
    kept = [estimate for estimate, keep in zip(estimates, chosen, strict=True) if keep]
    there = [node for node, keep in zip(nodes, chosen, strict=True) if keep]
    poses = _camera_poses(kept, imu_T_camera)
    return Fused(
        trajectory=Trajectory(
            wanted, poses, measurements.trajectory.parent, measurements.trajectory.child
        ),
        velocity_m_s=np.stack([one.motion.v for one in kept]),
        gyro_bias_rad_s=np.stack([one.gyro_bias for one in kept]),
        accel_bias_m_s2=np.stack([one.accel_bias for one in kept]),
        covariance=_camera_covariance(kept, poses),
        nis=np.array([np.nan if node.nis is None else node.nis for node in there]),
        accepted=np.array([node.accepted for node in there]),
    )


def _camera_poses(estimates: Sequence[Estimate], imu_T_camera: Motor) -> Motor:
    rotor = Rotor.from_matrix(np.stack([one.motion.R for one in estimates]))
    position = np.stack([one.motion.p for one in estimates])
    return Motor.from_rotor_translation(rotor, position) @ imu_T_camera


def _camera_covariance(estimates: Sequence[Estimate], poses: Motor) -> FloatArray:
    """Left (world) covariance of the pose, carried to the camera's own axes."""
    R, t = poses.rotor.as_matrix(), poses.translation_m
    back = np.swapaxes(R, -1, -2)
    to_camera = np.zeros((len(estimates), 6, 6))
    to_camera[:, :3, :3] = to_camera[:, 3:, 3:] = back
    to_camera[:, 3:, :3] = -back @ skew(t)
    pose = np.array([0, 1, 2, 6, 7, 8])
    left = np.stack([one.covariance for one in estimates])[:, pose[:, None], pose]
    spread = to_camera @ left @ to_camera.swapaxes(-1, -2)
    symmetric: FloatArray = 0.5 * (spread + spread.swapaxes(-1, -2))
    return symmetric
