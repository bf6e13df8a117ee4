"""Poses that jump and odometry that drifts, joined: less error than either, and smoother steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.graph.odometry import OdometryNoise, fuse_odometry
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.metrics import absolute_translation_m
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.readers.tagslam import recording as tagslam
from motorcade.tracking.measurements import PoseMeasurements
from tests.bench.fusion.tag_odometry import bench_tag_odometry, tag_odometry_table

IMU_T_CAMERA = Motor.from_euler_translation(np.array([0.3, -0.2, 3.0]), np.array([0.05, 0.02, 0.1]))
NOISE = OdometryNoise(2e-3, 5e-3)


def drifting(truth: Trajectory, rng: np.random.Generator) -> Trajectory:
    """Odometry of a frame that holds the camera at IMU_T_CAMERA, with noise of its steps."""
    body = truth.transformed_by(right=IMU_T_CAMERA.inverse())
    steps = body.motors[:-1].inverse() @ body.motors[1:]
    sigma = np.repeat([NOISE.rotation_rad_rts, NOISE.translation_m_rts], 3)
    dt_s = np.diff(truth.time_ns)[:, None] * 1e-9
    # The noise is the camera's, seen from the body.
    noise = Motor.from_twist(sigma * np.sqrt(dt_s) * rng.standard_normal((len(dt_s), 6)))
    steps = steps @ (IMU_T_CAMERA @ noise @ IMU_T_CAMERA.inverse())
    poses = [Motor.random(rng)]
    for step in steps:
        poses.append(poses[-1] @ step)
    return Trajectory(truth.time_ns, Motor.stack(poses), "odom", "body")


def rms(path: Trajectory, truth: Trajectory) -> float:
    error = absolute_translation_m(path.poses, truth.at(path.time_ns))
    return float(np.sqrt(np.mean(error**2)))


def given(rng: np.random.Generator) -> tuple[Trajectory, Trajectory, PoseMeasurements]:
    truth = MOTIONS["handheld"].sampled(30.0, 12.0)
    return truth, drifting(truth, rng), simulate_camera_poses(truth, 5.0, 0.01, 0.01, rng)


def test_both_are_better_than_either_and_know_how_well(rng):
    truth, odometry, measured = given(rng)
    fused = fuse_odometry(measured, odometry, IMU_T_CAMERA, NOISE)
    np.testing.assert_array_equal(fused.trajectory.time_ns, truth.time_ns)
    assert rms(fused.trajectory, truth) < 0.6 * rms(measured.trajectory, truth)
    errors = (fused.trajectory.motors.inverse() @ truth.motors).as_twist()
    white = np.linalg.solve(np.linalg.cholesky(fused.covariance), errors[..., None])
    assert 0.7 < np.mean(white**2) < 1.4


def test_wrong_poses_and_gaps_do_little_harm(rng):
    truth, odometry, measured = given(rng)
    wrong = np.arange(len(measured)) % 9 == 4
    off = Motor.from_twist(np.where(wrong[:, None], [0.0, 0.6, 0.0, 0.5, 0.0, 0.5], 0.0))
    degraded = measured.trajectory.transformed_by(right=off)
    kept = (degraded.time_s < 5.0) | (degraded.time_s > 7.5)
    fused = fuse_odometry(
        PoseMeasurements(degraded[kept], measured.covariance[kept]), odometry, IMU_T_CAMERA, NOISE
    )
    assert len(fused) == len(truth)
    assert rms(fused.trajectory, truth) < rms(measured.trajectory, truth)


def test_stamps_of_both_are_served_and_others_refused(rng):
    _, odometry, measured = given(rng)
    path = measured.trajectory
    moved = Trajectory(path.time_ns + 7_000_000, path.poses)
    late = PoseMeasurements(moved, measured.covariance)
    fused = fuse_odometry(late, odometry, IMU_T_CAMERA, NOISE)
    inside = moved.time_ns[moved.time_ns <= odometry.time_ns[-1]]
    np.testing.assert_array_equal(fused.trajectory.time_ns, np.union1d(odometry.time_ns, inside))
    far = PoseMeasurements(Trajectory(path.time_ns + 10**12, path.poses), measured.covariance)
    with pytest.raises(ValueError, match="overlap"):
        fuse_odometry(far, odometry, IMU_T_CAMERA)
    with pytest.raises(ValueError, match="translation_m_rts"):
        OdometryNoise(translation_m_rts=0.0)


@pytest.mark.slow
def test_tags_and_odometry_of_test_21(data_dir: Path):
    rows = {row["case"]: row for row in bench_tag_odometry(data_dir / "tags" / "tagslam")}
    both = rows["both"]
    assert both["frames"] == 430
    assert both["ape_rmse_m"] < 0.010
    assert rows["odometry"]["ape_rmse_m"] == pytest.approx(0.027, abs=5e-4)
    for alone in ("tags", "odometry"):
        assert both["step_error_rms_m"] < rows[alone]["step_error_rms_m"]
        assert both["step_error_rms_deg"] < rows[alone]["step_error_rms_deg"]
        assert both["step_change_rms_m"] < rows[alone]["step_change_rms_m"]
        assert both["step_change_rms_deg"] < rows[alone]["step_change_rms_deg"]
    assert tag_odometry_table(list(rows.values())).count("\n") == 3


def test_where_the_odometry_sits_on_the_rig_is_read(data_dir: Path):
    folder = data_dir / "tags" / "tagslam"
    found = tagslam.read_corners(folder / "test_21").odometry
    assert found is not None
    assert len(found.trajectory) == 2596
    placed = found.body_T_odometry
    np.testing.assert_allclose(placed.translation_m, [0.0106996, 0.0, 0.0], atol=1e-6)
    assert placed.rotor.angle() == pytest.approx(3.13923, abs=1e-4)
    assert tagslam.read_corners(folder / "test_24").odometry is None
