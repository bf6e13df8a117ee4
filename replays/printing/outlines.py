"""Outlines of a pattern's black: whole areas, since cells side by side show seams when drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.boards.corners import Pattern

_Corner = tuple[int, int]


def outlines_mm(pattern: Pattern) -> tuple[FloatArray, ...]:
    """Closed polygons round a pattern's black areas and round the white holes in them.

    Returns:
        corners ``(n, 2)`` of each, millimetres from the pattern's origin, x right and y down;
        filled by the even-odd rule they are the black, each bit of it once.

    >>> from motorcade.replays.printing.outlines import outlines_mm
    >>> from motorcade.tracking import Checkerboard
    >>> shapes = outlines_mm(Checkerboard(3, 3, square_m=0.01).pattern)
    >>> len(shapes), shapes[0].min(axis=0)  # eight black squares, one corner above the origin
    (8, array([-10., -10.]))
    """
    follow = _edges(~pattern.white)
    edges_mm = 1e3 * pattern.x_edges_m, 1e3 * pattern.y_edges_m
    shapes = []
    while follow:
        loop = _loop(follow)
        shapes.append(np.array([[edges_mm[0][column], edges_mm[1][row]] for row, column in loop]))
    return tuple(shapes)


def _edges(black: NDArray[np.bool_]) -> dict[_Corner, list[_Corner]]:
    """Where an edge between black and white leads from each corner, black to its right."""
    padded = np.pad(black, 1)
    follow: dict[_Corner, list[_Corner]] = {}
    for row, column in np.argwhere(padded):
        top, left = int(row) - 1, int(column) - 1
        bottom, right = top + 1, left + 1
        for white, start, end in (
            (not padded[row - 1, column], (top, left), (top, right)),
            (not padded[row, column + 1], (top, right), (bottom, right)),
            (not padded[row + 1, column], (bottom, right), (bottom, left)),
            (not padded[row, column - 1], (bottom, left), (top, left)),
        ):
            if white:
                follow.setdefault(start, []).append(end)
    return follow


def _loop(follow: dict[_Corner, list[_Corner]]) -> list[_Corner]:
    """Take one closed outline out of `follow`; of its straight runs only the ends are kept.

    Where two black cells touch by a corner it turns right, and so stays with the cell it follows.
    """
    start = min(follow)
    loop: list[_Corner] = [start]
    heading = (0, 0)
    while True:
        here = loop[-1]
        ends = follow[here]
        turned = (heading[1], -heading[0])  # right of (down, right) steps
        right = (here[0] + turned[0], here[1] + turned[1])
        end = right if right in ends else ends[0]
        ends.remove(end)
        if not ends:
            del follow[here]
        step = (end[0] - here[0], end[1] - here[1])
        if step == heading:
            loop.pop()
        heading = step
        if end == start:
            return loop
        loop.append(end)
