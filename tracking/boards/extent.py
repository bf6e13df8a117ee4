"""How large a checkerboard looks: whether the print goes on beyond what is described, or ends.

A board that is described too small can be found as a part of the print, one too large where chance
or the edge of the print lends corners. Poses then come out, and are wrong.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.boards.saddles import refine_saddles
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.measurements import MarkerObservation

__all__ = ["extent_in_picture", "extent_seen"]

_CLEAR_SHARE = 0.45


def extent_seen(board: Checkerboard, observations: Sequence[MarkerObservation]) -> tuple[int, int]:
    """Columns and rows, outer lines left out of which never more than half was seen at once.

    Args:
        board: as described.
        observations: of the board, at least one.
    """
    seen = np.zeros((len(observations), board.rows * board.columns))
    for line, one in zip(seen, observations, strict=True):
        line[one.ids] = 1.0
    grids = seen.reshape(-1, board.rows, board.columns)
    columns, rows = (np.flatnonzero((grids.mean(axis=axis) > 0.5).any(axis=0)) for axis in (1, 2))
    if not (len(columns) and len(rows)):
        return board.columns, board.rows
    return int(np.ptp(columns)) + 1, int(np.ptp(rows)) + 1


def extent_in_picture(
    board: Checkerboard, image: GrayImage, corners_px: FloatArray
) -> tuple[int, int]:
    """Columns and rows that a picture shows: the board's own, or one more of each.

    Each outer line of corners is extrapolated by one, to where the next would lie. It counts where
    every corner of it is a saddle, with the colours in turn.

    Args:
        board: as described, and seen whole.
        image: grey picture.
        corners_px: ``(columns * rows, 2)`` all corners of the board in it.
    """
    across = np.asarray(corners_px).reshape(board.rows, board.columns, 2).swapaxes(0, 1)
    down = across.swapaxes(0, 1)
    more_columns = any(_goes_on(image, lines) for lines in (across, across[::-1]))
    more_rows = any(_goes_on(image, lines) for lines in (down, down[::-1]))
    return board.columns + more_columns, board.rows + more_rows


def _goes_on(image: GrayImage, lines: FloatArray) -> bool:
    """Whether another line of saddles lies before the first of `lines` ``(n, corners, 2)``."""
    further = 3.0 * lines[0] - 3.0 * lines[1] + lines[2]  # keeps perspective and distortion
    grid = np.concatenate([further[None], lines])
    line, place = np.indices(grid.shape[:2]).reshape(2, -1)
    points = np.stack([line, place], axis=-1).astype(np.float64)
    corners, one_way = grid.reshape(-1, 2), (line + place) % 2 == 0
    count = lines.shape[1]
    # Which of the two colourings the board has is left open, as is the hand of the grid.
    return any(
        bool(good[:count].all()) and bool(good[count:].mean() > 0.5)
        for good in (
            refine_saddles(image, points, corners, colours, _CLEAR_SHARE)[1]
            for colours in (one_way, ~one_way)
        )
    )
