"""Every recording at hand, run with nothing but its name, beside what its manifest gives.

    python -m tests.end_to_end.without_manifest [NAME …] [--out DIR] [--until STAGE]

For each recording below `MOTORCADE_DATA`: the focal length found against the one told, the jitter
and the registration of the measured path with and without the manifest (lengths carried over to
metres by the size that the manifest tells, or, of SLAM's maps, to the other's by how far the camera
went), and what was assumed; or the one line that says what is missing. Ends with 1 where a figure
is more than a tenth off and nothing was said of it.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.names import one_line
from motorcade.replays import open_recording, read_trajectory
from motorcade.replays.pipeline.job import Job, run_job
from motorcade.tracking import CharucoBoard, Checkerboard, MarkerGrid
from tests.bench.data import data_folder

MANIFESTS = Path(__file__).resolve().parents[2] / "docs" / "manifests"
TOLERANCE = 0.1


@dataclass(frozen=True)
class Given:
    """A recording, and the manifest that describes it where one is at hand."""

    name: str
    path: Path
    manifest: Path | None = None


@dataclass(frozen=True)
class Found:
    """What a run gave; figures are None where it has none.

    `reach` is the RMS of the places about their mean, in the unit of the path.
    """

    focal_px: float | None
    registration_px: float | None
    jitter: float | None
    origin: str
    assumed: tuple[str, ...]
    seconds: float
    reach: float = 1.0


def recordings(data: Path) -> Iterator[Given]:
    """All that are there, in a fixed order."""
    named = {
        "vamr_board": ("replays/vamr_board", "vamr_board"),
        "karma": ("replays/gopro/karma.mp4", "gopro_karma"),
        "euroc_V1_01": ("replays/euroc_V1_01", "euroc_v1_01"),
    }
    for name, (path, manifest) in named.items():
        yield Given(name, data / path, MANIFESTS / f"{manifest}.toml")
    for path in ("7scenes_redkitchen", "7scenes_redkitchen_200", "kitti_short"):
        yield Given(path, data / "replays" / path)
    for path in sorted((data / "replays" / "bags").glob("*")):
        yield Given(f"bags/{path.name}", path)
    for path in ("multi", "rotations", "photos"):
        yield Given(f"tags/{path}", data / "tags" / path)
    for path in sorted((data / "tags" / "tagslam").glob("test_2[0-9]")):
        yield Given(f"tagslam/{path.name}", path)


def run(given: Given, manifest: Path | None, out: Path, until: str) -> Found | str:
    """What a run gave, or the line with which it was refused."""
    start = time.perf_counter()
    try:
        log = run_job(Job(given.path, out, manifest, until=until))
    except (ValueError, OSError, RuntimeError) as fault:
        return one_line(fault, 400).strip("'\"")
    used = log.get("manifest")
    recording = open_recording(given.path, None if used is None else Path(used))
    measured = log.get("errors", {}).get("measured", {})
    return Found(
        None if recording.camera is None else recording.camera.fx,
        measured.get("registration_rmse_px"),
        measured.get("linear_jitter_m_s2"),
        str(log["chosen"].get("tracked", "")),
        tuple(log.get("assumed", ())),
        time.perf_counter() - start,
        reach(out / "trajectories" / "camera_poses_motor.tum"),
    )


def reach(path: Path) -> float:
    """RMS of the places of a trajectory about their mean; 1 where there is none."""
    if not path.exists():
        return 1.0
    places = read_trajectory(path).motors.translation_m
    return float(np.sqrt(((places - places.mean(axis=0)) ** 2).sum(axis=-1).mean()))


def unit_m(given: Given) -> float:
    """What a square, or a marker's side, measures by the manifest; 1 where lengths are metres."""
    if given.manifest is None:
        return 1.0
    board = open_recording(given.path, given.manifest).board
    if isinstance(board, Checkerboard | CharucoBoard):
        return board.square_m
    return board.marker_m if isinstance(board, MarkerGrid) else 1.0


def compared(given: Given, alone: Found, told: Found) -> tuple[list[str], bool]:
    """Cells of the table, and whether all figures agree to a tenth."""
    sizeless = any(one.startswith("size:") for one in alone.assumed)
    scale = unit_m(given) if sizeless else 1.0
    if alone.origin == told.origin == "slam_poses" and alone.reach > 0.0:
        scale = told.reach / alone.reach
    if alone.jitter is not None:
        alone = replace(alone, jitter=scale * alone.jitter)
    cells, agree = [], True
    for name, digits in (("focal_px", ".1f"), ("registration_px", ".3f"), ("jitter", ".3g")):
        mine, theirs = getattr(alone, name), getattr(told, name)
        both = mine is not None and theirs is not None
        cells.append(f"{_shown(mine, digits)} / {_shown(theirs, digits)}")
        agree &= not both or mine <= theirs * (1.0 + TOLERANCE)
    return cells, agree


def _shown(value: Any, digits: str) -> str:
    return "-" if value is None else format(value, digits)


def main(arguments: list[str] | None = None) -> int:
    """Run all, print the table, give what to exit with."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", help="these alone")
    parser.add_argument("--out", type=Path, help="keep results here")
    parser.add_argument("--until", default="errors", help="how far (errors)")
    chosen = parser.parse_args(arguments)
    out = chosen.out or Path(tempfile.mkdtemp())
    wrong = 0
    print("| recording | tracked | focal length, px | registration, px | jitter, m/s² | seconds |")
    print("|---|---|---|---|---|---|")
    try:
        for given in recordings(data_folder()):
            if not given.path.exists() or (chosen.names and given.name not in chosen.names):
                continue
            wrong += not _row(given, out, chosen.until)
    finally:
        if chosen.out is None:
            shutil.rmtree(out)
    return int(wrong > 0)


def _row(given: Given, out: Path, until: str) -> bool:
    """Print a recording's row; whether it is as it should be."""
    alone = run(given, None, out / given.name / "alone", until)
    if isinstance(alone, str):
        print(f"| {given.name} | refused: {alone} | | | | |", flush=True)
        return True
    told = alone
    if given.manifest is not None:
        other = run(given, given.manifest, out / given.name / "told", until)
        told = alone if isinstance(other, str) else other
    cells, agree = compared(given, alone, told)
    figures = " | ".join([alone.origin, *cells, f"{alone.seconds:.0f}"])
    print(f"| {given.name}{'' if agree else ' (off)'} | {figures} |", flush=True)
    for one in alone.assumed:
        print(f"    {one}", flush=True)
    return agree or bool(alone.assumed)


if __name__ == "__main__":
    sys.exit(main())
