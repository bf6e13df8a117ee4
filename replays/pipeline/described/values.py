"""What was found out about a recording, and the pictures that tell it."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.replays.io.recording import FrameSequence
from motorcade.tracking.checks import GrayImage

_NEIGHBOURS = 3
_FEWEST_PLACES, _MOST_PLACES = 8, 24
_MOST_BYTES = 2**28


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

    def manifest(self, given: str) -> str:
        """The text of a manifest that says all this beside what the given one says, if any."""
        said = "".join(f"# {one}\n" for one in self.assumed)
        stated = tomllib.loads(given)
        lists = "".join(  # before all tables; TOML reads such strings as JSON does
            f"{key} = {json.dumps(texts, ensure_ascii=False)}\n"
            for key, texts in (("settings", self.settings), ("doubts", self.doubts))
            if texts and key not in stated
        )
        span = ""
        if self.span and "frames" in stated:
            given = re.sub(r"(?m)^\s*\[frames\].*$", rf"\g<0>\n{self.span}", given, count=1)
        elif self.span:
            span = f"[frames]\n{self.span}"
        return "\n".join(text for text in (said, lists, given, span, self.tables) if text)


@dataclass(frozen=True, eq=False)
class SampledPictures:
    """Grey pictures of a recording: a few places, at each some neighbouring frames.

    Fields:
        pictures: in the order of time.
        time_ns: ``(P,)`` their stamps.
        places: rows of `pictures`, one a place.
    """

    pictures: tuple[GrayImage, ...]
    time_ns: IntArray
    places: tuple[int, ...]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        height, width = self.pictures[0].shape
        return width, height

    @property
    def spread(self) -> tuple[GrayImage, ...]:
        """One picture of each place."""
        return tuple(self.pictures[row] for row in self.places)


def sampled_pictures(
    frames: FrameSequence, kept: Mapping[int, GrayImage] = MappingProxyType({})
) -> SampledPictures:
    """Three neighbouring frames at each of some places that are spread over a recording.

    Neighbours tell how fast the camera moved; places, what it saw. Of large pictures fewer are
    taken, so that all of them fit into a quarter of a GiB; of a few frames every one is a place.
    `kept` are pictures that were read already, by their rows.
    """
    rows, places = sample_rows(len(frames), kept[0].size if kept else frames[0].gray().size)
    pictures = tuple(kept[row] if row in kept else frames[row].gray() for row in rows.tolist())
    return SampledPictures(pictures, np.asarray(frames.time_ns[rows]), places)


def sample_rows(count: int, pixels: int) -> tuple[IntArray, tuple[int, ...]]:
    """Rows of the frames that a sample takes, and which of these stand for a place each."""
    places = int(np.clip(_MOST_BYTES / (_NEIGHBOURS * pixels), _FEWEST_PLACES, _MOST_PLACES))
    last = count - 1
    ends = (0, last) if last < _FEWEST_PLACES else (1, last - 1)
    middles = np.unique(np.linspace(*ends, places).astype(int))
    beside = (middles[:, None] + np.arange(_NEIGHBOURS) - _NEIGHBOURS // 2).ravel()
    rows = np.unique(np.clip(beside, 0, last))
    return rows, tuple(int(row) for row in np.searchsorted(rows, middles))
