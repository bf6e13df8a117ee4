"""Two hours of an IMU with poses, fused and smoothed by the library alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.fusion.filter import fuse
from motorcade.fusion.imu import ADIS16448, ImuStream
from motorcade.ga import Motor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements

__all__ = ["fuse_measured", "write_measured"]

FILE = "measured.npz"


def write_measured(folder: Path, imu: ImuStream, poses: PoseMeasurements) -> None:
    """Write what `fuse_measured` reads."""
    np.savez(
        folder / FILE,
        imu_ns=imu.time_ns,
        rate=imu.angular_rate_rad_s,
        force=imu.specific_force_m_s2,
        poses_ns=poses.trajectory.time_ns,
        poses=poses.trajectory.motors.coefficients,
        covariance=poses.covariance,
    )


def fuse_measured(folder: Path) -> None:
    """Fuse it, looking ahead, with the covariance of the pose alone."""
    with np.load(folder / FILE) as held:
        imu = ImuStream(held["imu_ns"], held["rate"], held["force"])
        path = Trajectory(held["poses_ns"], Motor(held["poses"]))
        poses = PoseMeasurements(path, held["covariance"])
    fuse(poses, imu, ADIS16448, Motor.identity(), state_covariances=False)
