"""`make bench SUITE=tracking`, board: `vamr_board` by its checkerboard, as tracked and smoothed.

APE and rotation are taken after a rigid alignment. Jitter is the root mean square over the axes of
the standard deviation of the positions' second differences: a hand's own motion leaves about 0.22
mm at 30 Hz. The reference is itself noisy (0.77 mm), so errors against it cannot fall much below
the plain path's, while jitter needs no reference.

Of the two smoothers one knows the past alone, and one looks 0.12 s ahead. Their settings were
picked on this very recording, from about forty that were scored on the figures reported here: they
show what such smoothers can reach on it, not what to expect of another recording.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.metrics import evaluate
from motorcade.fusion.smoothing import smooth
from motorcade.ga import Trajectory
from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking import track_board
from tests.bench.data import data_folder

__all__ = ["CAUSAL", "OFFLINE", "bench_board", "board_table", "position_jitter_m"]

CAUSAL: tuple[str, dict[str, Any]] = (
    "double_exponential",
    {"cutoff_hz": 8.0, "trend_cutoff_hz": 4.0},
)
OFFLINE: tuple[str, dict[str, Any]] = ("local_polynomial", {"window_s": 0.24, "order": 2})
_MANIFEST = Path(__file__).parents[3] / "docs" / "manifests" / "vamr_board.toml"


def position_jitter_m(path: Trajectory) -> float:
    """RMS over axes of the standard deviation of second differences of the positions."""
    jumps = np.diff(path.poses.translation_m, 2, axis=0)
    return float(np.sqrt(np.mean(np.var(jumps, axis=0))))


def bench_board(folder: Path | None = None) -> list[dict[str, Any]]:
    """Track the recording and smooth its path both ways.

    Args:
        folder: where the recording `vamr_board` lies; None looks in `MOTORCADE_DATA`, or else in
            `../shared/data`.
    """
    root = folder or data_folder() / "replays" / "vamr_board"
    if not (root.is_dir() and _MANIFEST.is_file()):
        return []
    recording = open_recording(root, _MANIFEST)
    if recording.camera is None or recording.board is None:
        raise ValueError(f"{root}: expected a camera and a board, got a recording without")
    start = time.perf_counter()
    images = ((frame.time_ns, frame.gray()) for frame in recording.frames)
    plain = track_board(images, recording.camera, recording.board).measurements.trajectory
    rows = [_row("as tracked", plain, recording.truth, time.perf_counter() - start)]
    for label, (method, parameters) in (("causal", CAUSAL), ("offline", OFFLINE)):
        start = time.perf_counter()
        smoothed = smooth(plain, method, "motor", **parameters)
        seconds = time.perf_counter() - start
        told = ", ".join(f"{name}={value:g}" for name, value in parameters.items())
        rows.append(_row(f"{label}: {method} {told}", smoothed, recording.truth, seconds))
    return rows


def _row(name: str, path: Trajectory, truth: Trajectory | None, seconds: float) -> dict[str, Any]:
    if truth is None:
        raise ValueError("vamr_board: expected a ground truth, got none")
    judged = evaluate(path, truth, align="se3")
    return {
        "path": name,
        "poses": len(path),
        "ape_rmse_m": judged.ape_m.rmse,
        "rotation_rmse_deg": judged.rotation_deg.rmse,
        "position_jitter_m": position_jitter_m(path),
        "milliseconds_a_frame": 1e3 * seconds / len(path),
    }


def board_table(rows: list[Mapping[str, Any]]) -> str:
    """A row a path."""
    if not rows:
        return "board: vamr_board is not here; set MOTORCADE_DATA to the recordings' folder"
    title = "vamr_board, by its board"
    lines = [f"{title:<66}{'poses':>7}{'APE mm':>9}{'deg':>7}{'jitter mm':>11}{'ms':>8}"]
    for row in rows:
        lines.append(
            f"{row['path']:<66}{row['poses']:>7}{1e3 * row['ape_rmse_m']:>9.3f}"
            f"{row['rotation_rmse_deg']:>7.3f}{1e3 * row['position_jitter_m']:>11.3f}"
            f"{row['milliseconds_a_frame']:>8.2f}"
        )
    return "\n".join(lines)
