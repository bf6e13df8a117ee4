"""`motorcade trajectory` beside `evo_traj`, option by option, on its own files and real ones.

Each of the 1,320 combinations that both take costs evo up to some seconds on a real path. The slow
test walks as many as hold every pair of options, shared out among the paths; the product as it is:

    python -m tests.replays.trajectory.test_beside_evo [ESTIMATE …]
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
from evo import EvoException
from evo.core import trajectory as evo_trajectory

from motorcade.ga import Motor, Trajectory
from motorcade.replays.cli.main import main
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from tests.replays.trajectory.conftest import write_transforms

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
Combination = tuple[tuple[Words, Words], ...]


def taken(combination: Combination) -> bool:
    """Whether pairs are asked for where it is said how they are made."""
    _, (align, _), (pair, _), _, _ = combination
    return bool(align) or not pair


KNOWN = [one for one in product(THINNED, ALIGNED, PAIRED, MOVED, FLAT) if taken(one)]
"""All combinations that both take."""


def pairs_of(combination: Combination) -> set[tuple[object, ...]]:
    """The pairs of options in it, by the place and the words of each."""
    places = [(place, tuple(words)) for place, (words, _) in enumerate(combination)]
    return set(combinations(places, 2))


def every_pair(rng: np.random.Generator) -> Iterator[Combination]:
    """Few combinations that hold every pair of options: next the one with most new ones."""
    drawn = [KNOWN[index] for index in rng.permutation(len(KNOWN))]
    missing = set().union(*map(pairs_of, drawn))
    while missing:
        best = max(drawn, key=lambda one: len(missing & pairs_of(one)))
        missing -= pairs_of(best)
        yield best


def evos(command: str, words: Sequence[str], stem: str) -> np.ndarray:
    """What evo_traj saves: stamps, positions, quaternions xyzw; of KITTI files the matrices."""
    saved = "--save_as_kitti" if command == "kitti" else "--save_as_tum"
    evo_traj.run(evo_parser().parse_args([command, *words, saved, "--no_warnings", "--silent"]))
    return np.loadtxt(f"{stem}{'.kitti' if command == 'kitti' else '.tum'}", ndmin=2)


def apart(ours: Trajectory, rows: np.ndarray) -> float:
    """Largest difference, of a path's size; of rows with equal stamps evo keeps all, we the first.

    Stamps count in seconds.
    """
    rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
    assert len(ours) == len(rows)
    late = np.abs(1e-9 * ours.time_ns - rows[:, 0])
    poses = evo_trajectory.PosePath3D(rows[:, 1:4], np.roll(rows[:, 4:], 1, axis=1)).poses_se3
    size = max(1.0, np.abs(rows[:, 1:4]).max())
    off = np.abs(ours.motors.as_matrix() - np.array(poses)) / size
    return float(max(late.max(), off.max()))


def assert_as_evo(ours: Trajectory, rows: np.ndarray) -> None:
    assert apart(ours, rows) < 1e-6


def compare(combination: Combination, estimate: str, reference: str) -> float | None:
    """How far the two programs' answers are apart; None where both refuse."""
    theirs = [word for words, _ in combination for word in words]
    mine = [word for _, words in combination for word in words]
    needed = bool(combination[1][0])
    there = ["--ref", reference] if needed else []
    here = ["--reference", reference] if needed else []
    ours = ["trajectory", estimate, "-o", "ours.tum", *here, *mine]
    try:
        rows = evos("tum", [estimate, *there, *theirs], Path(estimate).stem)
    except EvoException:  # too few pairs
        assert main(ours) == 1
        return None
    assert main(ours) == 0
    return apart(read_trajectory("ours.tum"), rows)


ONE_EACH = [
    one
    for one in KNOWN
    if sum(bool(theirs) for theirs, _ in one) <= (2 if one[1][0] == ("-a",) else 1)
]


@pytest.mark.parametrize(
    "combination", ONE_EACH, ids=lambda one: " ".join(w for p in one for w in p[0])
)
def test_each_option_is_evos(combination: Combination, folder: Path) -> None:
    assert (compare(combination, "estimate.txt", "true.txt") or 0.0) < 1e-6


def once_each(file: Path) -> str:
    """A copy without rows whose stamp the row before has, which evo keeps and we do not."""
    lines = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    stamps = [float(line.split()[0]) for line in lines]
    kept = [line for line, new in zip(lines, [1.0, *np.diff(stamps)], strict=True) if new]
    Path(file.name).write_text("\n".join(kept) + "\n")
    return file.name


REAL = {
    "freiburg1_xyz-rgbdslam.txt": "freiburg1_xyz-groundtruth.txt",
    "freiburg1_xyz-rgbdslam_drift.txt": "freiburg1_xyz-groundtruth.txt",
    "freiburg1_xyz-ORB_kf_mono.txt": "freiburg1_xyz-groundtruth.txt",
    "fr2_desk_ORB.txt": "fr2_desk_groundtruth.txt",
    "fr2_desk_ORB_kf_mono.txt": "fr2_desk_groundtruth.txt",
}


def walk(combinations: Sequence[Combination], estimate: str, data_dir: Path) -> list[float]:
    """Differences on a real path, in the current folder; those that both refuse left out."""
    write_transforms(Path())
    files = [once_each(data_dir / "trajectories" / name) for name in (estimate, REAL[estimate])]
    found = (compare(one, *files) for one in combinations)
    return [one for one in found if one is not None]


@pytest.mark.slow
@pytest.mark.parametrize("estimate", REAL)
def test_combinations_of_options_are_evos_on_real_paths(
    estimate: str, data_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All pairs of options come about on one of the paths."""
    monkeypatch.chdir(tmp_path)
    drawn = list(every_pair(np.random.default_rng(5)))
    found = walk(drawn[list(REAL).index(estimate) :: len(REAL)], estimate, data_dir)
    assert found
    assert max(found) < 1e-6


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


def measure(names: Sequence[str]) -> None:
    """The whole product on every path, or on those named: a row each."""
    data_dir = Path(os.environ["MOTORCADE_DATA"]).resolve()
    print(f"{'estimate':36}{'compared':>10}{'refused':>9}{'apart':>10}", flush=True)
    for name in names or REAL:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            with Path(os.devnull).open("w") as quiet, contextlib.redirect_stderr(quiet):
                found = walk(KNOWN, name, data_dir)
            refused = len(KNOWN) - len(found)
        print(f"{name:36}{len(found):10}{refused:9}{max(found):10.1e}", flush=True)


if __name__ == "__main__":
    measure(sys.argv[1:])
