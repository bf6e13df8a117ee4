"""`python -m tests.end_to_end.focal_lengths RUN…`: focal lengths that runs found, beside OpenCV's.

Each run's recording is calibrated anew by OpenCV alone: its own detectors (by sectors, and the
classical one with refined corners), `calibrateCamera` with five terms on every second image.
Where the two differ, OpenCV's own deviation is too small by so much and is widened to it. Runs
without a checkerboard are passed over. Exit status 1 where a run's focal length is more than two
standard deviations, its own and OpenCV's together, from one that OpenCV tells to a per cent.
"""

from __future__ import annotations

import argparse
import json
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.replays.io.readers.opening import open_recording

GrayImage = NDArray[np.uint8]
Corners = NDArray[np.float32]
EVERY, FEWEST_VIEWS, TOLD, WITHIN_SIGMAS = 2, 6, 0.01, 2.0
_STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 40, 1e-4)


def by_sectors(image: GrayImage, size: tuple[int, int]) -> Corners | None:
    """Corners ``(n, 1, 2)`` of OpenCV's sector-based detector."""
    there, corners = cv2.findChessboardCornersSB(image, size, flags=cv2.CALIB_CB_ACCURACY)
    return corners if there else None


def by_quads(image: GrayImage, size: tuple[int, int]) -> Corners | None:
    """Corners ``(n, 1, 2)`` of its classical detector, refined."""
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
    there, corners = cv2.findChessboardCorners(image, size, flags=flags)
    return cv2.cornerSubPix(image, corners, (11, 11), (-1, -1), _STOP) if there else None


def calibrated(
    images: list[GrayImage],
    size: tuple[int, int],
    detect: Callable[[GrayImage, tuple[int, int]], Corners | None],
) -> tuple[float, float, int]:
    """OpenCV's focal length, its standard deviation (pixels), and in how many images it saw."""
    seen = [corners for one in images if (corners := detect(one, size)) is not None]
    if len(seen) < FEWEST_VIEWS:
        return np.nan, np.nan, len(seen)
    board = np.zeros((size[0] * size[1], 3), np.float32)
    board[:, :2] = np.mgrid[: size[0], : size[1]].T.reshape(-1, 2)
    shape = images[0].shape[::-1]
    _, matrix, _, _, _, deviations, *_ = cv2.calibrateCameraExtended(
        [board] * len(seen), seen, shape, np.eye(3), np.zeros(5)
    )
    return float(matrix[0, 0]), float(deviations[0, 0]), len(seen)


def compared(run: Path) -> Iterator[tuple[str, bool]]:
    """A run's line, and whether it is within its range; nothing without a checkerboard."""
    told: dict[str, Any] = json.loads((run / "run.json").read_text())
    manifest = tomllib.loads((run / "manifest.toml").read_text())
    board = manifest.get("board", {})
    if board.get("type") != "checkerboard":
        return
    frames = open_recording(Path(told["recording"]), None).frames
    images = [frames[k].gray() for k in range(0, len(frames), EVERY)]
    size = (board["columns"], board["rows"])
    found = [calibrated(images, size, detect) for detect in (by_sectors, by_quads)]
    focals, sigmas, counts = np.array(found).T
    own, own_sigma = manifest["camera"]["fx"], manifest["camera"].get("focal_sigma", 0.0)
    if np.isnan(focals).all():
        yield f"| {run.name} | {own:.0f} ± {own_sigma:.2%} | sees too few | | |", True
        return
    best = int(np.nanargmin(sigmas))
    apart = float(np.nanmax(np.abs(focals - focals[best])))
    sigma = float(np.hypot(sigmas[best], 0.5 * apart)) / focals[best]
    off = own / focals[best] - 1.0
    right = bool(sigma > TOLD or abs(off) <= WITHIN_SIGMAS * np.hypot(own_sigma, sigma))
    listed = ", ".join(
        f"{focal:.0f} ± {100.0 * each / focal:.1f} % ({count:.0f})"
        for focal, each, count in zip(focals, sigmas, counts, strict=True)
    )
    verdict = "no truth" if sigma > TOLD else "within" if right else "BEYOND"
    yield f"| {run.name} | {own:.0f} ± {own_sigma:.2%} | {listed} | {off:+.2%} | {verdict} |", right


def main() -> int:
    """Calibrate, print."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.focal_lengths")
    parser.add_argument("runs", type=Path, nargs="+", metavar="RUN", help="folders of runs")
    arguments = parser.parse_args()
    print("| run | found | OpenCV by sectors, by quads (images) | off | |")
    print("|---|---|---|---|---|")
    right = True
    for run in arguments.runs:
        for line, fine in compared(run):
            right &= fine
            print(line, flush=True)
    return int(not right)


if __name__ == "__main__":
    sys.exit(main())
