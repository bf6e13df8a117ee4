"""From files to film by stage: processor and wall time of `motorcade run` in a fresh process.

    python -m tests.bench.view.film                     # the recording vamr_board
    python -m tests.bench.view.film --drawn 1920x1080   # ten seconds of a board that is drawn here

Processor time counts all threads of the process; on a machine that others use it is what can be
compared. The drawn recording is a printed board on a mottled table, seen by a camera that sways, at
30 frames a second, as an H.264 video with its manifest.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import cv2
import numpy as np

from motorcade.render import write_video
from motorcade.render.scene import ImageArray
from tests.bench.data import data_folder

__all__ = ["bench_film", "film_lines"]

MANIFEST = Path(__file__).parents[3] / "docs" / "manifests" / "vamr_board.toml"
COLUMNS, ROWS, SQUARE_M, SQUARE_PX = 9, 6, 0.04, 60
RATE_HZ, LASTS_S = 30.0, 10.0
RUNS = 3


def bench_film(recording: Path | None = None, manifest: Path = MANIFEST) -> dict[str, Any]:
    """Run a recording some times, each in a new process, and take the median of each stage.

    Args:
        recording: by default `vamr_board` of the data folder.
        manifest: that describes it.

    Returns:
        `stages`, rows of name, `cpu_s` and `wall_s` in order, their sums, the footage's `frames`
        and `footage_s`, and the `load` of the machine when the last run ended.

    Raises:
        RuntimeError: a run failed.
    """
    root = recording or data_folder() / "replays" / "vamr_board"
    runs = [_one_run(root, manifest) for _ in range(RUNS)]
    rows = [
        {
            "stage": same[0]["stage"],
            "cpu_s": median(one["cpu_s"] for one in same),
            "wall_s": median(one["wall_s"] for one in same),
        }
        for same in zip(*(run["stages"] for run in runs), strict=True)
    ]
    sums = {name: median(sum(one[name] for one in run["stages"]) for run in runs) for name in KEYS}
    told = {name: runs[0][name] for name in ("frames", "footage_s")}
    return {"stages": rows, **sums, **told, "load": os.getloadavg()[0]}


KEYS = ("cpu_s", "wall_s")


def film_lines(found: Mapping[str, Any]) -> list[str]:
    """A line a stage, and the sum."""
    lines = [
        f"from files to film: {found['frames']} frames, {found['footage_s']:.1f} s of footage; "
        f"processor {found['cpu_s']:.1f} s, wall {found['wall_s']:.1f} s (load {found['load']:.0f})"
    ]
    for row in found["stages"]:
        lines.append(f"  {row['stage']:<16}{row['cpu_s']:7.2f} s {row['wall_s']:7.2f} s")
    return lines


def _one_run(root: Path, manifest: Path) -> dict[str, Any]:
    command = [sys.executable, "-m", "tests.bench.view.film", "--child", str(root), str(manifest)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{root}: the run failed: {done.stderr[-400:]}")
    told: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return told


def _timed_run(root: Path, manifest: Path) -> dict[str, Any]:
    """Run a recording here; each stage's time is told when it ends, from the one before it on."""
    from motorcade.replays.io.readers.opening import open_recording
    from motorcade.replays.pipeline.job import Job, run_job

    marks: list[tuple[str, float, float]] = []

    def mark(name: str) -> None:
        marks.append((name, time.process_time(), time.perf_counter()))

    class Ends(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if record.msg == "%s: %.1f s" and isinstance(record.args, tuple):
                mark(str(record.args[0]))

    mark("start")
    logger = logging.getLogger("motorcade.graph")
    logger.setLevel(logging.INFO)
    logger.addHandler(Ends())
    with tempfile.TemporaryDirectory() as out:
        run_job(Job(root, Path(out), manifest))
    mark("results")
    frames = open_recording(root, manifest).frames
    rows = [{"stage": "start", "cpu_s": marks[0][1], "wall_s": marks[0][1]}]
    rows += [
        {"stage": name, "cpu_s": cpu_s - before[1], "wall_s": wall_s - before[2]}
        for before, (name, cpu_s, wall_s) in pairwise(marks)
    ]
    lasts_s = 1e-9 * float(frames.time_ns[-1] - frames.time_ns[0])
    return {"stages": rows, "frames": len(frames), "footage_s": lasts_s}


def write_drawn(folder: Path, width: int, height: int) -> Path:
    """Draw ten seconds of a board as a video beside its manifest, which is returned."""
    count = round(LASTS_S * RATE_HZ)
    stamps = np.rint(np.arange(count) * 1e9 / RATE_HZ).astype(np.int64)
    write_video(folder / "board.mp4", _images(width, height, count), stamps)
    focal = 0.8 * width
    text = f"""name = "drawn board"
[frames]
video = "board.mp4"
[camera]
model = "pinhole"
width = {width}
height = {height}
fx = {focal}
fy = {focal}
cx = {0.5 * (width - 1)}
cy = {0.5 * (height - 1)}
[board]
type = "checkerboard"
columns = {COLUMNS}
rows = {ROWS}
square_m = {SQUARE_M}
"""
    path = folder / "board.toml"
    path.write_text(text)
    return path


def _images(width: int, height: int, count: int) -> Iterator[ImageArray]:
    """What the swaying camera sees, with a sensor's noise."""
    rng = np.random.default_rng(0)
    table = _table(rng)
    focal, middle = 0.8 * width, np.array([0.5 * (width - 1), 0.5 * (height - 1)])
    matrix = np.array([[focal, 0.0, middle[0]], [0.0, focal, middle[1]], [0.0, 0.0, 1.0]])
    grain = rng.normal(0.0, 2.0, (height + 64, width + 64, 1)).astype(np.float32)
    for k in range(count):
        turn = 2.0 * np.pi * k / count
        vector = [-0.5 + 0.15 * np.sin(turn), 0.2 * np.cos(turn), 0.1 * np.sin(2.0 * turn)]
        rotation = cv2.Rodrigues(np.array(vector))[0]
        place = np.array([0.05 * np.sin(turn), 0.03 * np.cos(turn), 0.75 + 0.08 * np.sin(turn)])
        # Pixels of the table to metres about its middle.
        scale = SQUARE_M / SQUARE_PX
        half = 0.5 * np.array(table.shape[1::-1])
        to_m = np.array([[scale, 0, -scale * half[0]], [0, scale, -scale * half[1]], [0, 0, 1]])
        homography = matrix @ np.column_stack([rotation[:, 0], rotation[:, 1], place]) @ to_m
        seen = cv2.warpPerspective(
            table, homography, (width, height), flags=cv2.INTER_AREA, borderValue=(90, 100, 110)
        )
        x, y = rng.integers(0, 64, 2)
        noisy = seen + grain[y : y + height, x : x + width]
        yield np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def _table(rng: np.random.Generator) -> ImageArray:
    """A printed board on a mottled table, RGB, `SQUARE_PX` pixels a square."""
    rows, columns = 6 * (ROWS + 1), 4 * (COLUMNS + 1)
    mottled = cv2.resize(
        rng.uniform(70.0, 140.0, (rows, columns, 3)), None, fx=SQUARE_PX // 2, fy=SQUARE_PX // 2
    )
    table = mottled.astype(np.uint8)
    squares = np.indices((ROWS + 1, COLUMNS + 1)).sum(axis=0) % 2
    board = np.kron(squares, np.ones((SQUARE_PX, SQUARE_PX)))
    print_px = np.pad(np.where(board > 0, 25, 230), SQUARE_PX, constant_values=230).astype(np.uint8)
    top, left = ((np.array(table.shape[:2]) - print_px.shape) // 2).tolist()
    table[top : top + print_px.shape[0], left : left + print_px.shape[1]] = print_px[..., None]
    return np.asarray(table, np.uint8)


def main() -> None:
    """Print the table of one recording."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.view.film", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--drawn", metavar="WIDTHxHEIGHT", help="of a video that is drawn here")
    parser.add_argument("--child", nargs=2, type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        print(json.dumps(_timed_run(*given.child)))
    elif given.drawn:
        width, height = map(int, given.drawn.split("x"))
        with tempfile.TemporaryDirectory() as folder:
            manifest = write_drawn(Path(folder), width, height)
            print("\n".join(film_lines(bench_film(Path(folder), manifest))))
    else:
        print("\n".join(film_lines(bench_film())))


if __name__ == "__main__":
    main()
