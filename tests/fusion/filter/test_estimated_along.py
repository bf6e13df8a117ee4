"""What the filter estimates along the way: gravity's direction, extrinsics, time offset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorcade.fusion.filter import FilterSettings, fuse
from motorcade.ga import Motor
from motorcade.tracking.measurements import PoseMeasurements

GRAVITY = np.array([0.0, 0.0, 9.81])


def test_gravity_mount_and_time_offset_are_found(record, rng):
    """Poses of a world 2° off upright, by a camera mounted 1° and 2 cm off, 30 ms late."""
    run = record(rng, 30.0)
    tilt = Motor.from_twist([np.deg2rad(2.0), np.deg2rad(-1.0), 0.3, 1.0, 2.0, 3.0])
    extrinsics = run.imu_T_camera @ Motor.from_twist([0.017, -0.01, 0.008, 0.02, -0.01, 0.015])
    path = run.measurements.trajectory
    inside = (path.time_ns[:-2] + 30_000_000) < run.imu.time_ns[-1]
    stamps = path.time_ns[:-2][inside]
    true = tilt @ run.truth.at(stamps + 30_000_000) @ extrinsics
    noise = np.repeat([np.deg2rad(0.5), 0.01], 3) * rng.standard_normal((len(stamps), 6))
    measurements = PoseMeasurements(
        replace(path, time_ns=stamps, poses=true @ Motor.from_twist(noise)),
        run.measurements.covariance[: len(stamps)],
    )
    settings = FilterSettings(
        gravity_sigma_rad=0.05,
        extrinsics_sigma_rad=0.03,
        extrinsics_sigma_m=0.05,
        time_offset_sigma_s=0.05,
    )
    fused = fuse(measurements, run.imu, run.noise, run.imu_T_camera, settings=settings)
    sigma = np.sqrt(np.diagonal(fused.state_covariance[-1]))
    down = tilt.rotor.apply(-GRAVITY)
    assert np.linalg.norm(fused.gravity_m_s2[-1] - down) < 9.81 * 4.0 * sigma[15:17].max()
    assert sigma[15:17].max() < np.deg2rad(0.1)
    assert abs(fused.time_offset_s[-1] - 0.03) < min(4.0 * sigma[23], 1e-3)
    apart = (fused.imu_T_camera[-1].inverse() @ extrinsics).as_twist()
    assert np.all(np.abs(apart) < 4.0 * sigma[17:23])
    assert np.all(sigma[17:20] < np.deg2rad(0.2))
    assert np.all(sigma[20:23] < 0.01)
    blind = fuse(measurements, run.imu, run.noise, run.imu_T_camera)
    assert np.nanmean(fused.nis) < 7.0 < np.nanmean(blind.nis)
