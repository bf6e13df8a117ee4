"""`motorcade trajectory`: formats, its own edits, figures, plots, bags, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from evo.core import trajectory as evo_trajectory

from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli.main import main
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from tests.replays.readers.bag_poses import Messages, write_messages


def test_formats_are_converted_without_losing_a_digit(folder: Path) -> None:
    given = read_trajectory("true.txt")
    Path("stamps.txt").write_text(
        "".join(f"{one // 10**9}.{one % 10**9:09d}\n" for one in given.time_ns)
    )
    for first, second in (("true.txt", "a.csv"), ("a.csv", "b.kitti"), ("b.kitti", "c.txt")):
        times = ["--times", "stamps.txt"] if first == "b.kitti" else []
        assert main(["trajectory", first, "-o", second, *times]) == 0
    back = read_trajectory("c.txt")
    np.testing.assert_array_equal(back.time_ns, given.time_ns)
    np.testing.assert_allclose(back.motors.as_matrix(), given.motors.as_matrix(), atol=1e-14)
    assert main(["trajectory", "a.csv", "true.txt", "-o", "all", "--format", "euroc"]) == 0
    assert sorted(one.name for one in Path("all").iterdir()) == ["a.csv", "true.csv"]


def test_our_own_edits(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = read_trajectory("true.txt")

    def edited(*words: str) -> Trajectory:
        assert main(["trajectory", "true.txt", "-o", "o.tum", *words]) == 0
        return read_trajectory("o.tum")

    turned = edited("--invert").motors @ given.motors
    np.testing.assert_allclose(turned.as_matrix() - np.eye(4), 0.0, atol=1e-12)
    np.testing.assert_allclose(
        edited("--scale", "0.001").motors.translation_m, 1e-3 * given.motors.translation_m
    )
    middle = edited("--start-s", "1305031100", "--end-s", "1305031101.5")
    assert 40 < len(middle) < 50
    even = edited("--resample-hz", "10")
    assert set(np.diff(even.time_ns)) == {100_000_000}
    np.testing.assert_allclose(
        even.motors.as_matrix(), given.at_rate(10.0).motors.as_matrix(), atol=1e-12
    )
    estimate = read_trajectory("estimate.txt")
    alike = edited("--resample-as", "estimate.txt")
    inside = estimate.time_ns <= given.time_ns[-1]
    np.testing.assert_array_equal(alike.time_ns, estimate.time_ns[inside])
    whole = edited("--reference", "estimate.txt", "--align", "se3", "--max-difference-s", "0.02")
    assert len(whole) == len(given)
    assert not capsys.readouterr().out


def test_figures_are_told_and_written(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trajectory", "true.txt", "--json", "f.json"]) == 0
    told, figures = capsys.readouterr().out, json.loads(Path("f.json").read_text())["true.txt"]
    for key, value in figures.items():
        assert f"{key}  " in told, (key, value)
    given = read_trajectory("true.txt")
    theirs = evo_trajectory.PoseTrajectory3D(
        np.array(given.motors.translation_m),
        np.array(given.motors.rotor.as_quaternion()),
        1e-9 * given.time_ns,
    )
    assert figures["poses"] == theirs.num_poses
    np.testing.assert_allclose(figures["path_length_m"], theirs.path_length)
    stats = theirs.get_statistics()
    for ours, name in (
        ("speed_max_m_s", "v_max (m/s)"),
        ("speed_mean_m_s", "v_avg (m/s)"),
        ("step_max_s", "dt_max (s)"),
    ):
        np.testing.assert_allclose(figures[ours], stats[name], rtol=1e-4)  # evo's stamps are floats
    write_trajectory(given[:1], "one.tum")
    assert main(["trajectory", "one.tum", "--json", "f.json"]) == 0
    assert json.loads(Path("f.json").read_text())["one.tum"]["speed_max_m_s"] is None


def test_plots_are_drawn_the_same_again(folder: Path) -> None:
    words = ["trajectory", "estimate.txt", "--reference", "true.txt", "--align", "origin"]
    for name in ("a.svg", "b.svg", "a.pdf", "a.png"):
        assert main([*words, "--plot", name, "--plot-plane", "xz"]) == 0
    drawn = Path("a.svg").read_bytes()
    assert drawn == Path("b.svg").read_bytes()
    for word in (b"estimate", b"reference", b"yaw", b"z (m)"):
        assert word in drawn
    assert Path("a.pdf").read_bytes().startswith(b"%PDF")
    assert Path("a.png").read_bytes().startswith(b"\x89PNG")


def test_bags_are_listed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = Messages(ros1=False)
    row = np.array([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0])
    pose = made.pose("nav_msgs/msg/Odometry", 10**9, row, ("odom", "base"))
    link = made.pose("geometry_msgs/msg/TransformStamped", 10**9, row, ("odom", "base"))
    sent = [("/odometry", 10**9, pose), ("/tf", 10**9, made.transforms(link))]
    bag = write_messages(folder, "mcap", sent)
    assert main(["trajectory", str(bag)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"{bag}:/odometry  nav_msgs/msg/Odometry, 1 messages",
        f"{bag}:odom/base  frames",
    ]
    assert (
        main(["trajectory", f"{bag}:odom/base", f"{bag}:/odometry", "-o", "all", "--format", "tum"])
        == 0
    )
    assert sorted(one.name for one in Path("all").iterdir()) == ["odom_base.tum", "odometry.tum"]
    assert main(["evaluate", f"{bag}:odom/base", f"{bag}:/odometry"]) == 0
    assert "ape_rmse_m  0" in capsys.readouterr().out


def test_merging_other_frames_is_told(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    made = Messages(ros1=True)
    row = np.array([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0])
    pose = made.pose("nav_msgs/msg/Odometry", 10**9, row, ("odom", "base"))
    bag = write_messages(folder, "bag", [("/o", 10**9, pose)])
    assert main(["trajectory", "true.txt", f"{bag}:/p", "--merge"]) == 1
    assert main(["trajectory", "true.txt", f"{bag}:/o", "--merge", "-o", "o.tum"]) == 0
    assert "poses odom_T_base are merged as if they were world_T_camera" in caplog.text


def test_folded_headings_are_told(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    turn = [[0.0, angle, 0.0] for angle in (0.0, 1.0, 2.0)]
    turned = Motor.from_euler_translation(turn, np.zeros((3, 3)))
    write_trajectory(Trajectory(np.arange(3), turned), "t.tum")
    assert main(["trajectory", "t.tum", "--project", "xz", "-o", "o.tum"]) == 0
    assert "t.tum: 1 of 3 poses face backwards in xz" in caplog.text


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--align", "se3"], "align: expected a reference"),
        (["--sync"], "paired: expected a reference"),
        (["--interpolate"], "interpolate: expected align or paired"),
        (["--propagate"], "propagate: expected a rigid right transform"),
        (["--n-to-align", "4"], "n_to_align: expected align"),
        (["--invert-transform"], "--invert-transform: expected --transform-left"),
        (["--resample-hz", "1", "--resample-as", "true.txt"], "expected a rate or another's"),
        (["--resample-hz", "1e9"], "expected at most"),
        (["--downsample", "0"], "true.txt: downsampled: expected 1 pose or more"),
        (["--start-s", "5e9"], "true.txt: start_s, end_s: expected poses from"),
        (["--offset-s", "1e12"], "true.txt: offset_s: expected at most"),
        (["--scale", "0"], "expected a factor above 0"),
        (["--motion-filter", "-1", "0"], "distance_m: expected 0 or more"),
        (["--plot", "a.gif"], "expected a name ending in .svg, .pdf or .png"),
        (["--format", "tum"], "--format: expected -o"),
        (["-o", "a.xyz"], "expected a name ending in"),
        (["estimate.txt", "-o", "a.tum"], "expected a folder for 2 trajectories"),
        (["true.txt"], "expected each trajectory once"),
        (["more/true.txt", "-o", "all", "--format", "tum"], "expected one trajectory, got"),
        (["--rate-hz", "10"], "only KITTI files lack stamps"),
        (["missing.bag", "--all-topics"], "missing.bag: the file is missing"),
    ],
)
def test_what_makes_no_sense_is_refused(
    folder: Path, words: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["trajectory", "true.txt", *words]) == 1
    told = capsys.readouterr().err
    assert problem in told
    assert told.count("\n") == 1
    assert not list(folder.glob("a.*"))
    assert not (folder / "all").exists()


def test_kitti_without_stamps_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_trajectory(read_trajectory("true.txt"), "true_kitti.txt", "kitti")
    assert main(["trajectory", "true_kitti.txt"]) == 1
    assert "KITTI files hold no stamps" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["true.txt", "-o", "true.txt"],
        ["true.txt", "-o", "linked.tum"],
        ["true.txt", "-o", ".", "--format", "tum"],
        ["copy.txt", "-o", "true.txt", "--reference", "true.txt", "--align", "se3"],
        ["copy.txt", "-o", "true.txt", "--resample-as", "true.txt"],
    ],
)
def test_what_is_read_is_not_written_over(
    words: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("copy.txt").write_bytes(Path("true.txt").read_bytes())
    Path("linked.tum").symlink_to("true.txt")
    Path("true.tum").symlink_to("true.txt")
    before = Path("true.txt").read_bytes()
    assert main(["trajectory", *words]) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "this is one of the inputs" in said, said
    assert Path("true.txt").read_bytes() == before
