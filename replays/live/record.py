"""A live session kept as an ordinary recording, so that `motorcade run` replays it.

    frames/000000.png …   every frame that was tracked, without loss
    stamps.txt            their stamps, ns
    motorcade.toml        camera, board, and the scene where somebody was stood on it
    scene.json            the figure as it stood last
    live.jsonl            a line a frame (state, world_T_camera, held-out distances) or gesture

With a camera that was stated, a run's poses by the board are the live ones bit for bit: it tracks
the same images in the same order. With one that was found on the way they are those of that camera.
"""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2

from motorcade.replays.io.files import write_bytes
from motorcade.replays.io.readers.manifest.section import board_toml, camera_toml
from motorcade.replays.live.figure import LiveFigure
from motorcade.replays.live.frames import LiveFrame
from motorcade.replays.live.tracker import LivePose, LiveTracker
from motorcade.replays.pipeline.look.packing import rows_of
from motorcade.tracking import Board

MOST_FRAMES = 36_000
"""Twenty minutes at 30 a second; recording then ends, and the page says so."""
_WAITING = 32


class LiveRecorder:
    """Writes what a session takes in and gives; FileExistsError where the folder holds anything."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise FileExistsError(f"{folder}: expected an empty folder for the recording")
        (folder / "frames").mkdir()
        self.folder = folder
        self.count = 0
        self._size: tuple[int, ...] | None = None
        self._stamps = (folder / "stamps.txt").open("w", encoding="ascii", buffering=1)
        self._lines = (folder / "live.jsonl").open("w", encoding="utf-8", buffering=1)
        self._writer = ThreadPoolExecutor(1, "recorder")
        self._room = threading.Semaphore(_WAITING)
        self._fault: BaseException | None = None

    @property
    def status(self) -> str:
        """What is recorded, for people; also why it is not any more."""
        if self._fault is not None:
            return f"not recorded any more: {self._fault}"
        if self.count >= MOST_FRAMES:
            return f"not recorded any more: {MOST_FRAMES} frames are there"
        return f"recorded: {self.count} frames in {self.folder}"

    def took(self, frame: LiveFrame, pose: LivePose) -> None:
        """Keep a frame and its pose; waits where the disk is slower than the camera."""
        if self._fault is not None or self.count >= MOST_FRAMES:
            return
        if self._size not in (None, frame.image.shape):
            self._fault = ValueError("images of another size came")
            return
        self._size = frame.image.shape
        number, self.count = self.count, self.count + 1
        self._room.acquire()
        self._writer.submit(self._write, number, frame)
        motor = pose.world_T_camera
        known = {key: getattr(pose, key) for key in ("time_ns", "state", "measured")}
        row = None if motor is None else rows_of(motor).tolist()
        off_px = pose.held_out_px.round(3).tolist()
        self.note({**known, "world_T_camera": row, "held_out_px": off_px})

    def note(self, line: Mapping[str, Any]) -> None:
        """Keep a line of what happened."""
        self._lines.write(json.dumps(line) + "\n")

    def close(self, tracker: LiveTracker, figure: LiveFigure) -> None:
        """Write what describes the recording, once all its frames are on the disk."""
        self._writer.shutdown(wait=True)
        self._stamps.close()
        self._lines.close()
        settings = []
        if figure.position_m is not None and isinstance(tracker.target, Board):
            scene = json.dumps(_scene(figure), indent=2).encode()
            write_bytes(self.folder / "scene.json", scene)
            settings.append("placed.scene=scene.json")
        text = f"settings = {json.dumps(settings)}\n\n"
        text += '[frames]\nimages = "frames/*.png"\nstamps = "stamps.txt"\nstamps_unit = "ns"\n'
        if tracker.camera is not None:
            text += "\n" + camera_toml(tracker.camera)
            if tracker.calibration is not None and tracker.calibration.found is not None:
                text += f"focal_sigma = {tracker.calibration.found.sigma_focal!r}\n"
        if isinstance(tracker.target, Board):
            text += "\n" + board_toml(tracker.target)
        write_bytes(self.folder / "motorcade.toml", text.encode())

    def _write(self, number: int, frame: LiveFrame) -> None:
        try:
            image = frame.image if frame.image.ndim == 2 else frame.image[..., ::-1]
            path = self.folder / "frames" / f"{number:06d}.png"
            if not cv2.imwrite(str(path), image, [cv2.IMWRITE_PNG_COMPRESSION, 1]):
                raise OSError(f"{path}: cannot be written")
            self._stamps.write(f"{frame.time_ns}\n")
        except Exception as fault:  # a disk that is full ends the recording, not the session
            self._fault = fault
        finally:
            self._room.release()


def _scene(figure: LiveFigure) -> dict[str, Any]:
    """The figure on its board, as scene files have it."""
    assert figure.position_m is not None  # asked before
    entry = {
        "name": "figure",
        "kind": "character",
        "file": figure.file,
        "parent": "board",
        "height_m": figure.scale * figure.height_m,
        "position_m": [*figure.position_m.tolist(), 0.0],
        "euler_deg": [0.0, 0.0, math.degrees(figure.heading_rad)],
    }
    anchors = {"board": {"on": "board"}}
    return {"schema": "motorcade-scene", "version": 1, "anchors": anchors, "objects": [entry]}
