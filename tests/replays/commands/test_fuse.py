"""`motorcade fuse`: files in, a path out that gtsam's batch agrees with."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion import fuse_by_graph
from motorcade.fusion.imu import ADIS16448, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from motorcade.replays.stages.inertial.filter_input import assumed_noise
from motorcade.tracking import PoseMeasurements

IMU_T_CAMERA = Motor.from_euler_translation(
    np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07])
)
SIGMA_M, SIGMA_RAD = 0.005, 0.005


@dataclass(frozen=True)
class Files:
    """What a user has, and what is right."""

    poses: Path
    imu: Path
    extrinsics: Path
    truth: Trajectory
    measured: PoseMeasurements
    stream: ImuStream


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    folder = tmp_path_factory.mktemp("fuse")
    rng = np.random.default_rng(5)
    start_ns = 1_700_000_000 * 10**9
    imu_path = MOTIONS["handheld"].sampled(200.0, 12.0, start_ns=start_ns, child="imu")
    stream = simulate_imu(imu_path, 200.0, ADIS16448, rng).stream
    truth = imu_path.transformed_by(right=IMU_T_CAMERA, child="camera")
    measured = simulate_camera_poses(truth, 20.0, SIGMA_M, SIGMA_RAD, rng)
    write_trajectory(measured.trajectory, folder / "poses.tum")
    write_imu(stream, folder / "imu.csv")
    np.savetxt(folder / "extrinsics.txt", IMU_T_CAMERA.as_matrix())
    return Files(
        folder / "poses.tum", folder / "imu.csv", folder / "extrinsics.txt", truth, measured, stream
    )


def fused(files: Files, out: Path, *arguments: object) -> Trajectory:
    given = ["fuse", files.poses, files.imu, "-o", out, *arguments]
    assert main([str(one) for one in given]) == 0
    return read_trajectory(out)


def test_no_zero_is_printed_as_a_negative_one(
    files: Files, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.savetxt(tmp_path / "turned.txt", np.diag([1.0, -1.0, -1.0, 1.0]))
    given = ["--extrinsics", tmp_path / "turned.txt", "--extrinsics-sigma-deg", 0]
    given += ["--least-accepted", 0]  # the IMU is turned, and denies most poses
    fused(files, tmp_path / "a.tum", *given)
    assert "-0" not in capsys.readouterr().out.split()


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main([str(one) for one in arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    return line


def test_a_lag_lies_between_live_and_whole(
    files: Files, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["--extrinsics", files.extrinsics]
    whole, live, at_once, soon = (
        fused(files, tmp_path / "a.tum", *given, *more)
        for more in ((), ("--online",), ("--lag", 0), ("--lag", 0.3))
    )
    np.testing.assert_array_equal(at_once.motors.coefficients, live.motors.coefficients)
    apart = [np.std(whole.motors.local(one.motors)[:, 3:]) for one in (live, soon)]
    assert 0.0 < apart[1] < 0.5 * apart[0]
    capsys.readouterr()
    line = refused(capsys, "fuse", files.poses, files.imu, "-o", tmp_path / "d.tum",
                   "--lag", 1, "--online")  # fmt: skip
    assert "lag_s: expected none where nothing looks ahead, got 1.0" in line


def test_noise_that_a_short_recording_does_not_tell_stays(
    files: Files, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["--extrinsics", files.extrinsics, "--learn-noise", "--json", tmp_path / "a.json"]
    fused(files, tmp_path / "a.tum", *given)
    assert "the noise stays as it was: 24 s of poses are needed" in capsys.readouterr().out
    noise = json.loads((tmp_path / "a.json").read_text())["noise"]
    assert not noise["learnt"]
    sheet = assumed_noise(ADIS16448, "recorded")
    assert noise["gyro_density_rad_s_rthz"] == sheet.gyro_density_rad_s_rthz


def test_the_path_is_that_of_gtsams_batch(files: Files, tmp_path: Path) -> None:
    known = ["--sigma-m", SIGMA_M, "--sigma-deg", np.rad2deg(SIGMA_RAD)]
    doubts = ["--gravity-sigma-deg", 0, "--extrinsics-sigma-deg", 0]
    found = fused(files, tmp_path / "a.tum", "--extrinsics", files.extrinsics, *known, *doubts)
    measured = PoseMeasurements(read_trajectory(files.poses), files.measured.covariance)
    batch = fuse_by_graph(
        measured, files.stream, assumed_noise(ADIS16448, "recorded"), IMU_T_CAMERA
    )
    np.testing.assert_array_equal(found.time_ns, batch.trajectory.time_ns)
    apart = np.abs(found.motors.local(batch.trajectory.motors))
    sigma = np.sqrt(np.einsum("nii->ni", batch.covariance))
    assert np.max(apart / sigma) < 0.25
    errors = evaluate(found, files.truth)
    assert errors.ape_m.rmse < 0.4 * evaluate(measured.trajectory, files.truth).ape_m.rmse


def test_noise_that_nobody_states_is_estimated(files: Files, tmp_path: Path) -> None:
    out = tmp_path / "b.json"
    found = fused(
        files, tmp_path / "b.tum", "--extrinsics", files.extrinsics, "--json", out,
        "--noise-factor", 1,
    )  # fmt: skip
    figures = json.loads(out.read_text())
    assert figures["sigma_m"] == pytest.approx(SIGMA_M, rel=0.15)
    assert figures["sigma_deg"] == pytest.approx(np.rad2deg(SIGMA_RAD), rel=0.15)
    assert figures["nis_per_dimension"] == pytest.approx(1.0, abs=0.3)
    assert figures["fused_poses"] == figures["poses"] == len(found)
    assert evaluate(found, files.truth).ape_m.rmse < 0.002
    assert np.linalg.norm(figures["gravity_m_s2"]) == pytest.approx(9.81)


def test_extrinsics_and_offset_are_found_where_that_is_asked_for(
    files: Files, tmp_path: Path
) -> None:
    late = ImuStream(
        files.stream.time_ns + 30_000_000,
        files.stream.angular_rate_rad_s,
        files.stream.specific_force_m_s2,
    )
    write_imu(late, tmp_path / "late.csv")
    given = ["fuse", files.poses, tmp_path / "late.csv", "--noise-factor", 1]
    outputs = ["-o", tmp_path / "c.tum", "--json", tmp_path / "c.json"]
    estimate = ["--estimate", "extrinsics", "offset"]
    assert main([str(one) for one in (*given, *outputs, *estimate)]) == 0
    figures = json.loads((tmp_path / "c.json").read_text())
    assert figures["offset_ms"] == pytest.approx(30.0, abs=1.0)
    assert 0.0 < figures["offset_sigma_ms"] < 1.0
    np.testing.assert_allclose(
        figures["imu_T_camera_translation_m"], IMU_T_CAMERA.translation_m, atol=0.01
    )
    found = read_trajectory(tmp_path / "c.tum")
    assert evaluate(found, files.truth).rotation_deg.rmse < 0.1
    # What was found is a file for the next time, with the offset known.
    outputs = ["-o", tmp_path / "d.tum", "--extrinsics", tmp_path / "c.json"]
    assert main([str(one) for one in (*given, *outputs, "--offset-s", 0.03)]) == 0
    again = read_trajectory(tmp_path / "d.tum")
    assert evaluate(again, files.truth).ape_m.rmse < 0.002


@pytest.mark.parametrize("lean_deg", [0.0, 60.0, 180.0])
def test_a_world_that_leans_is_fused_in_itself(
    lean_deg: float, files: Files, tmp_path: Path
) -> None:
    turn = Motor.from_euler_translation(np.deg2rad([lean_deg, 0.0, 20.0]), np.array([1.0, 2, 3]))
    poses = tmp_path / "leaning.tum"
    write_trajectory(read_trajectory(files.poses).transformed_by(left=turn), poses)
    out = tmp_path / "e.tum"
    given = ["fuse", poses, files.imu, "-o", out, "--extrinsics", files.extrinsics]
    assert main([str(one) for one in (*given, "--json", tmp_path / "e.json")]) == 0
    truth = files.truth.transformed_by(left=turn)
    assert evaluate(read_trajectory(out), truth).ape_m.rmse < 0.003
    figures = json.loads((tmp_path / "e.json").read_text())
    assert figures["world_lean_deg"] == pytest.approx(lean_deg, abs=3.0)
    down = turn.rotor.apply(np.array([0.0, 0.0, -9.81]))
    np.testing.assert_allclose(figures["gravity_m_s2"], down, atol=0.2)


def test_stamps_covariances_and_the_online_path(files: Files, tmp_path: Path) -> None:
    more = ["--extrinsics", files.extrinsics, "--noise-factor", 1]
    out = tmp_path / "f.csv"
    fine = fused(files, tmp_path / "f.tum", *more, "--stamps", "imu", "--covariance", out)
    assert len(fine) > 2300
    table = np.loadtxt(out, delimiter=",")
    np.testing.assert_allclose(table[:, 0], fine.time_ns, rtol=0.0, atol=1000.0)
    rows, columns = np.triu_indices(6)
    assert table.shape[1] == 1 + len(rows)
    assert np.all(table[:, 1:][:, rows == columns] > 0.0)
    some = tmp_path / "some.tum"
    write_trajectory(files.truth[100:200], some)
    assert len(fused(files, tmp_path / "g.tum", *more, "--stamps", some)) == 100
    live = fused(files, tmp_path / "h.tum", *more, "--online")
    whole = fused(files, tmp_path / "i.tum", *more)
    errors = [evaluate(one, files.truth).ape_m.rmse for one in (live, whole)]
    assert errors[1] < errors[0]
    assert errors[0] < evaluate(read_trajectory(files.poses), files.truth).ape_m.rmse


def test_what_cannot_be_fused_is_refused_in_one_line(
    files: Files, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = ["fuse", files.poses, files.imu, "-o", tmp_path / "x.tum"]
    both = ["--extrinsics", files.extrinsics, "--estimate", "extrinsics"]
    assert "expected a file or --estimate extrinsics, got both" in refused(capsys, *base, *both)
    assert "sigma_m" in refused(capsys, *base, "--sigma-m", 0)
    assert "noise_factor" in refused(capsys, *base, "--noise-factor", -1)
    assert "overlap" in refused(capsys, *base, "--offset-s", 1000)
    assert "imu_T_camera_wxyz" in refused(capsys, *base, "--extrinsics", _text(tmp_path, "{}"))
    short = tmp_path / "short.tum"
    write_trajectory(files.truth[:5], short)
    assert "16 poses" in refused(capsys, "fuse", short, files.imu, "-o", tmp_path / "x.tum")
    assert not (tmp_path / "x.tum").exists()


def _text(folder: Path, text: str) -> Path:
    file = folder / "sync.json"
    file.write_text('{"imu_T_camera_wxyz": [1, 0], "imu_T_camera_translation_m": 3}' + text[2:])
    return file


GYRO_READS = np.array([[1.04, 0.01, -0.02], [0.015, 0.97, 0.01], [-0.01, 0.02, 1.03]])
ACCEL_READS = np.array([[0.96, 0.0, 0.0], [0.02, 1.05, 0.0], [-0.01, 0.015, 1.02]])
LATE_S = 0.08
NOISE = """gyroscope_noise_density: 1.7e-4
gyroscope_random_walk: 1.9e-5
accelerometer_noise_density: 2.0e-3
accelerometer_random_walk: 3.0e-3
"""


def _rig(folder: Path, gyro: np.ndarray, accel: np.ndarray, offset_s: float) -> Path:
    """What `motorcade calibrate --imu` would write."""
    (folder / "rig-imu.yaml").write_text(NOISE)
    file = folder / "rig.toml"
    file.write_text(
        f'[imu]\nnoise_file = "rig-imu.yaml"\nclock_offset_s = {offset_s}\n'
        f"gyro_correction = {gyro.tolist()}\naccel_correction = {accel.tolist()}\n"
        f"imu_T_camera = {IMU_T_CAMERA.as_matrix().tolist()}\n"
    )
    return file


@pytest.fixture
def faulty(files: Files, tmp_path: Path) -> Files:
    """The same flight, read by sensors with scales and axes of their own and a clock ahead."""
    late = files.stream.time_ns + round(1e9 * LATE_S)
    rate = np.einsum("ij,nj->ni", GYRO_READS, files.stream.angular_rate_rad_s)
    force = np.einsum("ij,nj->ni", ACCEL_READS, files.stream.specific_force_m_s2)
    write_imu(ImuStream(late, rate, force), tmp_path / "faulty.csv")
    return replace(files, imu=tmp_path / "faulty.csv")


def test_a_calibrated_rig_takes_scale_axes_and_clock_off(
    files: Files, faulty: Files, tmp_path: Path
) -> None:
    """Beside the path of a sensor without faults, the ground truth, and innovations."""
    (tmp_path / "noise.yaml").write_text(NOISE)
    given = ["--extrinsics", files.extrinsics, "--noise", tmp_path / "noise.yaml"]
    right = fused(files, tmp_path / "right.tum", *given)
    turned, forced = np.linalg.inv(GYRO_READS), np.linalg.inv(ACCEL_READS)

    def told(gyro: np.ndarray, accel: np.ndarray, offset_s: float) -> tuple[float, float]:
        rig, figures = _rig(tmp_path, gyro, accel, offset_s), tmp_path / "figures.json"
        path = fused(faulty, tmp_path / "path.tum", "--rig", rig, "--json", figures)
        nis = json.loads(figures.read_text())["nis_per_dimension"]
        return evaluate(path, files.truth).ape_m.rmse, nis

    least_m, least_nis = told(turned, forced, LATE_S)
    apart = read_trajectory(tmp_path / "path.tum").motors.local(right.motors)
    np.testing.assert_allclose(apart, 0.0, atol=1e-6)
    for wrong in (
        (GYRO_READS, forced, LATE_S),
        (turned, ACCEL_READS, LATE_S),
        (turned, forced, -LATE_S),
    ):
        error_m, nis = told(*wrong)
        assert error_m > 1.1 * least_m
        assert nis > 1.2 * least_nis


def test_a_chains_time_shift_is_heeded(files: Files, tmp_path: Path) -> None:
    late = replace(files.stream, time_ns=files.stream.time_ns + round(1e9 * LATE_S))
    write_imu(late, tmp_path / "late.csv")
    files = replace(files, imu=tmp_path / "late.csv")
    chain = _chain(tmp_path, f"  timeshift_cam_imu: {LATE_S}\n")
    named = fused(files, tmp_path / "b.tum", "--extrinsics", files.extrinsics, "--offset-s", LATE_S)
    path = fused(files, tmp_path / "a.tum", "--extrinsics", chain)
    np.testing.assert_allclose(path.motors.local(named.motors), 0.0, atol=1e-6)
    ignored = fused(files, tmp_path / "c.tum", "--extrinsics", chain, "--offset-s", 0)
    errors = [evaluate(one, files.truth).ape_m.rmse for one in (path, ignored)]
    assert errors[1] > 1.5 * errors[0]


def test_a_chain_without_a_time_shift_leaves_the_rigs_offset(files: Files, tmp_path: Path) -> None:
    rig = _rig(tmp_path, np.eye(3), np.eye(3), LATE_S)

    def offset_ms(more: str) -> float:
        given = [
            "--rig",
            rig,
            "--extrinsics",
            _chain(tmp_path, more),
            "--json",
            tmp_path / "a.json",
        ]
        fused(files, tmp_path / "a.tum", *given)
        return float(json.loads((tmp_path / "a.json").read_text())["offset_ms"])

    assert offset_ms("") == pytest.approx(1e3 * LATE_S)
    assert offset_ms("  timeshift_cam_imu: 0.0\n") == 0.0


def test_a_rig_without_what_is_needed_is_refused(
    files: Files, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig = tmp_path / "rig.toml"
    base = ["fuse", files.poses, files.imu, "-o", tmp_path / "x.tum", "--rig", rig]
    rig.write_text("[camera]\n")
    assert "imu: the table is missing" in refused(capsys, *base)
    rig.write_text("[imu]\nclock_offset_s = 0.1\n")
    assert "[imu] imu_T_camera: the key is missing" in refused(capsys, *base)


def test_extrinsics_are_read_as_kalibr_writes_them(tmp_path: Path) -> None:
    from motorcade.replays.io.readers.kalibr import read_extrinsics

    apart = read_extrinsics(_chain(tmp_path)).local(IMU_T_CAMERA)
    np.testing.assert_allclose(apart, 0.0, atol=1e-9)


def _chain(folder: Path, more: str = "") -> Path:
    rows = "\n".join(f"  - {row}" for row in IMU_T_CAMERA.inverse().as_matrix().tolist())
    chain = folder / "camchain.yaml"
    chain.write_text(
        f"cam0:\n  T_cam_imu:\n{rows}\n  camera_model: pinhole\n  distortion_model: radtan\n"
        "  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  intrinsics: [400.0, 400.0, 320.0, 240.0]\n"
        f"  resolution: [640, 480]\n{more}"
    )
    return chain


def test_a_path_that_most_poses_deny_is_no_result(
    files: Files, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Unless it is asked for: then the worst stands first in the closing line."""
    rng = np.random.default_rng(23)
    gross = rng.uniform(-2.0, 2.0, (len(files.measured), 6)) * np.repeat([1.0, 2.0], 3)
    wild = files.measured.trajectory.transformed_by(right=Motor.from_twist(gross))
    write_trajectory(wild, tmp_path / "wild.tum")
    given = ["fuse", tmp_path / "wild.tum", files.imu, "-o", tmp_path / "out.tum"]
    given += ["--sigma-m", SIGMA_M, "--sigma-deg", 0.3]
    line = refused(capsys, *given)
    assert re.search(r"\d+ of 24[01] poses were refused \(up to 50% may be\)", line), line
    assert not (tmp_path / "out.tum").exists()
    asked = [*given, "--least-accepted", 0, "--json", tmp_path / "out.json"]
    assert main([str(one) for one in asked]) == 0
    assert "poses were refused" in capsys.readouterr().out.splitlines()[-1].split(";")[0]
    told = json.loads((tmp_path / "out.json").read_text())
    assert told["health"]["failed"]
    assert told["doubts"] == [one["summary"] for one in told["health"]["findings"]]
