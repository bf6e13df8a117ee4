"""Scales and axes of an IMU, found with the path, on simulated sensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.filter import FilterSettings
from motorcade.fusion.graph import fuse_by_graph
from motorcade.fusion.graph.calibrate import (
    GraphCalibration,
    calibrate_by_graph,
    corrected,
    corrections,
)
from motorcade.fusion.imu import ADIS16448, ImuStream
from motorcade.fusion.measurements.interface import PredictedState, numerical_jacobian
from motorcade.fusion.measurements.poses import CornerMeasurements, with_intrinsics
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera
from tests.end_to_end.gap_paths import Case, shapes

Record = Callable[..., Any]
OPEN = FilterSettings(gate=1.0)


def wrong(run: Any, numbers: FloatArray) -> Any:
    """The recording as a sensor reads it that these numbers correct."""
    gyro, accel = (np.linalg.inv(one) for one in corrections(numbers))
    imu = ImuStream(
        run.imu.time_ns,
        run.imu.angular_rate_rad_s @ gyro.T,
        run.imu.specific_force_m_s2 @ accel.T,
    )
    return replace(run, imu=imu)


def calibrated(run: Any, **options: Any) -> GraphCalibration:
    return calibrate_by_graph(
        run.measurements, run.imu, run.noise, run.imu_T_camera, **options, settings=OPEN
    )


def in_deviations(found: GraphCalibration, numbers: FloatArray) -> FloatArray:
    """Errors ``(15,)`` of what was found, over its deviations."""
    gyro, accel = corrections(numbers)
    lower = np.tril_indices(3)
    return np.concatenate(
        [
            ((found.gyro_correction - gyro) / found.gyro_sigma).ravel(),
            (found.accel_correction - accel)[lower] / found.accel_sigma[lower],
        ]
    )


def test_corrections_undo_what_is_wrong(record: Record, rng):
    run, numbers = record(rng, 1.0), 0.05 * rng.standard_normal(15)
    back = corrected(wrong(run, numbers).imu, numbers)
    np.testing.assert_allclose(back.angular_rate_rad_s, run.imu.angular_rate_rad_s, atol=1e-12)
    np.testing.assert_allclose(back.specific_force_m_s2, run.imu.specific_force_m_s2, atol=1e-12)


def test_scales_and_axes_are_found_to_within_their_deviations(record: Record, rng):
    run, numbers = record(rng, 6.0), 0.02 * rng.standard_normal(15)
    numbers[0] = 0.04
    moved = wrong(run, numbers)
    found = calibrated(moved)
    assert np.max(np.abs(in_deviations(found, numbers))) < 4.0
    assert np.all(found.gyro_sigma < 0.015)  # of 0.02
    assert found.gyro_sigma[2, 2] < 0.006
    assert np.all(found.accel_sigma[np.triu_indices(3, 1)] == 0.0)
    assert found.rounds <= 4
    truth = run.camera.at(found.fused.trajectory.time_ns)
    plain = fuse_by_graph(
        moved.measurements, moved.imu, moved.noise, moved.imu_T_camera, settings=OPEN
    )
    errors = [
        np.sqrt(np.mean(one.trajectory.poses.local(truth)[:, :3] ** 2))
        for one in (plain, found.fused)
    ]
    assert errors[1] < 0.8 * errors[0]


@pytest.mark.slow
def test_errors_of_the_corrections_are_as_large_as_stated(record: Record):
    apart = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        run, numbers = record(rng, 4.0), 0.02 * rng.standard_normal(15)
        apart.append(in_deviations(calibrated(wrong(run, numbers)), numbers))
    assert 0.85 < np.sqrt(np.mean(np.square(apart))) < 1.15


def test_a_good_sensor_is_left_as_it_is(record: Record, rng):
    run = record(rng, 4.0)
    found = calibrated(run)
    assert np.max(np.abs(found.gyro_correction - np.eye(3)) / found.gyro_sigma) < 4.0
    batch = fuse_by_graph(run.measurements, run.imu, run.noise, run.imu_T_camera, settings=OPEN)
    apart = batch.trajectory.poses.local(found.fused.trajectory.poses)
    sigma = np.sqrt(np.einsum("kii->ki", found.fused.covariance))
    assert np.max(np.abs(apart) / sigma) < 3.0
    assert np.all(np.einsum("kii->k", found.fused.covariance) >
                  0.99 * np.einsum("kii->k", batch.covariance))  # fmt: skip


def test_bad_input_is_refused(record: Record, rng):
    run = record(rng, 1.0)
    with pytest.raises(ValueError, match="correction_sigma"):
        calibrated(run, correction_sigma=0.0)
    late = run.imu.time_ns + 20 * 10**9 * (run.imu.time_ns > run.imu.time_ns[50])
    with pytest.raises(ValueError, match="imu: expected one segment"):
        calibrated(replace(run, imu=replace(run.imu, time_ns=late)))


# Intrinsics -------------------------------------------------------------------------------------

CAMERA = Camera(752, 480, 460.0, 457.0, 367.0, 248.0, "radtan", (-0.28, 0.07, 2e-4, 2e-5))
SPREAD_PX = 0.3


def images(run: Any, rng: np.random.Generator, **options: Any) -> CornerMeasurements:
    """Twelve points of a board two metres ahead, in an image every fifth of a second."""
    stamps, poses = run.truth.time_ns[::20], run.camera.motors[::20]
    board = np.stack(np.meshgrid([-0.9, -0.3, 0.3, 0.9], [-0.6, 0.0, 0.6]), axis=-1).reshape(-1, 2)
    board = np.column_stack([board, rng.uniform(1.8, 2.4, 12)])
    pixels, points, rows = [], [], []
    for stamp, pose in zip(stamps.tolist(), poses, strict=True):
        world = pose.apply(board + 0.1 * rng.standard_normal(3))
        seen = CAMERA.project(pose.inverse().apply(world))
        seen = seen + SPREAD_PX * rng.standard_normal(seen.shape)
        for k in range(0, 12, 4):
            pixels.append(seen[k : k + 4])
            points.append(world[k : k + 4])
            rows.append(stamp)
    return CornerMeasurements(
        time_ns=np.array(rows),
        pixels=np.array(pixels),
        points_m=np.array(points),
        sigma_px=SPREAD_PX,
        **{"camera": CAMERA, **options},
    )


def test_readings_that_are_not_of_the_motion_are_refused_rather_than_corrected_away(tmp_path: Path):
    """Poses a second apart, read at the poses alone: what turned between them is not in it."""
    case = Case.of(shapes(10**9)["gaps alone"], tmp_path)
    with pytest.raises(ValueError, match="follow the poses once scale and axes are corrected"):
        calibrate_by_graph(case.measured, case.imu, ADIS16448, Motor.identity())


def test_derivatives_of_corners_are_those_of_differences(record: Record, rng):
    run = record(rng, 1.0)
    given = images(run, rng, shift_s=-0.003)
    pose, speed = run.truth.motors[20], run.velocity_m_s[20]
    camera = run.imu_T_camera.coefficients
    state = replace(PredictedState.at(pose, speed, np.array([0.1, -0.2, 0.3])), imu_T_camera=camera)
    apart = given.jacobian(3, state) - numerical_jacobian(given, 3, state)
    assert np.max(np.abs(apart)) < 2e-3  # of some hundred pixels: first order in the offset
    own, columns = given.parameters, []
    for k in range(len(own)):
        step = 1e-5 * (np.arange(len(own)) == k)
        ahead, behind = (
            given.with_parameters(own + side).residual(3, state) for side in (step, -step)
        )
        columns.append((ahead - behind) / 2e-5)
    np.testing.assert_allclose(
        given.parameter_jacobian(3, state), np.stack(columns, axis=-1), atol=1e-4
    )


def test_intrinsics_are_found_to_within_their_deviations(record: Record, rng):
    run = record(rng, 3.0)
    rough = with_intrinsics(CAMERA, np.array([470.0, 450.0, 360.0, 255.0, -0.25, 0.05, 0.0, 0.0]))
    given = images(run, rng, camera=rough, pinhole_sigma_px=10.0, distortion_sigma=0.05)
    found = calibrated(run, also=[given])
    (camera,), (sigma,) = found.also, found.parameter_sigma
    true = np.array([CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy, *CAMERA.distortion])
    assert np.max(np.abs(camera.parameters - true) / sigma) < 4.0
    assert np.all(sigma[:4] < 2.0)  # of 10 pixels
    assert np.all(sigma[4:] < 0.02)  # of 0.05
    (judged,) = found.fused.also
    assert np.mean(judged.accepted) > 0.98
