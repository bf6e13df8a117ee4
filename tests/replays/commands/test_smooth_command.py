"""`motorcade smooth`: every method by name, what auto picked, and one line for every bad input."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import METHODS, method_parameters, smooth
from motorcade.replays.cli import main
from motorcade.replays.files.trajectories import read_trajectory, write_trajectory


@pytest.fixture
def poses(tmp_path: Path, rng: np.random.Generator) -> Path:
    truth = MOTIONS["stop_and_go"].sampled(30.0, 3.0)
    file = tmp_path / "poses.tum"
    write_trajectory(Gaussian(0.005, 0.01).apply(truth, rng), file)
    return file


def run(*arguments: str | Path) -> int:
    return main([str(argument) for argument in arguments])


@pytest.mark.parametrize("method", METHODS)
def test_every_method_smooths_a_file_as_the_library_does(method: str, poses: Path) -> None:
    out = poses.with_name("out.tum")
    assert run("smooth", poses, "-o", out, "--method", method, "--representation", "rotor") == 0
    expected = smooth(read_trajectory(poses), method, "rotor")
    found = read_trajectory(out)
    np.testing.assert_array_equal(found.time_ns, expected.time_ns)
    apart = (found.poses.inverse() @ expected.poses).as_twist()
    assert np.abs(apart).max() < 1e-12


def test_parameters_are_set_by_name(poses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = poses.with_name("out.tum")
    setting = ["--set", "sigma_s=0.05", "--set", "order=2"]
    assert run("smooth", poses, "-o", out, "--method", "gaussian", *setting) == 0
    expected = smooth(read_trajectory(poses), "gaussian", sigma_s=0.05, order=2)
    apart = (read_trajectory(out).poses.inverse() @ expected.poses).as_twist()
    assert np.abs(apart).max() < 1e-12
    assert capsys.readouterr().out == ""


def test_auto_says_what_it_picked(poses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = poses.with_name("out.tum")
    assert run("smooth", poses, "-o", out) == 0
    said = capsys.readouterr().out
    assert said.startswith("auto: splines on ")
    assert "mm and" in said
    assert run("smooth", poses, "-o", out, "--report") == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["smoothed_linear_jitter_m_s2"] < figures["raw_linear_jitter_m_s2"]
    assert figures["representation"] in ("rotor", "motor")
    assert figures["noise_m"] == pytest.approx(0.005, rel=0.4)


def test_the_list_names_every_method_and_parameter(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        run("smooth", "--list")
    assert ended.value.code == 0
    said = capsys.readouterr().out
    for method in METHODS:
        assert f"  {method} " in said
        for name in method_parameters(method):
            assert f"{name}=" in said


def edited(poses: Path, edit: str) -> Path:
    """The file, which opens with a comment, with its fifth line changed in one way."""
    lines = poses.read_text().splitlines()
    fields = lines[4].split()
    if edit == "nan":
        fields[2] = "nan"
    elif edit == "quaternion":
        fields[4:] = ["0.9", "0.9", "0.1", "0.1"]
    elif edit == "backwards":
        fields[0] = lines[1].split()[0]
    elif edit == "equal":
        fields[0] = lines[3].split()[0]
    lines[4] = " ".join(fields)
    if edit == "short":
        lines = lines[:4]
    poses.write_text("\n".join(lines) + "\n")
    return poses


@pytest.mark.parametrize(
    ("edit", "arguments", "message"),
    [
        ("nan", [], r"line 5, ty: expected a finite number, got nan"),
        ("quaternion", [], r"line 5: expected a unit quaternion"),
        ("backwards", [], r"line 5: expected stamps in increasing order"),
        ("short", [], "at least 16 poses to tell noise from motion, got 3"),
        ("short", ["--method", "savitzky_golay", "--set", "order=4"], "at least 5 poses, got 3"),
        ("", ["--method", "exponential", "--set", "cutoff_hz=16"], "below half the sampling rate"),
        ("", ["--method", "kalman"], "--method: unknown 'kalman'; known here: auto, .* and 1 more"),
        ("", ["--method", "gausian"], "--method: unknown 'gausian'; did you mean gaussian"),
        (
            "",
            ["--set", "sigma_s=1"],
            "--set: auto takes no parameters; choose another method first",
        ),
        ("", ["--method", "gaussian", "--set", "sigma=1"], "sigma_s, truncate, order; got"),
        ("", ["--method", "gaussian", "--set", "sigma_s=wide"], "sigma_s: expected float, got"),
        ("", ["--method", "gaussian", "--set", "sigma_s=-1"], "sigma_s: expected a positive"),
        ("", ["--representation", "matrix"], "unknown 'matrix'; did you mean motor"),
    ],
)
def test_bad_input_is_told_in_one_line(
    edit: str,
    arguments: list[str],
    message: str,
    poses: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = poses.with_name("out.tum")
    assert run("smooth", edited(poses, edit), "-o", out, *arguments) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert re.search(message, said), said
    assert not out.exists()


def test_of_equal_stamps_the_first_counts(poses: Path, caplog: pytest.LogCaptureFixture) -> None:
    out = poses.with_name("out.tum")
    assert run("smooth", edited(poses, "equal"), "-o", out, "--method", "gaussian") == 0
    assert "line 5" in caplog.text
    assert len(read_trajectory(out)) == len(poses.read_text().splitlines()) - 2


def test_smoothing_needs_numpy_alone(poses: Path) -> None:
    """Neither scipy nor CasADi are imported while there are no outliers."""
    program = (
        "import sys; from motorcade.replays.cli import main; "
        f"main(['smooth', {str(poses)!r}, '-o', {str(poses.with_name('o.tum'))!r}]); "
        "assert not {'scipy', 'casadi'} & set(sys.modules), 'heavy modules imported'"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
