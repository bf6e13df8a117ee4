"""Clips that nobody described, run with nothing but their names, on one sheet to look at.

    python -m tests.end_to_end.strangers [CLIP …] [--out DIR] [--redraw]

Without names it takes every clip of `MOTORCADE_DATA`'s clips. Of each it prints how the command
ended, the processor's time until its first line, its longest silence (processor's time too) and its
last line, and draws five frames of its film, or of the clip where there is none. `DIR/sheet.png`
(below the site that `make docs` builds, unless named otherwise) holds all of them: whether a figure
is upright, stands on something and may be shown is for eyes to say. `--redraw` draws the sheet anew
from runs that are there. Ends with 1 where a run ended without a film and without a line that says
why.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import textwrap
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tests.bench.data import data_folder

KINDS = {".mp4", ".avi", ".mov", ".mkv", ".webm"}
BELOW_SITE = Path(__file__).resolve().parents[2] / "build" / "site" / "strangers"
_FRAMES, _WIDE, _LINE, _COLUMNS = 5, 420, 20, 190
_TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Fields:
        clip: the file.
        status: the command's exit status.
        first_s, silent_s, whole_s: processor's seconds to the first line, the longest without one,
            all.
        last_line: what the command closed with.
    """

    clip: str
    status: int
    first_s: float
    silent_s: float
    whole_s: float
    last_line: str


def run_clip(clip: Path, out: Path) -> Outcome:
    """Run the command on a clip, its lines kept in `out/run.log`."""
    out.mkdir(parents=True, exist_ok=True)
    command = [Path(sys.executable).with_name("motorcade"), "run", clip, "--out", out]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    assert process.stdout is not None
    times_s, lines = [0.0], []
    for line in process.stdout:
        times_s.append(_processor_s(process.pid))
        lines.append(line.rstrip())
    status = process.wait()
    (out / "run.log").write_text("\n".join(lines) + "\n", encoding="utf-8")
    first_s = times_s[min(1, len(times_s) - 1)]
    silent_s = float(np.max(np.diff(times_s))) if lines else 0.0
    last = next((line for line in reversed(lines) if line.strip()), "")
    return Outcome(str(clip), status, first_s, silent_s, times_s[-1], last)


def _processor_s(pid: int) -> float:
    """Seconds that the processor spent on a process and those that it waited for."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:  # it has just ended
        return float("nan")
    fields = text.rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / _TICKS


def frames_of(video: Path, count: int = _FRAMES) -> list[NDArray[np.uint8]]:
    """Some images of a film, evenly from the first to the last."""
    reader = cv2.VideoCapture(str(video))
    images = []
    while True:
        there, image = reader.read()
        if not there:
            break
        scale = _WIDE / image.shape[1]
        images.append(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))
    rows = np.linspace(0, len(images) - 1, count).round().astype(int) if images else []
    return [np.asarray(images[row], np.uint8) for row in rows]


def strip(outcome: Outcome, out: Path) -> NDArray[np.uint8]:
    """Five frames, and below them what was said."""
    film = out / "overlay.mp4"
    images = frames_of(film if film.exists() else Path(outcome.clip))
    blank = np.full((120, _WIDE, 3), 200, np.uint8)
    row = np.hstack((images or [blank])[:_FRAMES])
    row = np.pad(row, ((0, 0), (0, _WIDE * _FRAMES - row.shape[1]), (0, 0)), constant_values=200)
    head = f"{Path(outcome.clip).name}: {'film' if film.exists() else 'NO FILM'}, status "
    head += f"{outcome.status}, first line {outcome.first_s:.1f} s, silent {outcome.silent_s:.1f} s"
    head += f", in all {outcome.whole_s:.0f} s of the processor"
    plain = outcome.last_line.encode("ascii", "replace").decode()
    lines = [head, *textwrap.wrap(plain, _COLUMNS)]
    text = np.full((_LINE * len(lines) + 10, row.shape[1], 3), 255, np.uint8)
    for k, line in enumerate(lines):
        place = (6, _LINE * (k + 1) - 4)
        cv2.putText(text, line, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
    return np.vstack([row, text])


def main() -> int:
    """Run, print, draw."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.strangers")
    parser.add_argument("clips", type=Path, nargs="*", help="videos; all that are at hand")
    parser.add_argument("--out", type=Path, default=BELOW_SITE, help="runs and sheet.png")
    parser.add_argument("--redraw", action="store_true", help="the sheet alone, of runs that exist")
    arguments = parser.parse_args()
    clips = arguments.clips or sorted(
        path for path in (data_folder() / "clips").glob("*") if path.suffix in KINDS
    )
    if not clips:
        print("no clips: name some, or the folder of recordings in MOTORCADE_DATA")
        return 0
    strips, silent = [], 0
    for clip in clips:
        out = arguments.out / clip.stem
        kept = out / "outcome.json"
        if not arguments.redraw:
            kept.unlink(missing_ok=True)
            (out / "overlay.mp4").unlink(missing_ok=True)
            outcome = run_clip(clip, out)
            kept.write_text(json.dumps(asdict(outcome), indent=2) + "\n", encoding="utf-8")
        elif not kept.exists():
            continue
        outcome = Outcome(**json.loads(kept.read_text(encoding="utf-8")))
        has_film = (out / "overlay.mp4").exists()
        silent += not has_film and not outcome.last_line
        print(
            f"{clip.name}: {'film' if has_film else 'no film'}, {outcome.first_s:.1f} s to the "
            f"first line, {outcome.silent_s:.1f} s silent at most, {outcome.whole_s:.0f} s in all\n"
            f"    {outcome.last_line}",
            flush=True,
        )
        strips.append(strip(outcome, out))
    if strips:
        cv2.imwrite(str(arguments.out / "sheet.png"), np.vstack(strips))
        print(f"look at {arguments.out / 'sheet.png'}")
    return int(silent > 0)


if __name__ == "__main__":
    sys.exit(main())
