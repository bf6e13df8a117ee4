"""`motorcade evaluate` and evo's own commands give the same figures for the same files."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path

import pytest

from motorcade.fusion.metrics.poses.pose_error import Statistics
from motorcade.replays.cli import main

pytest.importorskip("evo")

XYZ = "freiburg1_xyz-groundtruth.txt"
DRIFT, MONO = "freiburg1_xyz-rgbdslam_drift_short.txt", "freiburg1_xyz-ORB_kf_mono.txt"
RELATIONS = {
    "full": ("full", ""),
    "trans_part": ("trans_part", "_m"),
    "rot_part": ("rot_part", ""),
    "angle_deg": ("angle", "_deg"),
    "angle_rad": ("angle", "_rad"),
    "point_distance": ("point_distance", "_m"),
    "point_distance_error_ratio": ("point_distance_error", "_percent"),
}
CASES = {
    "as they are": ("", ""),
    "aligned": ("--align se3", "-a"),
    "scaled": ("--align sim3", "-as"),
    "scaled alone": ("--align scale", "-s"),
    "first poses": ("--align sim3 --n-to-align 9", "-as --n_to_align 9"),
    "origin": ("--align origin", "--align_origin"),
    "scaled origin": ("--align scaled_origin", "-s --align_origin"),
    "in a plane": ("--align se3 --project xz", "-a --project_to_plane xz"),
    "late, in a window": (
        "--offset-s 0.02 --max-difference-s 0.05 --start-s 1305031102.5 --end-s 1305031115",
        "--t_offset 0.02 --t_max_diff 0.05 --t_start 1305031102.5 --t_end 1305031115",
    ),
    "interpolated": ("--interpolate", "--sync_method interpolation"),
}
DELTAS = {
    "frames": ("--delta 3", "-d 3 -u f"),
    "all frames": ("--delta 3 --all-pairs", "-d 3 -u f --all_pairs"),
    "metres": ("--delta 0.1 --delta-unit m --pairs-from estimate", "-d 0.1 -u m"),
    "all metres": (
        "--delta 0.1 --delta-unit m --all-pairs --delta-tolerance 0.3",
        "-d 0.1 -u m --all_pairs -t 0.3 --pairs_from_reference",
    ),
    "degrees": ("--delta 3 --delta-unit deg", "-d 3 -u d --pairs_from_reference"),
    "all radians": (
        "--delta 0.05 --delta-unit rad --all-pairs --pairs-from estimate",
        "-d 0.05 -u r --all_pairs",
    ),
}


@pytest.fixture
def evo(tmp_path, monkeypatch):
    """What ``evo_ape`` and ``evo_rpe`` write, by their own parsers, in a home of their own."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("MPLBACKEND", "Agg")
    from evo.cli import ape, ape_parser, rpe, rpe_parser

    programs = {"ape": (ape_parser, ape), "rpe": (rpe_parser, rpe)}

    def run(program: str, reference: Path, estimate: Path, relation: str, options: str):
        result = tmp_path / f"{program}_{relation}.zip"
        words = ["tum", str(reference), str(estimate), "-r", relation, *options.split()]
        words += ["--save_results", str(result), "--silent", "--no_warnings"]
        parser, module = programs[program]
        module.run(parser.parser().parse_args(words))
        with zipfile.ZipFile(result) as archive:
            return json.loads(archive.read("stats.json"))

    return run


def ours(home: Path, reference: Path, estimate: Path, options: str) -> dict[str, float]:
    words = ["evaluate", estimate, reference, "--relations", "all", "--json", home / "ours.json"]
    assert main([*map(os.fspath, words), *options.split()]) == 0
    return json.loads((home / "ours.json").read_text())


def check(found, program, relation, expected):
    name, unit = RELATIONS[relation]
    for statistic in Statistics.names():
        key = f"{program}_{name}_{statistic}{unit}"
        assert found[key] == pytest.approx(expected[statistic], rel=1e-6, abs=1e-6), key


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("case", CASES)
def test_absolute_errors_are_those_of_evo_ape(data_dir, tmp_path, evo, case):
    """The whole error, which positions and rotations are parts of."""
    paths = [data_dir / "trajectories" / name for name in (XYZ, DRIFT)]
    mine, theirs = CASES[case]
    check(ours(tmp_path, *paths, mine), "ape", "full", evo("ape", *paths, "full", theirs))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("delta", DELTAS)
def test_relative_errors_are_those_of_evo_rpe(data_dir, tmp_path, evo, delta):
    paths = [data_dir / "trajectories" / name for name in (XYZ, MONO)]
    mine, theirs = DELTAS[delta]
    found = ours(tmp_path, *paths, f"--align sim3 {mine}")
    for relation in ("full", "point_distance_error_ratio"):
        check(found, "rpe", relation, evo("rpe", *paths, relation, f"-as {theirs}"))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("delta", DELTAS)
def test_every_relation_with_all_options_together(data_dir, tmp_path, evo, case, delta):
    paths = [data_dir / "trajectories" / name for name in (XYZ, DRIFT)]
    mine, theirs = (" ".join(both) for both in zip(CASES[case], DELTAS[delta], strict=True))
    found = ours(tmp_path, *paths, mine)
    for relation in RELATIONS:
        check(found, "rpe", relation, evo("rpe", *paths, relation, theirs))
        if relation != "point_distance_error_ratio":
            check(found, "ape", relation, evo("ape", *paths, relation, CASES[case][1]))
