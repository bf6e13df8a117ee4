"""What hides a part of what is filmed: a hand's stand-in, a sheet of paper, black bars."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from tests.end_to_end.phones.cases import CASES, SEEDS, path_of, phone_of
from tests.end_to_end.phones.clips import stamps_of

__all__ = ["all_but_tag", "left_third", "letterboxed", "third"]

Image = NDArray[np.uint8]
_SEED = SEEDS["judging"]
_GREY = 118


@cache
def _seen(name: str, points: tuple[tuple[float, float, float], ...]) -> FloatArray:
    """Where points of the world are seen in each frame ``(F, n, 2)``."""
    case = next(one for one in CASES if one.name == name)
    phone, path = phone_of(case, _SEED), path_of(case, _SEED)
    stamps = stamps_of(case, _SEED) / 90_000.0
    return np.stack([phone.project(path, float(at), np.array(points)) for at in stamps])


def _corners(left: float, right: float, low: float, high: float) -> tuple[tuple[float, ...], ...]:
    return ((left, low, 0.001), (right, low, 0.001), (right, high, 0.001), (left, high, 0.001))


def third(name: str) -> Callable[[Image, int], Image]:
    """A black sheet over the right third of a clip's board."""
    case = next(one for one in CASES if one.name == name)
    assert case.shows.board is not None
    points = case.shows.board.points_m
    across, down = 0.5 * np.ptp(points[:, :2], axis=0)
    sheet = _corners(across / 3.0, 2.0 * across, -2.0 * down, 2.0 * down)

    def hidden(image: Image, number: int) -> Image:
        outline = np.rint(_seen(name, sheet)[number]).astype(np.int32)  # type: ignore[arg-type]
        return np.asarray(cv2.fillConvexPoly(image.copy(), outline, (8, 8, 8)), np.uint8)

    return hidden


def all_but_tag(marker_id: int) -> Callable[[Image, int], Image]:
    """Grey over everything but one of the loose tags and its white edge."""
    case = next(one for one in CASES if one.name == "loose")
    tag = next(one for one in case.shows.tags if one.marker_id == marker_id)
    reach = 0.75 * case.shows.side_m
    square = tag.world_T_tag().apply(np.array(_corners(-reach, reach, -reach, reach)))
    named = tuple(tuple(one) for one in square.tolist())

    def alone(image: Image, number: int) -> Image:
        outline = np.rint(_seen("loose", named)[number]).astype(np.int32)  # type: ignore[arg-type]
        shown = cv2.fillConvexPoly(np.zeros(image.shape[:2], np.uint8), outline, (1,))
        return np.where(shown[..., None] > 0, image, np.uint8(_GREY))

    return alone


def left_third(image: Image, number: int) -> Image:
    """A black rectangle over the left third of the image, such as a finger before the lens."""
    hidden = image.copy()
    hidden[:, : image.shape[1] // 3] = 8
    return hidden


def letterboxed(image: Image, number: int) -> Image:
    """Black bars above and below, as messengers add them."""
    hidden = image.copy()
    hidden[:60] = hidden[-60:] = 0
    return hidden
