"""How many circles a grid in images has, and how its rows stand: told from their count.

An image that shows a grid whole shows as many blobs as the product of its columns and rows, and
seldom a few more. So each way to write such a count as a product is tried, symmetric and shifted,
and holds where one homography of the plane puts all circles where they are seen.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.boards.circles import CircleGrid
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import grey_levels

_FEWEST, _MOST, _LONGEST = 3, 400, 40
_BESIDE = 2
"""Blobs beside a grid that are allowed for."""
_IMAGES = 6
_STEPS, _SQUARE = 27, 1.2
_ASKEW = 0.08
"""Of the distance of neighbours, RMS: what lens distortion leaves of a right guess."""


def circles_seen(images: Sequence[GrayImage]) -> CircleGrid | None:
    """The grid of circles that most of some images show, its spacing 1; None where none does.

    Its diameter is not told: half of the spacing. A symmetric grid's longer way is named first.

    Breaks down for grids that leave the images, and where more than two blobs lie beside them.

    >>> from motorcade.tracking.boards import CircleGrid
    >>> from motorcade.tracking.targets.circles import circles_seen
    >>> circles_seen([CircleGrid(7, 5, 0.03, 0.015).draw(pixels_per_m=1500.0)[0]]).name
    'circles_7x5_1000mm_500mm'
    """
    some = images[:: -(-len(images) // _IMAGES)] if images else ()
    counts = Counter(filter(None, map(_grid_in, some)))
    grid, times = next(iter(counts.most_common(1)), (None, 0))
    return grid if 2 * times >= sum(counts.values()) else None


def _grid_in(image: GrayImage) -> CircleGrid | None:
    blobs = len(cv2.SimpleBlobDetector.create().detect(image))
    if blobs > _MOST:
        return None
    guesses = (
        guess for count in range(blobs, blobs - _BESIDE - 1, -1) for guess in _guesses(count)
    )
    return next((guess for guess in guesses if _fits(guess, image)), None)


def _guesses(count: int) -> Iterator[CircleGrid]:
    """The grids of so many circles, the squarest first."""
    sizes = [
        (count // rows, rows)
        for rows in range(_FEWEST, _LONGEST + 1)
        if count % rows == 0 and _FEWEST <= count // rows <= _LONGEST
    ]
    for columns, rows in sorted(sizes, key=lambda size: (abs(size[0] - size[1]), -size[0])):
        if columns >= rows:
            yield CircleGrid(columns, rows, 1.0, 0.5)
        yield CircleGrid(columns, rows, 1.0, 0.5, asymmetric=True)


def _fits(guess: CircleGrid, image: GrayImage) -> bool:
    seen = replace(guess, diameter_m=0.99).detect(image)
    if seen is None or len(seen) < len(guess.points_m):
        return False
    to_plane, _ = cv2.findHomography(seen.corners_px, seen.points_m[:, :2], 0)
    if to_plane is None:
        return False
    placed = cv2.perspectiveTransform(seen.corners_px.reshape(-1, 1, 2), to_plane)
    off = placed.reshape(-1, 2) - seen.points_m[:, :2]
    return bool(np.sqrt((off**2).sum(axis=1).mean()) <= _ASKEW) and _round(seen, image, to_plane)


def _round(seen: BoardCorners, image: GrayImage, to_plane: FloatArray) -> bool:
    """Whether blobs reach as far along their diagonals as along rows: squares do not."""
    angles = np.radians(np.arange(0.0, 360.0, 45.0))
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    rays = ways[:, None] * np.linspace(0.05, 0.7, _STEPS)[:, None]
    plane = seen.points_m[:, None, None, :2] + rays
    px = cv2.perspectiveTransform(plane.reshape(-1, 1, 2), np.linalg.inv(to_plane))
    levels = np.median(grey_levels(image, px.reshape(*plane.shape[:3], 2)), axis=0)
    dark = (levels < 0.5 * (levels.min() + levels.max())).sum(axis=1)
    return bool(dark[1::2].sum() < _SQUARE * dark[::2].sum())
