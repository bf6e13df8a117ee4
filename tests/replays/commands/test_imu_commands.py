"""`simulate-imu` with a whole sensor model, and `allan` on what stood still."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.imu import ImuNoise
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.trajectories import write_trajectory


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


@pytest.fixture
def moving(tmp_path: Path) -> Path:
    file = tmp_path / "moving.tum"
    write_trajectory(MOTIONS["handheld"].sampled(50.0, 4.0, start_ns=10**18), file)
    return file


def test_every_fault_of_the_sensor_reaches_the_file(moving: Path, tmp_path: Path) -> None:
    plain, faulty = tmp_path / "plain.csv", tmp_path / "faulty.csv"
    assert run("simulate-imu", moving, "-o", plain, "--noise", "none") == 0
    assert run(
        "simulate-imu", moving, "-o", faulty, "--noise", "none",
        "--time-offset-s", "0.02", "--dropped", "0.1", "--accel-range-m-s2", "9.0",
        "--gyro-scale", "1.1", "1", "1", "--gyro-bias", "0", "0.5", "0",
        "--gyro-misalignment", "0", "0", "0.1", "--gyro-step-rad-s", "0.001",
        "--accel-scale", "1", "1", "1.2", "--accel-bias", "0.3", "0", "0",
        "--accel-misalignment", "0", "0", "0.1", "--accel-step-m-s2", "0.01",
    ) == 0  # fmt: skip
    right, wrong = read_imu(plain), read_imu(faulty)
    at = np.searchsorted(right.time_ns, wrong.time_ns - 20_000_000)
    assert np.array_equal(right.time_ns[at] + 20_000_000, wrong.time_ns)
    assert 0.8 < len(wrong) / len(right) < 0.98
    rate, force = right.angular_rate_rad_s[at], right.specific_force_m_s2[at]
    expected = rate * [1.1, 1.0, 1.0] + 0.1 * np.outer(rate[:, 1], [0, 0, 1]) + [0, 0.5, 0]
    np.testing.assert_allclose(wrong.angular_rate_rad_s, expected, atol=5.01e-4)
    felt = force * [1.0, 1.0, 1.2] + 0.1 * np.outer(force[:, 1], [0, 0, 1]) + [0.3, 0, 0]
    np.testing.assert_allclose(wrong.specific_force_m_s2, np.clip(felt, -9, 9), atol=5.01e-3)


def test_a_cameras_poses_give_the_imu_bolted_to_it(moving: Path, tmp_path: Path) -> None:
    """A quarter turn about z and an arm: the IMU's x axis is the camera's y."""
    plain, bolted = tmp_path / "plain.csv", tmp_path / "bolted.csv"
    half = 0.5**0.5
    assert run("simulate-imu", moving, "-o", plain, "--noise", "none") == 0
    extrinsics = ["--imu-from-poses", "0", "0", "0", "0", "0", half, half]
    assert run("simulate-imu", moving, "-o", bolted, "--noise", "none", *extrinsics) == 0
    camera, imu = read_imu(plain), read_imu(bolted)
    x, y, z = camera.angular_rate_rad_s.T
    np.testing.assert_allclose(imu.angular_rate_rad_s, np.stack([-y, x, z], axis=-1), atol=1e-12)


def test_bad_extrinsics_and_noise_are_refused_in_one_line(
    moving: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "imu.csv"
    assert run("simulate-imu", moving, "-o", out, "--imu-from-poses", *"0001112") == 1
    assert "--imu-from-poses: expected a unit quaternion" in capsys.readouterr().err
    assert run("simulate-imu", moving, "-o", out, "--noise", tmp_path / "no.yaml") == 1
    assert "no.yaml: the file is missing" in capsys.readouterr().err
    assert run("simulate-imu", moving, "-o", out, "--dropped", "2") == 1
    assert "dropped_share: expected a share in [0, 1)" in capsys.readouterr().err
    assert not out.exists()


def test_troubles_of_the_sensor_reach_the_file(moving: Path, tmp_path: Path) -> None:
    """Each alone against the stream without it; what each does is tested with the simulator."""
    noise = tmp_path / "noise.yaml"
    noise.write_text(
        "gyroscope_noise_density: 1.0e-3\ngyroscope_random_walk: 1.0e-4\n"
        "accelerometer_noise_density: 1.0e-2\naccelerometer_random_walk: 1.0e-3\n"
    )
    spectrum = tmp_path / "rotors.csv"
    spectrum.write_text("50,0,0,0,0,0,0\n60,0,0,0,1,1,1\n70,0,0,0,0,0,0\n")
    plain = tmp_path / "plain.npz"
    assert run("simulate-imu", moving, "-o", plain, "--noise", "none") == 0
    right = read_imu(plain)
    for options, force_alone in [
        (["--gyro-turn", "0.1", "0", "0"], False),
        (["--gyro-g-sensitivity", "0.1", "0", "0"], False),
        (["--gyro-flicker", "0.1", "0", "0"], False),
        (["--accel-flicker", "0", "0.1", "0"], True),
        (["--warming-k", "9", "--warming-time-s", "2", "--gyro-bias-per-k", *"111"], False),
        (["--warming-k", "9", "--accel-bias-per-k", *"111"], True),
        (["--warming-k", "9", "--gyro-scale-per-k", *"111"], False),
        (["--warming-k", "9", "--accel-scale-per-k", *"111"], True),
        (["--gyro-lowpass-hz", "5"], False),
        (["--accel-lowpass-hz", "5"], True),
        (["--gyro-delay-s", "0.1"], False),
        (["--accel-delay-s", "0.1"], True),
        (["--vibration", str(spectrum)], True),
    ]:
        out = tmp_path / "troubled.npz"
        assert run("simulate-imu", moving, "-o", out, "--noise", "none", *options) == 0
        wrong = read_imu(out)
        same_rate = np.array_equal(wrong.angular_rate_rad_s, right.angular_rate_rad_s)
        same_force = np.array_equal(wrong.specific_force_m_s2, right.specific_force_m_s2)
        assert (same_rate, same_force) == (force_alone, not force_alone), options
        assert np.array_equal(wrong.time_ns, right.time_ns)
    out = tmp_path / "jitter.npz"
    given = ["simulate-imu", moving, "-o", out, "--noise"]
    assert run(*given, "none", "--stamp-jitter-s", "0.001") == 0
    assert np.std(read_imu(out).time_ns - right.time_ns) == pytest.approx(1e6, rel=0.1)
    assert run(*given, noise, noise, noise) == 0
    by_axis = read_imu(out)
    assert run(*given, noise) == 0
    assert np.array_equal(by_axis.angular_rate_rad_s, read_imu(out).angular_rate_rad_s)


def test_a_stream_is_the_same_as_csv_and_npz(moving: Path, tmp_path: Path) -> None:
    for name in ("imu.csv", "imu.npz"):
        assert run("simulate-imu", moving, "-o", tmp_path / name, "--rate-hz", "500") == 0
    text, arrays = read_imu(tmp_path / "imu.csv"), read_imu(tmp_path / "imu.npz")
    assert np.array_equal(text.time_ns, arrays.time_ns)
    assert np.array_equal(text.angular_rate_rad_s, arrays.angular_rate_rad_s)
    assert np.array_equal(text.specific_force_m_s2, arrays.specific_force_m_s2)


def test_vibration_is_learnt_from_a_recording(
    moving: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    standing = tmp_path / "standing.tum"
    still = Trajectory(1_000_000_000 * np.arange(61), Motor.identity((61,)))
    write_trajectory(still, standing)
    shaken, again = tmp_path / "shaken.npz", tmp_path / "again.npz"
    spectrum = tmp_path / "rotors.csv"
    spectrum.write_text("20,0,0,0,0,0,0\n40,0,0,0,0.01,0.01,0.04\n60,0,0,0,0,0,0\n")
    given = ["simulate-imu", standing, "--noise", "none", "-o"]
    assert run(*given, shaken, "--vibration", spectrum) == 0
    assert run(*given, again, "--seed", "1", "--vibration-of", shaken) == 0
    expected = np.sqrt([0.2, 0.2, 0.8])
    for file in (shaken, again):
        felt = np.std(read_imu(file).specific_force_m_s2, axis=0)
        np.testing.assert_allclose(felt, expected, rtol=0.15)
    assert run(*given, again, "--vibration-of", shaken, "--vibration-above-hz", "100") == 1
    assert "above_hz: expected from 0 to 100 Hz" in capsys.readouterr().err
    spectrum.write_text("20,0,0,0,0,0,0\n10,0,0,0,1,1,1\n")
    assert run(*given, again, "--vibration", spectrum) == 1
    assert "rotors.csv: VibrationSpectrum.frequency_hz: expected" in capsys.readouterr().err
    assert run(*given, again, "--noise", "a.yaml", "b.yaml") == 1
    assert "--noise: expected one file, or one for each axis, got 2" in capsys.readouterr().err


def test_allan_finds_the_noise_that_was_simulated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    still, noise, stream = (tmp_path / name for name in ("still.tum", "imu.yaml", "imu.csv"))
    poses = Motor(np.tile(Motor.identity().coefficients, (2, 1)))
    write_trajectory(Trajectory(np.array([0, 400_000_000_000]), poses, child="imu"), still)
    noise.write_text(
        "gyroscope_noise_density: 2.0e-4\ngyroscope_random_walk: 1.0e-4\n"
        "accelerometer_noise_density: 3.0e-3\naccelerometer_random_walk: 2.0e-3\n"
    )
    arguments = ["--knots-s", "100", "--rate-hz", "50", "--noise", noise]
    assert run("simulate-imu", still, "-o", stream, *arguments) == 0
    plot = tmp_path / "allan.svg"
    assert run("allan", stream, "--json", "--plot", plot) == 0
    found = json.loads(capsys.readouterr().out)
    truth = ImuNoise.load(noise)
    assert found["gyroscope_noise_density"] == pytest.approx(2e-4, rel=0.03)
    assert found["gyroscope_random_walk"] == pytest.approx(truth.gyro_walk_rad_s2_rthz, rel=0.2)
    assert found["accelerometer_noise_density"] == pytest.approx(3e-3, rel=0.05)
    assert found["accelerometer_random_walk"] == pytest.approx(2e-3, rel=0.2)
    assert found["duration_s"] == pytest.approx(400.0)
    assert len(found["gyro_walk_deviation_rad_s2_rthz"]) == 3
    drawing = plot.read_text()
    assert drawing.startswith("<svg")
    assert "--ink:#222222" in drawing
    assert "Allan deviation (rad/s)" in drawing
    assert run("allan", stream) == 0
    table = capsys.readouterr().out
    assert "accelerometer_random_walk: " in table
    assert table.count("±") == 19
    # what it prints is a noise file
    (tmp_path / "found.yaml").write_text(table[table.index("gyroscope_noise_density") :])
    assert ImuNoise.load(tmp_path / "found.yaml").gyro_density_rad_s_rthz == pytest.approx(
        found["gyroscope_noise_density"], rel=1e-6
    )


def test_allan_refuses_what_is_no_stream(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "short.csv"
    file.write_text("0,0,0,0,0,0,9.81\n5000000,0,0,0,0,0,9.81\n")
    assert run("allan", file) == 1
    assert "expected at least 100 samples, got 2" in capsys.readouterr().err
