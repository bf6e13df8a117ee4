"""Writes the textured room as a recording in the TUM RGB-D layout, to be read like any user's.

Grey PNG images, 16-bit depth in 1/5000 m (0 where there is none; nothing is farther than 13.1 m),
the right images of the pair with their list `right.txt`, exact truth, and a manifest with the
camera and the pair.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.replays.io.files import write_bytes
from motorcade.replays.io.readers.layouts.tum_rgbd import DEPTH_UNITS_PER_M
from motorcade.replays.io.trajectories import write_trajectory
from tests.textured_room.inertial import write_inertial
from tests.textured_room.renderer import Sensor, View
from tests.textured_room.scenarios import Scenario

__all__ = ["write_recording"]

Track = Callable[[Iterable[View], str, int], Iterable[View]]
_FOLDERS = ("rgb", "depth", "right")


def write_recording(
    folder: Path,
    scenario: Scenario,
    *,
    name: str,
    imu: bool = False,
    progress: Track | None = None,
) -> None:
    """Draw a scenario into a folder.

    Args:
        folder: made where it is missing; it must be empty.
        scenario: what happens.
        name: of the recording, for people.
        imu: whether an IMU is carried along, see `inertial`.
        progress: wraps the loop over frames: (views, what is done, how many) -> views.

    Raises:
        OSError: the folder is not empty, or cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        raise FileExistsError(f"{folder}: expected an empty folder for the recording")
    for kind in _FOLDERS:
        (folder / kind).mkdir()
    truth = scenario.truth()
    views: Iterable[View] = scenario.views()
    if progress is not None:
        views = progress(views, "drawing the room", scenario.frames)
    stamps = [f"{ns // 10**9}.{ns % 10**9:09d}" for ns in truth.time_ns.tolist()]
    for stamp, view in zip(stamps, views, strict=True):
        for kind, image in zip(_FOLDERS, _images(view), strict=True):
            _write(folder / kind / f"{stamp}.png", image)
    for kind in _FOLDERS:
        rows = chain(["# timestamp filename"], (f"{s} {kind}/{s}.png" for s in stamps))
        write_bytes(folder / f"{kind}.txt", _lines(rows))
    write_trajectory(truth, folder / "groundtruth.txt", "tum")
    carried = write_inertial(folder, scenario) if imu else []
    write_bytes(folder / "motorcade.toml", _lines([*_manifest(name, scenario.sensor), *carried]))


def _images(view: View) -> Iterator[NDArray[np.generic]]:
    """The images of a view as they are stored."""
    yield view.gray
    units = np.rint(np.nan_to_num(view.depth_m, nan=0.0) * DEPTH_UNITS_PER_M)
    yield np.where(units < 65535, units, 0).astype(np.uint16)
    yield view.right


def _write(path: Path, image: NDArray[np.generic]) -> None:
    if not cv2.imwrite(str(path), image, [cv2.IMWRITE_PNG_COMPRESSION, 1]):
        raise OSError(f"{path}: cannot be written")


def _lines(rows: Iterable[str]) -> bytes:
    return "\n".join([*rows, ""]).encode("utf-8")


def _manifest(name: str, sensor: Sensor) -> list[str]:
    camera = sensor.camera
    return [
        "# A synthetic room. World: metres, z up, origin on the floor.",
        f'name = "{name}"',
        "",
        "[camera]",
        'model = "pinhole"',
        *(f"{key} = {getattr(camera, key)!r}" for key in ("width", "height")),
        *(f"{key} = {getattr(camera, key)!r}" for key in ("fx", "fy", "cx", "cy")),
        "",
        "[stereo]",
        'right = "right/*.png"',
        f"baseline_m = {sensor.baseline_m!r}",
    ]
