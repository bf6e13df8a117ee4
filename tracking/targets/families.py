"""Which marker families images show: every family is read at once, and chance is kept out.

A quad's bits are random where it is no marker, so a family of n words of b bits finds one in every
``2^b / (8 n)`` quads by chance (four turns, read plain and sharpened). That is never for 36 bits,
and in every image for ``aruco_4x4_1000``. So an observation counts where every cell of the print,
borders included, is right; an id counts where several images show it; and where chance is likely
its print must look like it, too. What stronger families claim is no marker of a weaker one: the
middle of a 6 x 6 print passes for a 4 x 4 one now and then. Dictionaries of ArUco that differ in
size alone begin with the same words: the smallest that holds the ids seen is named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.progress import track
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.images import shrunk
from motorcade.tracking.markers.families import FAMILIES, layout
from motorcade.tracking.markers.native._quads import find_quads
from motorcade.tracking.markers.reading import (
    LEAST_CONTRAST,
    Quads,
    decode_quads,
    read_markers,
)

SMALL_PX = 1280
"""A longer image is searched at half its size or less."""
_REACHES_PX = (0, 2)
_NESTED = (50, 100, 250, 1000)
_UNLIKELY = 1e-3
"""Chance of a quad above which a family's observations must look like their prints."""
_LOOKS_RIGHT = 0.9
_LEGIBLE = 0.75
_SAME_SHARE = 0.6
_LEAST_SHARE = 0.15
_FAR_IDS = 4
"""Ids beyond the first 250 of a likely dictionary that are no chance together."""
_FIRST = 8
"""Images that are read for all families; the others for what these mostly show."""
_MOSTLY = 0.5


@dataclass(frozen=True)
class SeenFamily:
    """A family and where it was seen.

    Fields:
        family: its name.
        marker_ids: ids that count, rising.
        images: rising indices of those that show one of them.
        observations: how often one of them was seen.

    >>> from motorcade.tracking import MarkerGrid
    >>> from motorcade.tracking.targets.families import families_seen
    >>> image, _ = MarkerGrid("aruco_5x5_100", 3, 2, 0.05, 0.02).draw(pixels_per_m=1500.0)
    >>> [found] = families_seen([image, image])
    >>> found.family, found.marker_ids, found.observations
    ('aruco_5x5_50', (0, 1, 2, 3, 4, 5), 12)
    """

    family: str
    marker_ids: tuple[int, ...]
    images: tuple[int, ...]
    observations: int


@dataclass(frozen=True)
class _Reading:
    """A marker read without a wrong cell."""

    family: str
    marker_id: int
    image: int
    centre: tuple[float, float]
    side_px: float
    agreement: float


def families_seen(images: Sequence[GrayImage], *, whole: bool = False) -> tuple[SeenFamily, ...]:
    """The marker families that images of one place show, those seen most often first.

    Where most of the first few show a family, the others are read for the families of those alone.

    Args:
        images: grey uint8 images ``(height, width)``, some seconds apart where they are
            frames of a clip. Of one or two, more ids must be seen before a small family counts.
        whole: search large images as they are, for small markers; they are halved otherwise.

    Raises:
        ValueError: not grey uint8 images.
    """
    grays = [checked_gray(one) for one in images]
    searched = grays if whole else [shrunk(gray, SMALL_PX) for gray in grays]
    # The first are spread over all, so that they show what the clip shows.
    first = range(0, len(grays), -(-len(grays) // _FIRST)) if grays else range(0)
    tried = track(first, "reading all families", len(first))
    seen = [one for index in tried for one in _exact(searched[index], index, _widest())]
    seen_families = _listed(_widest(), seen, len(first))
    clear = any(len(one.images) >= _MOSTLY * len(first) for one in seen_families)
    counted = {words_of(one.family) for one in seen_families}
    families = [one for one in _widest() if one in counted or not clear]
    others = sorted(set(range(len(grays))) - set(first))
    tried = track(others, "reading markers", len(others))
    seen += [one for index in tried for one in _exact(searched[index], index, families)]
    return _listed(families, seen, len(grays))


def _listed(
    families: Sequence[str], seen: Sequence[_Reading], searched: int
) -> tuple[SeenFamily, ...]:
    """Families that count, those seen most often first."""
    candidates = [_counted(family, seen, searched) for family in families]
    return tuple(
        sorted((one for one in candidates if one), key=lambda candidate: -candidate.observations)
    )


def words_of(family: str) -> str:
    """The family as it was read: the largest of its kind."""
    stem, _, size = family.rpartition("_")
    return f"{stem}_{_NESTED[-1]}" if size.isdigit() and int(size) in _NESTED else family


@cache
def _widest() -> tuple[str, ...]:
    """Families that hold no other's words from the first on, the least likely by chance first."""
    nested = {f"aruco_{n}x{n}_{count}" for n in (4, 5, 6, 7) for count in _NESTED[:-1]}
    return tuple(sorted(set(FAMILIES) - nested, key=lambda family: (_chance(family), family)))


def _chance(family: str) -> float:
    """Of a quad with random bits to read as one of the family, without a wrong bit."""
    shape = layout(family)
    return float(8.0 * len(shape.words) / 2.0 ** len(shape.bit_rows))


def _exact(gray: GrayImage, number: int, families: Sequence[str]) -> list[_Reading]:
    """Markers in an image, read without a wrong cell; each place is one's.

    Families come with the least likely by chance first.
    """
    image = np.ascontiguousarray(gray)
    quads = {
        white_inside: np.concatenate(
            [find_quads(image, white_inside, 5.0, reach) for reach in _REACHES_PX]
        ).astype(np.float64)
        for white_inside in {layout(family).white_inside for family in families}
    }
    readings: list[_Reading] = []
    for family in families:
        read = decode_quads(image, quads[layout(family).white_inside], family)
        for reading in _legible(image, read, family, number):
            if not any(_same_place(reading, other) for other in readings):
                readings.append(reading)
    return readings


def _legible(image: GrayImage, read: Quads, family: str, number: int) -> list[_Reading]:
    reading = read_markers(image, read.corners_px, family, read.ids)
    good = (reading.wrong_cells == 0) & (reading.agreement >= _LEGIBLE)
    rows = np.flatnonzero(good & (reading.contrast >= LEAST_CONTRAST))
    centres, sides = read.corners_px.mean(axis=1), _sides_px(read.corners_px)
    return [
        _Reading(
            family,
            int(read.ids[row]),
            number,
            (float(centres[row, 0]), float(centres[row, 1])),
            float(sides[row]),
            float(reading.agreement[row]),
        )
        for row in rows[np.argsort(-reading.agreement[rows], kind="stable")]
    ]


def _sides_px(corners_px: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(np.roll(corners_px, 1, axis=1) - corners_px, axis=-1)
    mean: FloatArray = lengths.mean(axis=1)
    return mean


def _same_place(reading: _Reading, other: _Reading) -> bool:
    apart = np.hypot(*np.subtract(reading.centre, other.centre))
    return bool(apart < _SAME_SHARE * max(reading.side_px, other.side_px))


def _counted(family: str, observations: Sequence[_Reading], searched: int) -> SeenFamily | None:
    """What is seen of a family, without ids that chance may have given; None without any."""
    own = [one for one in observations if one.family == family]
    likely = _chance(family) > _UNLIKELY
    least = 1 if searched < 3 else max(2, round(_LEAST_SHARE * searched)) if likely else 2
    ids = []
    for marker in sorted({one.marker_id for one in own}):
        these = [one for one in own if one.marker_id == marker]
        steady = len({one.image for one in these}) >= least
        looks = not likely or float(np.median([one.agreement for one in these])) >= _LOOKS_RIGHT
        if steady and looks:
            ids.append(marker)
    if likely and searched < 3 and len(ids) < 3:
        return None
    name, ids = _smallest(family, ids, likely)
    own = [one for one in own if one.marker_id in ids]
    if not own:
        return None
    shown = tuple(sorted({one.image for one in own}))
    return SeenFamily(name, tuple(ids), shown, len(own))


def _smallest(family: str, ids: list[int], likely: bool) -> tuple[str, list[int]]:
    """The smallest dictionary that holds the ids, less those that stand there by chance.

    Beyond the first 250 words of a dictionary that chance fills, ids are believed in numbers only.
    """
    stem, _, size = family.rpartition("_")
    if size != str(_NESTED[-1]) or not ids:
        return family, ids
    if likely and sum(one >= _NESTED[2] for one in ids) < _FAR_IDS:
        ids = [one for one in ids if one < _NESTED[2]]
        if not ids:
            return family, ids
    return f"{stem}_{next(one for one in _NESTED if ids[-1] < one)}", ids
