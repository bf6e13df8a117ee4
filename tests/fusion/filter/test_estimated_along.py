"""What the filter estimates along the way: gravity's direction, extrinsics, time offset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from motorcade.fusion.filter import FilterSettings, fuse
from motorcade.fusion.imu import ADIS16448, ContinuousPath, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements

GRAVITY = np.array([0.0, 0.0, 9.81])


def test_gravity_extrinsics_and_time_offset_are_found(record, rng):
    """A world 2° off upright, extrinsics that are 1° and 2 cm off, poses 30 ms late."""
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
    blind = fuse(measurements, run.imu, run.noise, run.imu_T_camera, fits_noise=False)
    assert np.nanmean(fused.nis) < 7.0 < np.nanmean(blind.nis)


@pytest.mark.slow
def test_extrinsics_and_time_offset_err_as_much_as_their_covariance_says():
    """NEES of seven unknowns over simulated runs, started a few degrees and centimetres off."""
    true = Motor.from_euler_translation(np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07]))
    settings = FilterSettings(
        gravity_sigma_rad=0.02,
        extrinsics_sigma_rad=0.03,
        extrinsics_sigma_m=0.03,
        time_offset_sigma_s=0.005,
    )
    sigma, squares = np.repeat([0.03, 0.03], 3), []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        path = ContinuousPath.along(MOTIONS["handheld"], 30.0, start_ns=10**18)
        sensor = simulate_imu(path, 200.0, ADIS16448, rng)
        camera = sensor.path.transformed_by(right=true)
        poses = simulate_camera_poses(camera, 20.0, 0.01, float(np.deg2rad(0.5)), rng)
        offset_s = 0.005 * rng.standard_normal()
        given = poses.trajectory
        late = Trajectory(given.time_ns - round(offset_s * 1e9), given.motors)[4:-4]
        fused = fuse(
            PoseMeasurements(late, poses.covariance[4:-4]),
            sensor.stream,
            ADIS16448,
            true @ Motor.from_twist(sigma * rng.standard_normal(6)),
            settings=settings,
        )
        apart = (fused.imu_T_camera[-1].inverse() @ true).as_twist()
        error = np.append(apart, offset_s - fused.time_offset_s[-1])
        squares.append(error @ np.linalg.solve(fused.state_covariance[-1][-7:, -7:], error))
    low, high = chi2.ppf([1e-3, 0.999], 7 * len(squares))
    assert low < np.sum(squares) < high
