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
from motorcade.ga import Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from tests.replays.readers.bag_poses import TF, Messages, write_messages

START_NS = 1_700_000_000_123_456_789
POSE = "geometry_msgs/msg/PoseStamped"
TRANSFORM = "geometry_msgs/msg/TransformStamped"


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
        ("", ["--method", "kalman"], "unknown 'kalman'; known here: auto, .* and [0-9]+ more"),
        ("", ["--method", "gausian"], "--method: unknown 'gausian'; did you mean gaussian"),
        (
            "",
            ["--set", "sigma_s=1"],
            "names of auto: smoothness, noise_m, noise_rad, max_move_m, max_move_rad, lag_s; got",
        ),
        ("", ["--method", "gaussian", "--set", "sigma=1"], "sigma_s, truncate, order; got"),
        ("", ["--method", "gaussian", "--set", "sigma_s=wide"], "sigma_s: expected float, got"),
        ("", ["--method", "gaussian", "--set", "sigma_s=-1"], "sigma_s: expected a positive"),
        ("", ["--set", "smoothness=11"], "smoothness: expected -10 to 10"),
        ("", ["--set", "lag_s=0.1", "--set", "smoothness=1"], "lag_s: expected none beside"),
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


@pytest.fixture
def bag(tmp_path: Path, rng: np.random.Generator) -> tuple[Path, Trajectory]:
    """A bag of odometry, of poses, and of the transforms map, odom, base; each the same path."""
    noisy = Gaussian(0.005, 0.01).apply(MOTIONS["stop_and_go"].sampled(30.0, 1.0), rng)
    path = Trajectory(noisy.time_ns + START_NS, noisy.motors, "map", "base")
    wxyz, position_m = path.motors.as_quaternion_translation()
    made, sent = Messages(ros1=True), []
    for stamp, row in zip(path.time_ns.tolist(), np.column_stack([position_m, wxyz]), strict=True):
        for topic, kind in (("/odom", "nav_msgs/msg/Odometry"), ("/pose", POSE)):
            sent.append((topic, stamp, made.pose(kind, stamp, row, ("map", "base"))))
        links = [made.pose(TRANSFORM, stamp, row, ("map", "base"))]
        sent.append(("/tf", stamp, made.make(TF, transforms=links)))
    return write_messages(tmp_path, "bag", sent), path


@pytest.mark.parametrize("named", ["/odom", "/pose", "map/base"])
def test_what_a_bag_holds_is_smoothed_as_a_file_is(
    named: str, bag: tuple[Path, Trajectory], capsys: pytest.CaptureFixture[str]
) -> None:
    file, path = bag
    outs = [file.with_name(f"{number}.tum") for number in range(2)]
    assert run("smooth", f"{file}:{named}", "-o", outs[0], "--method", "gaussian") == 0
    assert run("smooth", file, "--topic", named, "-o", outs[1], "--method", "gaussian") == 0
    assert outs[0].read_bytes() == outs[1].read_bytes()
    found, expected = read_trajectory(outs[0]), smooth(path, "gaussian")
    np.testing.assert_array_equal(found.time_ns, expected.time_ns)
    assert np.abs(found.motors.local(expected.motors)).max() < 1e-12


def test_of_several_topics_a_bag_says_which(
    bag: tuple[Path, Trajectory], capsys: pytest.CaptureFixture[str]
) -> None:
    file, _ = bag
    assert run("smooth", file, "-o", file.with_name("out.tum")) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert all(one in said for one in ("/odom", "/pose", "map/base"))
    assert run("smooth", file, "--topic", "/odometry", "-o", file.with_name("out.tum")) == 1
    assert "/odom" in capsys.readouterr().err


def test_many_bodies_come_as_they_were(
    bag: tuple[Path, Trajectory], poses: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a folder, by their names: TUM, EuRoC and KITTI as they came, topics of bags as TUM."""
    file, _ = bag
    path = read_trajectory(poses)
    write_trajectory(path, poses.with_name("euroc.csv"))
    write_trajectory(path, poses.with_name("road.kitti"))
    inputs = [poses, poses.with_name("euroc.csv"), poses.with_name("road.kitti"), file]
    options = ["--all-topics", "--rate-hz", "30", "--method", "gaussian"]
    out = poses.with_name("smooth")
    assert run("smooth", *inputs, *options, "-o", out) == 0
    names = sorted(one.name for one in out.iterdir())
    assert names == ["euroc.csv", "odom.tum", "pose.tum", "poses.tum", "road.kitti"]
    said = capsys.readouterr().out
    assert f"{file}:/odom: in {out}/odom.tum, as TUM: bags and logs are only read\n" in said
    assert f"{poses}: in {out}/poses.tum\n" in said
    by_tum, by_euroc = (read_trajectory(out / name) for name in ("poses.tum", "euroc.csv"))
    by_kitti = read_trajectory(out / "road.kitti", rate_hz=30.0)
    for other in (by_euroc, by_kitti):
        assert np.abs(by_tum.motors.local(other.motors)).max() < 1e-9
    assert run("smooth", *inputs, *options, "-o", out, "--report") == 0
    reports = json.loads(capsys.readouterr().out)
    assert set(reports) == {*map(str, inputs[:3]), f"{file}:/odom", f"{file}:/pose"}
    assert reports[str(poses)]["method"] == "gaussian"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["IN", "IN", "-o", "two"], "poses.tum: expected each trajectory once, got it twice"),
        (["IN", "other.tum", "-o", "two.tum"], "two.tum: expected a folder for 2 trajectories"),
        (["IN", "a/IN", "-o", "two"], "poses.tum: expected one trajectory, got"),
        (["IN", "-o", "out.bag"], "out.bag: bags are only read; expected a name ending in .tum"),
        (["IN", "--topic", "/odom", "-o", "o.tum"], "--topic /odom: expected a bag without a"),
        (["gone.bag:/odom", "-o", "o.tum"], "gone.bag: the file is missing"),
    ],
)
def test_inputs_and_outputs_that_do_not_fit_are_told(
    arguments: list[str],
    message: str,
    poses: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(poses.parent)
    Path("a").mkdir()
    for name in ("other.tum", "a/poses.tum"):
        Path(name).write_bytes(poses.read_bytes())
    before = sorted(Path().rglob("*"))
    assert run("smooth", *(one.replace("IN", "poses.tum") for one in arguments)) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert message in said, said
    assert sorted(Path().rglob("*")) == before


@pytest.mark.parametrize(
    "arguments",
    [
        ["poses.tum", "-o", "poses.tum"],
        ["poses.tum", "-o", "linked.tum"],
        ["poses.tum", "-o", "."],
        ["a/other.tum", "poses.tum", "-o", "."],
        ["a/poses.tum", "other.tum", "-o", "."],
        ["flight.bag:/odom", "-o", "flight.bag", "--format", "tum"],
    ],
)
def test_what_is_read_is_not_written_over(
    arguments: list[str],
    poses: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(poses.parent)
    Path("a").mkdir()
    for name in ("other.tum", "a/other.tum", "a/poses.tum", "flight.bag"):
        Path(name).write_bytes(poses.read_bytes())
    Path("linked.tum").symlink_to("poses.tum")
    before = {one: one.read_bytes() for one in Path().rglob("*.*")}
    assert run("smooth", *arguments, "--method", "gaussian") == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "this is one of the inputs" in said, said
    assert {one: one.read_bytes() for one in Path().rglob("*.*")} == before


@pytest.mark.parametrize(
    ("name", "topic"),
    [
        ("ROS_example.bag", "S-PTAM"),
        ("nav2_turtlebot.mcap", "/odom"),
        ("nav2_turtlebot.mcap", "odom/base_link"),
        ("tf_example", "odom/base_footprint"),
    ],
)
def test_real_bags(name: str, topic: str, data_dir: Path, tmp_path: Path) -> None:
    bag = data_dir / "replays" / "bags" / name
    out = tmp_path / "out.tum"
    assert run("smooth", f"{bag}:{topic}", "-o", out, "--method", "local_polynomial") == 0
    raw = read_trajectory(f"{bag}:{topic}")
    np.testing.assert_array_equal(read_trajectory(out).time_ns, raw.time_ns)


def test_smoothing_needs_numpy_alone(poses: Path) -> None:
    """Neither scipy nor CasADi are imported while there are no outliers."""
    program = (
        "import sys; from motorcade.replays.cli import main; "
        f"main(['smooth', {str(poses)!r}, '-o', {str(poses.with_name('o.tum'))!r}]); "
        "assert not {'scipy', 'casadi'} & set(sys.modules), 'heavy modules imported'"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
