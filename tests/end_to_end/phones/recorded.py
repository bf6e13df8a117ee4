"""Recordings with a known camera, self-calibrated: the focal length against the one given.

Their calibrations are not exact: vamr_board's and EuRoC's are right to some tenths of a per cent,
the kitchen's colour camera is given as a depth camera's, karma has none.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import IntArray
from motorcade.tracking import (
    Checkerboard,
    SelfCalibrationError,
    self_calibrate_board,
    self_calibrate_motion,
)
from tests.bench.data import data_folder

__all__ = ["recorded_lines"]

# name, folder of images, rate (Hz), given focal length (px), where that is from
_SCENES = (
    ("7scenes_redkitchen", "7scenes_redkitchen", "*.color.*", 30.0, 525.0, "the colour camera's"),
    ("kitti_short", "kitti_short", "*.png", 10.0, 718.856, "calib.txt"),
    ("euroc_V1_01", "euroc_V1_01", "*.png", 20.0, 458.0, "sensor.yaml; it stands still"),
)


def recorded_lines() -> Iterator[str]:
    """A line a recording that is at hand."""
    data = data_folder()
    if data is None:
        yield "recordings: MOTORCADE_DATA is not set"
        return
    replays = Path(data) / "replays"
    if (replays / "vamr_board").is_dir():
        yield _board(replays / "vamr_board")
    for name, folder, pattern, rate_hz, focal, source in _SCENES:
        files = sorted((replays / folder).rglob(pattern))
        if files:
            yield _scene(name, files, rate_hz, focal, source)


def _stamps(count: int, rate_hz: float) -> IntArray:
    return np.asarray(np.rint(np.arange(count) * 1e9 / rate_hz), np.int64)


def _gray(file: Path) -> NDArray[np.uint8]:
    image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
    assert image is not None, file
    return np.asarray(image, np.uint8)


def _board(folder: Path) -> str:
    files = sorted((folder / "images").iterdir())
    given = float((folder / "K.txt").read_text(encoding="utf-8").split()[0])
    board = Checkerboard(9, 6, 1.0)
    views = [board.detect(_gray(file)) for file in files]
    shape = _gray(files[0]).shape
    found = self_calibrate_board(views, (shape[1], shape[0]), _stamps(len(files), 30.0))
    return _line("vamr_board", found.camera.fx, found.sigma_focal, given, "K.txt")


def _scene(name: str, files: list[Path], rate_hz: float, focal: float, source: str) -> str:
    images = [_gray(file) for file in files]
    height, width = images[0].shape
    try:
        found = self_calibrate_motion(images, (width, height), _stamps(len(files), rate_hz))
    except SelfCalibrationError as refusal:
        return f"     {name:24s} refused: {refusal}"
    return _line(name, found.camera.fx, found.sigma_focal, focal, source)


def _line(name: str, found: float, sigma: float, given: float, source: str) -> str:
    return (
        f"     {name:24s} focal {found:.1f} px (sigma {sigma:.2%}), given {given:.1f} "
        f"({source}): {found / given - 1.0:+.2%}"
    )
