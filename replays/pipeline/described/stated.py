"""The lens as a file states it: a phone's focal length in 35 mm terms, a GoPro's field of view.

Such figures are rounded, and video shows less than a still does: stabilisation and formats cut the
picture. So they serve where pictures tell nothing, and as a check of what pictures tell.

Sources: EXIF 2.3, tag 41989, and CIPA DCG-001 (equal diagonals: 43.27 mm); Apple's QuickTime key
``com.apple.quicktime.camera.focal_length.35mm_equivalent``; `readers.gopro` for a GoPro's ZFOV.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path

from motorcade.render.video import open_video
from motorcade.replays.io.door import read_bounded, refused
from motorcade.replays.io.readers.frames.exif import focal_35mm
from motorcade.replays.io.readers.frames.files import PictureFrames
from motorcade.replays.io.readers.frames.pictures import FILE_LIMIT
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.gopro import GoProCamera, gopro_camera
from motorcade.replays.io.recording import Recording
from motorcade.tracking.cameras.camera import Camera

_FILM_DIAGONAL_MM = math.hypot(36.0, 24.0)
_KEY = "com.apple.quicktime.camera.focal_length.35mm_equivalent"
_SHORTEST_MM, _LONGEST_MM = 8.0, 500.0
AGREES_SHARE = 0.25
"""Off by more than this, a focal length that was found is doubted."""


@dataclass(frozen=True)
class StatedLens:
    """A lens by what a file says of it.

    Fields:
        camera: without the distortion that nobody states; None where only the model is known.
        said: the statement in words.
        readout_s: of its rolling shutter, 0 where that is not stated.
    """

    camera: Camera | None
    said: str
    readout_s: float = 0.0


def stated_lens(recording: Recording, size: tuple[int, int]) -> StatedLens | None:
    """What the files of a recording say of its lens; None where they say nothing.

    Args:
        recording: a video, or pictures of which the first is asked.
        size: width and height of the upright pictures.
    """
    frames = recording.frames
    if isinstance(frames, PictureFrames):
        return _in_35mm(focal_35mm(read_bounded(frames.files[0], FILE_LIMIT)), size)
    if not isinstance(frames, VideoFrames):
        return None
    gopro = gopro_camera(frames.path)
    return _of_gopro(gopro, size) if gopro else _in_35mm(_video_35mm(frames.path), size)


def _video_35mm(path: Path) -> float | None:
    """Of the film as a whole, or of its first track of pictures."""
    with refused(), open_video(path) as container:
        notes = [container.metadata, *(one.metadata for one in container.streams.video[:1])]
    stated = next((one[_KEY] for one in notes if _KEY in one), "")
    number = re.match(r"\s*(\d+(?:\.\d+)?)", stated[:32])
    return None if number is None else float(number[1])


def _in_35mm(focal_mm: float | None, size: tuple[int, int]) -> StatedLens | None:
    if focal_mm is None or not _SHORTEST_MM <= focal_mm <= _LONGEST_MM:
        return None
    focal_px = focal_mm / _FILM_DIAGONAL_MM * math.hypot(*size)
    said = f"a lens of {focal_mm:g} mm in 35 mm terms, {focal_px:.0f} px"
    return StatedLens(_camera(size, focal_px), said)


def _of_gopro(gopro: GoProCamera, size: tuple[int, int]) -> StatedLens:
    readout_s = gopro.readout_s or 0.0
    name = f"a GoPro {gopro.model}".replace("GoPro GoPro", "GoPro")
    if gopro.diagonal_fov_deg is None:
        return StatedLens(None, name, readout_s)
    half_px, half = 0.5 * math.hypot(*size), math.radians(0.5 * gopro.diagonal_fov_deg)
    linear = bool(gopro.linear) and half < 1.4
    camera = _camera(size, half_px / math.tan(half)) if linear else _fisheye(size, half_px / half)
    view = f"{gopro.diagonal_fov_deg:.0f} degrees from corner to corner"
    return StatedLens(camera, f"{name}, {view}, {camera.fx:.0f} px", readout_s)


def _camera(size: tuple[int, int], focal: float) -> Camera:
    return Camera(*size, focal, focal, 0.5 * (size[0] - 1), 0.5 * (size[1] - 1))


def _fisheye(size: tuple[int, int], focal: float) -> Camera:
    """A lens whose angles grow evenly from the middle on, as a GoPro's wide view nearly is."""
    plain = _camera(size, focal)
    return replace(plain, model="equidistant", distortion=(0.0, 0.0, 0.0, 0.0))
