"""What was found out about a recording: the images that tell it, and the lens as a file states it.

A phone states its focal length in 35 mm terms, a GoPro its field of view. Such figures are rounded,
and video shows less than a still does: stabilisation and formats cut the image. So they serve where
images tell nothing, and as a check of what images tell.

Sources: EXIF 2.3, tag 41989, and CIPA DCG-001 (equal diagonals: 43.27 mm); Apple's QuickTime key
``com.apple.quicktime.camera.focal_length.35mm_equivalent``; `readers.gopro` for a GoPro's ZFOV.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.render.video import open_video
from motorcade.replays.io.files import read_bounded, refused
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.frames.images import FILE_LIMIT, focal_35mm
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.gopro import GoProCamera, gopro_camera
from motorcade.replays.io.recording import FrameSequence, Recording
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage

_NEIGHBOURS = 3
_FEWEST_PLACES, _MOST_PLACES = 8, 24
_MOST_BYTES, _LARGE = 2**28, 16_000_000


@dataclass(frozen=True)
class Assumption:
    """One thing that was found or assumed, and not told.

    Fields:
        what: the thing, in few words.
        said: what is taken.
        source: where that comes from.
        override: how to say otherwise.

    >>> from motorcade.replays.pipeline.described.values import Assumption
    >>> print(Assumption("times", "30 frames/s", "a guess", "--set described.rate_hz=..."))
    times: 30 frames/s (from a guess); override: --set described.rate_hz=...
    """

    what: str
    said: str
    source: str
    override: str

    def __str__(self) -> str:
        return f"{self.what}: {self.said} (from {self.source}); override: {self.override}"


@dataclass(frozen=True)
class Description:
    r"""What a manifest lacks, and what in it was assumed.

    Fields:
        tables: text of a TOML file, whose files are named relative to the recording.
        settings: knobs that stand before the tables.
        assumed: in the order in which it was found out.
        doubts: what of it is not sure, a clause each.
        span: keys of `[frames]` that take a part of the recording; empty for all of it.

    >>> from motorcade.replays.pipeline.described.values import Description
    >>> print(Description("[camera]\nfov_deg = 65.0\n", ("tracked.by=slam",), ()).manifest(""))
    settings = ["tracked.by=slam"]
    <BLANKLINE>
    [camera]
    fov_deg = 65.0
    <BLANKLINE>
    """

    tables: str
    settings: tuple[str, ...]
    assumed: tuple[Assumption, ...]
    doubts: tuple[str, ...] = ()
    span: str = ""

    def manifest(self, value: str) -> str:
        """The text of a manifest that says all this beside what the given one says, if any."""
        said = "".join(f"# {one}\n" for one in self.assumed)
        stated = tomllib.loads(value)
        lists = "".join(  # before all tables; TOML reads such strings as JSON does
            f"{key} = {json.dumps(texts, ensure_ascii=False)}\n"
            for key, texts in (("settings", self.settings), ("doubts", self.doubts))
            if texts and key not in stated
        )
        span = ""
        if self.span and "frames" in stated:
            value = re.sub(r"(?m)^\s*\[frames\].*$", rf"\g<0>\n{self.span}", value, count=1)
        elif self.span:
            span = f"[frames]\n{self.span}"
        return "\n".join(text for text in (said, lists, value, span, self.tables) if text)


@dataclass(frozen=True, eq=False)
class SampledImages:
    """Grey images of a recording: a few places, at each some neighbouring frames.

    Fields:
        images: in the order of time.
        time_ns: ``(P,)`` their stamps.
        places: rows of `images`, one a place.
    """

    images: tuple[GrayImage, ...]
    time_ns: IntArray
    places: tuple[int, ...]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        height, width = self.images[0].shape
        return width, height

    @property
    def spread(self) -> tuple[GrayImage, ...]:
        """One image of each place."""
        return tuple(self.images[row] for row in self.places)


def sampled_images(
    frames: FrameSequence, kept: Mapping[int, GrayImage] = MappingProxyType({})
) -> SampledImages:
    """Three neighbouring frames at each of some places that are spread over a recording.

    Neighbours tell how fast the camera moved; places, what it saw. Of large images fewer are
    taken, so that all of them fit into a quarter of a GiB (above 16 million pixels no neighbours);
    of a few frames every one is a place.
    `kept` are images that were read already, by their rows.
    """
    rows, places = sample_rows(len(frames), kept[0].size if kept else frames[0].gray().size)
    images = tuple(kept[row] if row in kept else frames[row].gray() for row in rows.tolist())
    return SampledImages(images, np.asarray(frames.time_ns[rows]), places)


def sample_rows(count: int, pixels: int) -> tuple[IntArray, tuple[int, ...]]:
    """Rows of the frames that a sample takes, and which of these stand for a place each."""
    neighbours, fewest = (_NEIGHBOURS, _FEWEST_PLACES) if pixels <= _LARGE else (1, 3)
    places = int(np.clip(_MOST_BYTES / (neighbours * pixels), fewest, _MOST_PLACES))
    last = count - 1
    ends = (0, last) if last < _FEWEST_PLACES else (1, last - 1)
    middles = np.unique(np.linspace(*ends, places).astype(int))
    beside = (middles[:, None] + np.arange(neighbours) - neighbours // 2).ravel()
    rows = np.unique(np.clip(beside, 0, last))
    return rows, tuple(int(row) for row in np.searchsorted(rows, middles))


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
        recording: a video, or images of which the first is asked.
        size: width and height of the upright images.
    """
    frames = recording.frames
    if isinstance(frames, ImageFrames):
        return _in_35mm(focal_35mm(read_bounded(frames.files[0], FILE_LIMIT)), size)
    if not isinstance(frames, VideoFrames):
        return None
    gopro = gopro_camera(frames.path)
    return _of_gopro(gopro, size) if gopro else _in_35mm(_video_35mm(frames.path), size)


def _video_35mm(path: Path) -> float | None:
    """Of the film as a whole, or of its first track of images."""
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
