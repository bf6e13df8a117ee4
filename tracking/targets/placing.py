"""Which corners of a known checkerboard an image shows, where it shows a part of it.

A part says where it lies by the sides at which the board ends: a part with a left end and a top end
has its place, one that is open at the left and at the right may be anywhere between. The colours of
the squares rule out every second place. Where more than one place is left the part is not used: a
numbering is never off by whole squares because one place was the likeliest.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.targets.grids import SeenGrid, grown_grid, seed_grid

_FEWEST_CORNERS = 9
_MOSTLY = 0.8


def corners_in_view(board: Checkerboard, image: GrayImage) -> BoardCorners | None:
    """Corners of a checkerboard, all of them or the part in view; None where that has no one place.

    Args:
        board: known by its inner corners.
        image: grey uint8 image, in which the board may be cut off, or partly hidden.

    Breaks down where something covers the board just along its squares: it then seems to end there.
    Its place is then wrong by whole squares, unless the opposite side is in view, too.

    Raises:
        ValueError: not a grey uint8 image.

    >>> from motorcade.tracking import Checkerboard
    >>> from motorcade.tracking.targets import corners_in_view
    >>> board = Checkerboard(8, 5, 0.03)
    >>> image, _ = board.draw(pixels_per_m=1500.0)
    >>> part = corners_in_view(board, image[:, :300])  # its right side is cut off
    >>> sorted({int(corner) % 8 for corner in part.ids})
    [0, 1, 2, 3, 4]
    """
    gray = checked_gray(image)
    grid = grown_grid(gray, seed_grid(gray))
    places = [] if grid is None else list(_places(board, gray, _unmirrored(grid)))
    if not places or any(not _same_print(board, places[0].ids, other.ids) for other in places):
        return None
    refined = board.refine_corners(gray, max(places, key=_rightward))
    enough = len(refined) >= max(_FEWEST_CORNERS, _MOSTLY * len(places[0]))
    return refined if enough and refined.spanning else None


def _unmirrored(grid: SeenGrid) -> SeenGrid:
    """The same with its columns to the right where its rows go down."""
    corners = grid.corners_px
    across, down = corners[0, -1] - corners[0, 0], corners[-1, 0] - corners[0, 0]
    if across[0] * down[1] - across[1] * down[0] > 0.0:
        return grid
    top, right, bottom, left = grid.ended
    return SeenGrid(corners[::-1], grid.seen[::-1], (bottom, right, top, left))


def _places(board: Checkerboard, gray: GrayImage, grid: SeenGrid) -> Iterator[BoardCorners]:
    """The numberings of a grid that the board's ends and the colours of its squares allow."""
    numbers = np.arange(board.rows * board.columns).reshape(board.rows, board.columns)
    for quarter in range(4):
        px, seen = np.rot90(grid.corners_px, quarter), np.rot90(grid.seen, quarter)
        top, right, bottom, left = np.roll(grid.ended, -quarter)
        more_rows, more_columns = board.rows - seen.shape[0], board.columns - seen.shape[1]
        for row, column in np.ndindex(max(more_rows + 1, 0), max(more_columns + 1, 0)):
            if (top and row) or (bottom and row < more_rows):
                continue
            if (left and column) or (right and column < more_columns):
                continue
            block = numbers[row : row + seen.shape[0], column : column + seen.shape[1]]
            ids = block[seen]
            corners = BoardCorners(ids, px[seen], board.points_m[ids])
            if board.coloured_alike(gray, corners):
                yield corners


def _same_print(board: Checkerboard, ids: IntArray, other: IntArray) -> bool:
    """Whether two numberings differ by a turn under which the print looks the same."""
    return any(np.array_equal(np.sort(turn[ids]), other) for turn in board.turns)


def _rightward(corners: BoardCorners) -> float:
    """How far the board's rows run to the right, by the covariance of both."""
    x_m, x_px = corners.points_m[:, 0], corners.corners_px[:, 0]
    return float(np.cov(x_m, x_px)[0, 1])
