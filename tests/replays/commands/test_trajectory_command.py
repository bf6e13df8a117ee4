"""`motorcade trajectory` beside `evo_traj`, option by option; its own edits; what it refuses."""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from evo import EvoException
from evo.core import trajectory as evo_trajectory

from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.replays.cli.main import main
from motorcade.replays.files.trajectories import even_stamps, read_trajectory, write_trajectory
from motorcade.replays.files.transforms import read_transform
from tests.replays.readers.bag_poses import Messages, write_messages

with warnings.catch_warnings():
    warnings.simplefilter("ignore", ResourceWarning)  # of a file that evo leaves open
    from evo.cli import traj as evo_traj
    from evo.cli.traj_parser import parser as evo_parser

Words = Sequence[str]
# What both can do, as evo's options and ours.
THINNED: list[tuple[Words, Words]] = [
    ((), ()),
    (("--downsample", "150"), ("--downsample", "150")),
    (("--motion_filter", "0.1", "5"), ("--motion-filter", "0.1", "5")),
]
ALIGNED: list[tuple[Words, Words]] = [
    ((), ()),
    (("--sync",), ("--sync",)),
    (("-a",), ("--align", "se3", "--sync")),
    (("-s",), ("--align", "scale", "--sync")),
    (("-a", "-s"), ("--align", "sim3", "--sync")),
    (("-a", "--n_to_align", "20"), ("--align", "se3", "--n-to-align", "20", "--sync")),
    (("--align_origin",), ("--align", "origin", "--sync")),
    (("-s", "--align_origin"), ("--align", "scaled_origin", "--sync")),
]
PAIRED: list[tuple[Words, Words]] = [
    ((), ()),
    (("--sync_method", "interpolation"), ("--interpolate",)),
    (
        ("--t_offset", "0.004", "--t_max_diff", "0.02"),
        ("--offset-s", "0.004", "--max-difference-s", "0.02"),
    ),
]
MOVED: list[tuple[Words, Words]] = [
    ((), ()),
    (("--transform_left", "T.json"), ("--transform-left", "T.json")),
    (
        ("--transform_left", "T.txt", "--invert_transform"),
        ("--transform-left", "T.txt", "--invert-transform"),
    ),
    (("--transform_right", "T.npy"), ("--transform-right", "T.npy")),
    (
        ("--transform_right", "T.json", "--propagate_transform"),
        ("--transform-right", "T.json", "--propagate"),
    ),
]
FLAT: list[tuple[Words, Words]] = [
    ((), ()),
    *(((("--project_to_plane", one), ("--project", one))) for one in ("xy", "xz", "yz")),
]
EVERY = list(product(THINNED, ALIGNED, PAIRED, MOVED, FLAT))
"""All combinations; those that only one of both takes are left out below."""


def taken(combination: Sequence[tuple[Words, Words]]) -> bool:
    """Whether pairs are asked for where it is said how they are made."""
    _, (align, _), (pair, _), _, _ = combination
    return bool(align) or not pair


def path(rng: np.random.Generator, count: int = 300, rate_hz: float = 30.0) -> Trajectory:
    """A smooth path that turns and climbs."""
    t = np.arange(count) / rate_hz
    place = np.stack([np.cos(t), np.sin(t), 0.3 * t], axis=1) + 0.01 * rng.standard_normal(
        (count, 3)
    )
    turn = np.stack([0.2 * np.sin(t), 0.1 * np.cos(3 * t), t], axis=1)
    start_ns = 1_305_031_098_665_900_000
    return Trajectory(
        even_stamps(count, rate_hz) + start_ns, Motor.from_euler_translation(turn, place)
    )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> Path:
    """An estimate, its ground truth, and a transform in three kinds of file; the current folder."""
    monkeypatch.chdir(tmp_path)
    true = path(rng)
    write_trajectory(true, "true.txt")
    off = Motor.from_euler_translation([0.3, -0.2, 0.1], [1.0, 2.0, 3.0])
    late = Trajectory(true.time_ns[5::2] + 2_000_000, true.motors[5::2])
    write_trajectory(late.transformed_by(off), "estimate.txt")
    write_transforms(tmp_path)
    (tmp_path / "more").mkdir()
    write_trajectory(true, "more/true.txt")
    return tmp_path


def write_transforms(folder: Path) -> Motor:
    made = Motor.from_euler_translation([0.02, 0.01, 0.3], [0.1, -0.2, 0.05])
    (w, *vector), place = (one.tolist() for one in made.as_quaternion_translation())
    names = ("qw", "qx", "qy", "qz", "x", "y", "z")
    given = dict(zip(names, (w, *vector, *place), strict=True))
    (folder / "T.json").write_text(json.dumps(given))
    np.savetxt(folder / "T.txt", made.as_matrix())
    np.save(folder / "T.npy", made.as_matrix())
    return made


def evos(command: str, words: Sequence[str], stem: str) -> np.ndarray:
    """What evo_traj saves: stamps, positions, quaternions xyzw; of KITTI files the matrices."""
    saved = "--save_as_kitti" if command == "kitti" else "--save_as_tum"
    evo_traj.run(evo_parser().parse_args([command, *words, saved, "--no_warnings", "--silent"]))
    return np.loadtxt(f"{stem}{'.kitti' if command == 'kitti' else '.tum'}", ndmin=2)


def assert_as_evo(ours: Trajectory, rows: np.ndarray) -> None:
    """The same to 1e-6; of rows with equal stamps evo keeps all, we the first."""
    rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
    assert len(ours) == len(rows)
    np.testing.assert_allclose(1e-9 * ours.time_ns, rows[:, 0], rtol=0, atol=1e-6)
    poses = evo_trajectory.PosePath3D(rows[:, 1:4], np.roll(rows[:, 4:], 1, axis=1)).poses_se3
    size = max(1.0, np.abs(rows[:, 1:4]).max())
    np.testing.assert_allclose(ours.motors.as_matrix(), np.array(poses), rtol=0, atol=1e-6 * size)


def compare(combination: Sequence[tuple[Words, Words]], estimate: str, reference: str) -> None:
    theirs = [word for words, _ in combination for word in words]
    mine = [word for _, words in combination for word in words]
    needed = any(words for words, _ in combination[1:2])
    there = ["--ref", reference] if needed else []
    here = ["--reference", reference] if needed else []
    ours = ["trajectory", estimate, "-o", "ours.tum", *here, *mine]
    try:
        rows = evos("tum", [estimate, *there, *theirs], Path(estimate).stem)
    except EvoException:  # too few pairs
        assert main(ours) == 1
        return
    assert main(ours) == 0
    assert_as_evo(read_trajectory("ours.tum"), rows)


ONE_EACH = [
    one
    for one in EVERY
    if taken(one) and sum(bool(theirs) for theirs, _ in one) <= (2 if one[1][0] == ("-a",) else 1)
]


@pytest.mark.parametrize(
    "combination", ONE_EACH, ids=lambda one: " ".join(w for p in one for w in p[0])
)
def test_each_option_is_evos(combination: Sequence[tuple[Words, Words]], folder: Path) -> None:
    compare(combination, "estimate.txt", "true.txt")


def once_each(file: Path) -> str:
    """A copy without rows whose stamp the row before has, which evo keeps and we do not."""
    lines = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    stamps = [float(line.split()[0]) for line in lines]
    kept = [line for line, new in zip(lines, [1.0, *np.diff(stamps)], strict=True) if new]
    Path(file.name).write_text("\n".join(kept) + "\n")
    return file.name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimate", "reference"),
    [
        ("freiburg1_xyz-rgbdslam.txt", "freiburg1_xyz-groundtruth.txt"),
        ("freiburg1_xyz-rgbdslam_drift.txt", "freiburg1_xyz-groundtruth.txt"),
        ("freiburg1_xyz-ORB_kf_mono.txt", "freiburg1_xyz-groundtruth.txt"),
        ("fr2_desk_ORB.txt", "fr2_desk_groundtruth.txt"),
        ("fr2_desk_ORB_kf_mono.txt", "fr2_desk_groundtruth.txt"),
    ],
)
def test_combinations_of_options_are_evos_on_real_paths(
    estimate: str, reference: str, data_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sixty combinations, drawn anew for each path: all pairs of options come about."""
    monkeypatch.chdir(tmp_path)
    write_transforms(tmp_path)
    files = [once_each(data_dir / "trajectories" / name) for name in (estimate, reference)]
    known = [one for one in EVERY if taken(one)]
    rng = np.random.default_rng(len(estimate))
    for index in rng.choice(len(known), 60, replace=False):
        compare(known[index], *files)


def test_kitti_files_are_edited_as_evo_does(folder: Path, rng: np.random.Generator) -> None:
    write_trajectory(read_trajectory("true.txt"), "true_kitti.txt", "kitti")
    moved = read_trajectory("true.txt").transformed_by(Motor.random(rng))
    write_trajectory(moved, "moved.txt", "kitti")
    for theirs, mine in (*ALIGNED[2:], *MOVED, *FLAT):
        needed = any(theirs == one for one, _ in ALIGNED)
        there = ["--ref", "true_kitti.txt"] if needed and theirs else []
        here = ["--reference", "true_kitti.txt"] if needed and theirs else []
        rows = evos("kitti", ["moved.txt", *there, *theirs], "moved")
        assert (
            main(["trajectory", "moved.txt", "-o", "o.kitti", "--rate-hz", "10", *here, *mine]) == 0
        )
        ours = read_trajectory("o.kitti", rate_hz=10.0).motors.as_matrix()[:, :3].reshape(-1, 12)
        np.testing.assert_allclose(ours, rows, rtol=0, atol=1e-6)


def test_merged_files_are_evos(folder: Path) -> None:
    whole = read_trajectory("true.txt")
    write_trajectory(whole[::2], "even.txt")
    write_trajectory(whole[1::2], "odd.txt")
    rows = evos("tum", ["odd.txt", "even.txt", "--merge", "--t_offset", "1.5"], "merged_trajectory")
    words = ["trajectory", "odd.txt", "even.txt", "--merge", "--offset-s", "1.5", "-o", "m.tum"]
    assert main(words) == 0
    assert_as_evo(read_trajectory("m.tum"), rows)
    assert len(rows) == len(whole)


@pytest.mark.parametrize(
    ("bag", "command", "topics"),
    [
        pytest.param(
            "ROS_example.bag",
            "bag",
            ("groundtruth", "ORB-SLAM", "S-PTAM"),
            marks=pytest.mark.slow,
        ),
        ("nav2_turtlebot.mcap", "mcap", ("/odom", "/amcl_pose")),
    ],
)
def test_topics_of_real_bags_are_saved_as_evo_saves_them(
    bag: str,
    command: str,
    topics: Words,
    data_dir: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    file = str(data_dir / "replays" / "bags" / bag)
    assert main(["trajectory", file, "--all-topics", "-o", "ours", "--format", "tum"]) == 0
    assert len(list(Path("ours").iterdir())) == len(topics)
    for topic in topics:
        stem = topic.strip("/")
        assert_as_evo(read_trajectory(f"ours/{stem}.tum"), evos(command, [file, topic], stem))


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


def test_transforms_with_a_scale_move_positions(folder: Path) -> None:
    given = read_trajectory("true.txt")
    rigid = read_transform(Path("T.json"))
    assert isinstance(rigid, Motor)
    grown = Similarity.from_motor_scale(rigid, 2.0)
    told = json.loads(Path("T.json").read_text()) | {"scale": 2.0}
    Path("S.json").write_text(json.dumps(told))
    np.savetxt("S.txt", grown.as_matrix())
    np.save("S.npy", np.asfortranarray(grown.as_matrix()))
    for name in ("S.json", "S.txt", "S.npy"):
        assert main(["trajectory", "true.txt", "--transform-left", name, "-o", "o.tum"]) == 0
        found = read_trajectory("o.tum").motors
        expected = grown.apply(given.motors.translation_m)
        np.testing.assert_allclose(found.translation_m, expected, atol=1e-12)
        turns = (rigid.rotor @ given.motors.rotor).as_matrix()
        np.testing.assert_allclose(found.rotor.as_matrix(), turns, atol=1e-12)


def _npy(shape: str, kind: str = "<f8") -> bytes:
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head.encode() + bytes(128)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "the file is empty"),
        (b"1 2 3", "expected 16 numbers, got 3"),
        (b"a b", "expected 16 numbers or JSON"),
        (b" ".join([b"nan"] * 16), "expected a rotation times a scale"),
        (b" ".join([b"1"] * 16), "expected a rotation times a scale"),
        (b"1 0 0 0 0 2 0 0 0 0 1 0 0 0 0 1", "expected a rotation"),
        (b"1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1", "expected a rotation times a scale"),
        (b"1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "expected the last row 0 0 0 1"),
        (b"{" * 60_000, "expected JSON of numbers"),
        (b'{"a":' * 10_000, "expected JSON of numbers"),
        (b'{"x": 1}', "expected JSON of numbers"),
        (b'{"x":1,"y":1,"z":NaN,"qx":0,"qy":0,"qz":0,"qw":1}', "expected a unit quaternion and"),
        (b'{"x":1,"y":1,"z":1,"qx":0,"qy":0,"qz":0,"qw":2}', "expected a unit quaternion"),
        (b'{"x":1,"y":1,"z":1,"qx":0,"qy":0,"qz":0,"qw":1,"scale":-1}', "expected a scale"),
        (_npy("(4, 4)", "|O"), "expected 4 by 4 numbers"),
        (_npy("(1000000000000,)"), "expected 4 by 4 numbers"),
        (_npy("(4, 4"), "expected 4 by 4 numbers"),
        (_npy("(4, 4)"), "expected a rotation times a scale"),
        (_npy("(4, 4)")[:200], "expected 4 by 4 numbers"),
        (b"\x93NUMPY\x09\x00", "expected 4 by 4 numbers"),
        (b"1 " * 40_000, "at most 65536 bytes"),
    ],
)
def test_transforms_that_are_none_are_refused(
    folder: Path, content: bytes, problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("bad").write_bytes(content)
    assert main(["trajectory", "true.txt", "--transform-left", "bad"]) == 1
    told = capsys.readouterr().err
    assert problem in told
    assert told.startswith("motorcade: bad")
    assert told.count("\n") == 1


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
