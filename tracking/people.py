"""People in a sequence of images, as masks: found by nets, and tracked from image to image.

One net looks for people in some images, another segments one of them and says where to look next
(Bazarevsky et al. 2020, "BlazePose"). Somebody counts who is found more than once, and surely once.
Who is less than about a quarter of the image high, sits behind a table, or whose shoulders are out
of view, is mostly missed; a statue or a drawn figure counts as a person.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.checks import GrayImage as Image

_LONG_PX, _IDLE, _BUSY, _BACK = 640, 4, 2, 32
"""Nets see images of so many pixels; people are looked for in every so many while nobody, while
somebody is tracked; and tracked back into so many before."""
LEAST_SCORE, _SURE, _TOGETHER = 0.4, 0.8, 1.0
"""What a detection must score, 0 to 1; the best of a track; and all of a track's, added up."""
_BEGINS, _STAYS = 0.9, 0.5
"""How surely the second net sees somebody, 0 to 1, where a track begins, and where it goes on."""
_SMALLEST, _LARGEST, _SAME = 2e-4, 0.5, 0.5
"""A mask that covers a smaller, or a larger share of the image is none; masks with more than this
intersection over union show one person."""


class SeenPerson(NamedTuple):
    """How surely somebody is there (0 to 1), their mask (h, w), 0 to 255, and their body (2, 2):
    the middle of the hips, and a point upwards, as far off as the body reaches; px.
    """

    presence: float
    mask: Image
    body_px: FloatArray


class _Track:
    """One person through the images: masks by row, as PNG, and the best score of every look."""

    def __init__(self, seen: SeenPerson) -> None:
        self.seen, self.scores, self.masks = seen, [0.0], dict[int, Image]()

    def goes_on(self, row: int, seen: SeenPerson) -> bool:
        """Whether somebody is seen where the track leads, which is then added to it."""
        there = seen.presence >= _STAYS and _SMALLEST < np.mean(seen.mask >= 128) < _LARGEST
        if there:
            self.seen, self.masks[row] = seen, cv2.imencode(".png", seen.mask)[1]
        return bool(there)


def find_people(
    images: Iterable[Image],
    detect: Callable[[Image], list[tuple[float, FloatArray]]],
    segment: Callable[[Image, FloatArray], SeenPerson],
) -> Iterator[Image | None]:
    """Masks of people, 0 to 255, in the size at which nets look, or None for each of the images.

    Images, (h, w, 3) RGB or (h, w), come in the order of time; `detect` gives scores, 0 to 1, and
    bodies of all that may be people in one (h, w, 3), `segment` the person with a body.
    """
    live, tracks = list[_Track](), list[_Track]()
    before: deque[tuple[int, Image]] = deque(maxlen=_BACK)
    for row, image in enumerate(map(_reduced, images)):
        live = [one for one in live if one.goes_on(row, segment(image, one.seen.body_px))]
        live = [one for k, one in enumerate(live) if not _same(one.seen.mask, live[:k])]
        looks = detect(image) if row % (_BUSY if live else _IDLE) == 0 else None
        scores = dict.fromkeys(live, 0.0)
        for score, body_px in sorted(looks or [], key=lambda look: -look[0]):
            seen = segment(image, body_px)
            if score < LEAST_SCORE or seen.presence < _STAYS:
                continue
            known = _same(seen.mask, list(scores))
            scores |= {track: max(scores[track], score) for track in known}
            again = segment(image, seen.body_px)  # in a square that differs a little
            alike = overlap(seen.mask, again.mask) > _SAME
            if known or not alike or min(seen.presence, again.presence) < _BEGINS:
                continue
            begun = _Track(again)
            if not _same(again.mask, list(scores)) and begun.goes_on(row, again):
                scores[begun] = score
                for earlier, past in reversed(before):
                    seen = segment(past, begun.seen.body_px)
                    others = [one.masks[earlier] for one in tracks if earlier in one.masks]
                    shown = any(overlap(_decoded(mask), seen.mask) > _SAME for mask in others)
                    if shown or not begun.goes_on(earlier, seen):
                        break
                begun.seen = again
                tracks.append(begun)
        for track, score in scores.items() if looks is not None else ():
            track.scores.append(score)
        live = list(scores)
        before.append((row, image))
    tracks = [one for one in tracks if max(one.scores) >= _SURE and sum(one.scores) >= _TOGETHER]
    for row in range(before[-1][0] + 1 if before else 0):
        masks = [_decoded(one.masks[row]) for one in tracks if row in one.masks]
        mask = np.max(masks, axis=0) if masks else None
        yield None if mask is None or np.mean(mask >= 128) > _LARGEST else mask


def _same(mask: Image, tracks: list[_Track]) -> list[_Track]:
    return [track for track in tracks if overlap(mask, track.seen.mask) > _SAME]


def overlap(mask: Image, other: Image) -> float:
    """Intersection over union of two masks."""
    both, either = (int(np.sum(how(mask, other) >= 128)) for how in (np.minimum, np.maximum))
    return both / max(either, 1)


def _decoded(mask: Image) -> Image:
    return np.asarray(cv2.imdecode(mask, cv2.IMREAD_GRAYSCALE), np.uint8)


def _reduced(image: Image) -> Image:
    scale = min(_LONG_PX / max(image.shape[:2]), 1.0)
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(small, cv2.COLOR_GRAY2RGB) if small.ndim == 2 else small)
