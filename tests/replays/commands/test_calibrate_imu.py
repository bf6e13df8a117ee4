"""`motorcade calibrate --imu`: images drawn of a board and an IMU in, files to be read back."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from motorcade.fusion.camera_imu import CameraImuCalibration, calibrate_camera_imu
from motorcade.replays.cli import main
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.imu import read_noise, write_imu
from motorcade.replays.io.readers.kalibr import read_chain, read_extrinsics
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.tasks.calibration import InertialRun, write_inertial
from motorcade.tracking import measure_board
from tests.fusion.camera_imu.board_recordings import (
    BOARD,
    CAMERA,
    IMU_T_CAMERA,
    OFFSET_S,
    BoardRecording,
    drawn,
    recording,
)


@cache
def short() -> tuple[BoardRecording, InertialRun]:
    true = recording(1, 4.0, rate_hz=10.0, imu_hz=100.0)
    seen = measure_board(true.time_ns, true.views, CAMERA)
    found = calibrate_camera_imu(seen, true.imu, true.noise)
    return true, InertialRun(found, seen, BOARD, 60, true.noise, 100.0)


def written(folder: Path) -> tuple[CameraImuCalibration, Path, Path, Path]:
    run = short()[1]
    path = folder / "rig.toml"
    return run.calibration, path, *write_inertial(run, path)


def test_kalibrs_files_are_read_back(tmp_path: Path) -> None:
    found, _, chain, imu = written(tmp_path)
    (camera,) = read_chain(chain)
    assert camera.camera == found.camera
    assert camera.offset_s == found.offset_s
    assert camera.imu_T_camera is not None
    np.testing.assert_allclose(
        camera.imu_T_camera.as_matrix(), found.imu_T_camera.as_matrix(), atol=1e-12
    )
    np.testing.assert_allclose(
        read_extrinsics(chain).as_matrix(), found.imu_T_camera.as_matrix(), atol=1e-12
    )
    assert read_noise(imu) == found.noise


def test_kalibrs_conventions_hold_by_another_reader(tmp_path: Path) -> None:
    """What Kalibr's pages say of each number, done with a YAML library and matrices alone."""
    _, _, chain, imu = written(tmp_path)
    true, run = short()
    camera = yaml.safe_load(chain.read_text())["cam0"]
    sensor = yaml.safe_load(imu.read_text())["imu0"]
    # A corner is projected through T_cam_imu from where the IMU is at t_imu = t_cam + shift.
    k, found = 17, run.calibration
    stamp = true.time_ns[k] * 1e-9 + camera["timeshift_cam_imu"]
    assert abs(stamp - (true.time_ns[k] * 1e-9 + OFFSET_S)) < 1e-3
    numbers = [*camera["distortion_coeffs"], *camera["intrinsics"], camera["timeshift_cam_imu"]]
    assert all(isinstance(one, float) for one in numbers)
    board_T_imu = (true.board_T_camera[k] @ IMU_T_CAMERA.inverse()).as_matrix()
    points = np.column_stack([true.views[k].points_m, np.ones(len(true.views[k]))])
    x, y, z, _ = np.array(camera["T_cam_imu"]) @ np.linalg.inv(board_T_imu) @ points.T
    fx, fy, cx, cy = camera["intrinsics"]
    assert camera["distortion_model"] == "radtan"
    matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    pixels, _ = cv2.projectPoints(
        np.stack([x, y, z], axis=-1),
        np.zeros(3),
        np.zeros(3),
        matrix,
        np.array(camera["distortion_coeffs"]),
    )
    assert np.abs(pixels[:, 0] - true.views[k].corners_px).mean() < 1.5  # the extrinsics' errors
    # Readings are M C_gyro_i times the true rate, and M times the true force, plus biases.
    gyro = np.array(sensor["gyroscopes"]["M"]) @ np.array(sensor["gyroscopes"]["C_gyro_i"])
    accel = np.array(sensor["accelerometers"]["M"])
    assert sensor["model"] == "scale-misalignment"
    np.testing.assert_allclose(gyro @ found.gyro_correction, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(accel @ found.accel_correction, np.eye(3), atol=1e-12)
    true_gyro = np.linalg.inv(true.gyro_correction)
    assert np.max(np.abs(gyro - true_gyro) / found.gyro_sigma) < 4.5


def test_the_manifest_opens_the_recording_on_one_clock_and_corrected(tmp_path: Path) -> None:
    found, path, *_ = written(tmp_path)
    true = short()[0]
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((480, 752), np.uint8))
    write_imu(true.imu, tmp_path / "imu.csv")
    text = path.read_text().replace("[imu]", '[imu]\nfile = "imu.csv"')
    path.write_text(f'{text}\n[frames]\nimages = "*.png"\nrate_hz = 20\n')
    opened = open_recording(tmp_path, path)
    assert opened.camera == found.camera
    assert opened.imu_noise == found.noise
    assert opened.imu is not None
    assert opened.imu_T_camera is not None
    assert opened.imu.time_ns[0] == true.imu.time_ns[0] - round(1e9 * found.offset_s)
    corrected = found.corrected(true.imu)
    np.testing.assert_array_equal(opened.imu.angular_rate_rad_s, corrected.angular_rate_rad_s)
    np.testing.assert_array_equal(opened.imu.specific_force_m_s2, corrected.specific_force_m_s2)
    for wrong in ("[1.0]", "[[1, 0, 0], [0, 1, 0], [0, 0, 9]]", '[["a", 0, 0], [], []]'):
        bad = tmp_path / "bad.toml"
        lines = [line for line in path.read_text().splitlines() if "gyro_corr" not in line]
        bad.write_text("\n".join(lines).replace("[imu]", f"[imu]\ngyro_correction = {wrong}"))
        with pytest.raises(RecordingError, match=r"\[imu\] gyro_correction: expected"):
            open_recording(tmp_path, bad)


@pytest.mark.slow
def test_a_drawn_recording_gives_what_it_was_drawn_with(tmp_path: Path, capsys) -> None:
    true = recording(5, 15.0, rate_hz=16.0)
    mav = tmp_path / "rig" / "mav0"
    (mav / "cam0" / "data").mkdir(parents=True)
    (mav / "imu0").mkdir()
    rows = ["#timestamp [ns],filename"]
    for stamp, image in zip(true.time_ns.tolist(), drawn(true.board_T_camera), strict=True):
        cv2.imwrite(str(mav / "cam0" / "data" / f"{stamp}.png"), image)
        rows.append(f"{stamp},{stamp}.png")
    (mav / "cam0" / "data.csv").write_text("\n".join(rows) + "\n")
    write_imu(true.imu, mav / "imu0" / "data.csv")
    out = tmp_path / "rig.toml"
    named = ["--board", BOARD.name, "--imu", "-o", str(out), "--gravity", "9.81", "--json"]
    assert main(["calibrate", str(tmp_path / "rig"), *named]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["images_with_board"] > 0.95 * len(true.views)
    found = {one["name"]: (one["value"], one["sigma"]) for one in said["parameters"]}
    expected = {"offset_s": OFFSET_S}
    for k, axis in enumerate("xyz"):
        expected[f"lever_arm_{axis}_m"] = float(IMU_T_CAMERA.translation_m[k])
        expected[f"gravity_{axis}_m_s2"] = float(true.gravity_m_s2[k])
        for sensor, matrix in (("gyro", true.gyro_correction), ("accel", true.accel_correction)):
            expected[f"{sensor}_scale_{axis}"] = float(matrix[k, k])
    for key in ("fx", "fy", "cx", "cy"):
        expected[f"{key}_px"] = getattr(CAMERA, key)
    far = {name: abs(found[name][0] - value) / found[name][1] for name, value in expected.items()}
    assert max(far.values()) < 4.0, far
    chain = out.with_name("rig-camchain-imucam.yaml")
    apart = read_extrinsics(chain).local(IMU_T_CAMERA)
    assert np.linalg.norm(apart[:3]) < np.deg2rad(0.2)
    assert np.linalg.norm(apart[3:]) < 0.002


def test_what_cannot_be_calibrated_is_told_in_one_line(tmp_path: Path, capsys) -> None:
    folder = tmp_path / "mav0"
    (folder / "cam0" / "data").mkdir(parents=True)
    (folder / "imu0").mkdir()
    rows = []
    for k in range(3):
        cv2.imwrite(str(folder / "cam0" / "data" / f"{k}.png"), np.zeros((48, 64), np.uint8))
        rows.append(f"{k * 50_000_000},{k}.png")
    (folder / "cam0" / "data.csv").write_text("\n".join(rows) + "\n")

    def refusal_of(*more: object) -> str:
        named = ["--board", BOARD.name, "-o", str(tmp_path / "rig.toml")]
        assert main(["calibrate", *map(str, more), *named]) == 1
        err = capsys.readouterr().err.strip()
        assert len(err.splitlines()) == 1
        assert not (tmp_path / "rig.toml").exists()
        return err

    assert "without them" in refusal_of(tmp_path, "--imu")
    write_imu(short()[0].imu, folder / "imu0" / "data.csv")
    assert "in 40 images or more, got it in 0 of 3" in refusal_of(tmp_path, "--imu")
    assert "one recording beside an IMU" in refusal_of(tmp_path, tmp_path, "--imu", "imu.csv")
