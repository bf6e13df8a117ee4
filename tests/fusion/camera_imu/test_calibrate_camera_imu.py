"""Camera and IMU calibrated together, against recordings of which all is known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from motorcade.fusion.camera_imu import CameraImuCalibration, calibrate_camera_imu
from motorcade.tracking import BoardMeasurements, TrackingError, measure_board
from tests.fusion.camera_imu.board_recordings import CAMERA, BoardRecording, recording
from tests.fusion.camera_imu.consistency import consistency, errors

SIZE = (CAMERA.width, CAMERA.height)


def calibrated(true: BoardRecording, *, known: bool = False) -> CameraImuCalibration:
    """The recording calibrated, with its camera known or not."""
    seen = measure_board(true.time_ns, true.views, CAMERA if known else None, size=SIZE)
    return calibrate_camera_imu(seen, true.imu, true.noise, gravity_m_s2=9.81)


@cache
def short() -> tuple[BoardRecording, BoardMeasurements, CameraImuCalibration]:
    true = recording(1, 6.0, rate_hz=10.0, imu_hz=100.0)
    seen = measure_board(true.time_ns, true.views, None, size=SIZE)
    return true, seen, calibrate_camera_imu(seen, true.imu, true.noise)


def test_everything_is_found_to_within_its_deviations():
    true, _, found = short()
    sigma = np.sqrt(np.diag(found.covariance))[:22]
    assert np.max(np.abs(errors(found, true)) / sigma) < 4.0
    assert found.offset_sigma_s < 1e-4
    assert np.all(found.rotation_sigma_rad < np.deg2rad(0.2))
    assert np.all(found.lever_arm_sigma_m < 0.003)
    assert np.all(found.gyro_sigma < 0.003)
    tilt = np.cross(found.gravity_m_s2, true.gravity_m_s2) / 9.81**2
    assert np.linalg.norm(tilt) < np.deg2rad(0.2)
    assert abs(np.linalg.norm(found.gravity_m_s2) - 9.81) < 4.0 * found.gravity_sigma_m_s2
    assert 0.7 < found.misfit < 1.3


def test_intrinsics_are_found_with_all_the_rest():
    _, seen, found = short()
    own, true = found.camera, CAMERA
    apart = np.array([own.fx, own.fy, own.cx, own.cy, *own.distortion])
    apart -= [true.fx, true.fy, true.cx, true.cy, *true.distortion]
    assert np.max(np.abs(apart) / found.intrinsics_sigma) < 4.0
    alone = np.sqrt(np.diag(seen.intrinsics_root @ seen.intrinsics_root.T))
    assert np.all(found.intrinsics_sigma < 1.02 * alone)
    assert found.intrinsics_sigma[2] < 0.95 * alone[2]  # what the IMU feels tells of the camera


def test_an_unknown_size_of_gravity_makes_scales_less_sure():
    true, seen, found = short()
    told = calibrate_camera_imu(seen, true.imu, true.noise, gravity_m_s2=9.81)
    assert told.gravity_sigma_m_s2 == 0.0
    assert np.isclose(np.linalg.norm(told.gravity_m_s2), 9.81)
    diagonal = np.diag_indices(3)
    assert np.all(found.accel_sigma[diagonal] > told.accel_sigma[diagonal])


def test_kalibrs_matrices_are_those_of_the_sensor():
    true, _, found = short()
    lower, turn = found.kalibr_gyroscope
    np.testing.assert_allclose(lower @ turn, np.linalg.inv(found.gyro_correction), atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) > 0.0
    assert np.all(np.diag(lower) > 0.9)
    for matrix in (lower, found.accel_matrix):
        np.testing.assert_allclose(np.triu(matrix, 1), 0.0, atol=1e-15)
    read = true.imu.angular_rate_rad_s
    np.testing.assert_allclose(
        found.corrected(true.imu).angular_rate_rad_s @ (lower @ turn).T, read, atol=1e-12
    )


def test_motion_without_rotation_is_refused():
    true = recording(2, 4.0, rate_hz=10.0, imu_hz=100.0, turning=0.0)
    with pytest.raises(ValueError, match="rotation about two axes"):
        calibrated(true, known=True)


def test_views_that_a_wrong_camera_explains_nowhere_are_refused():
    views, far = short()[0].views, replace(CAMERA, fx=2.0 * CAMERA.fx, fy=2.0 * CAMERA.fy)
    stamps = np.arange(len(views))
    with pytest.raises(TrackingError, match=r"expected some that a pose fits to 1\.2 px, got"):
        measure_board(stamps, views, replace(far, distortion=(0.0,) * len(far.distortion)))


def test_what_the_motion_does_not_tell_is_named():
    true = recording(3, 4.0, rate_hz=10.0, imu_hz=100.0, turning=0.15)
    seen = measure_board(true.time_ns, true.views, CAMERA)
    found = calibrate_camera_imu(
        seen, true.imu, true.noise, gravity_m_s2=9.81, correction_sigma=0.005
    )
    named = {one.name for one in found.parameters if one.unobservable}
    assert {"gyro_scale_x", "gyro_axis_xz"} <= named
    assert "gyro_scale_y" not in named
    for one in found.parameters:
        if one.name.startswith(("gyro_", "accel_")):
            assert bool(one.unobservable) == (one.sigma > 0.0025)
    assert len(found.unobservable) == len(named)


@pytest.mark.slow
def test_errors_are_as_large_as_stated():
    found = consistency(range(8), duration_s=12.0)
    assert 0.7 < found["nees_per_number"] < 1.4
    assert found["within_three_sigma"] > 0.98
    assert all(0.5 < rms < 1.6 for rms in found["normalised_rms"].values())
