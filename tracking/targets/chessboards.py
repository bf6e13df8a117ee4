"""How many inner corners a checkerboard has, by what several images and two detectors say.

OpenCV's sector-based detector (Duda & Frese 2018) needs no size: what it finds is grown or trimmed
to where the board ends (`targets.grids`), and an image in which that is on all sides votes for its
size. Every size with votes is then asked of the product's own detector, which must find it by its
size in images of its own. The best supported is taken, the others are told.

Where no image shows the end on all sides, the largest extent is taken that most images do not
deny, and said to be the least that the board is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.ga.progress import track
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.images import shrunk
from motorcade.tracking.targets.grids import SeenGrid, grown_grid, printed_squares, seed_grid

_LONGEST_PX = 1280
_LEAST_SHARE = 0.2
_MOST_ASKED = 6
_MOST_SIZES = 4
_MOST_SECOND = 2
_MOSTLY = 0.8


@dataclass(frozen=True)
class CountedBoard:
    """A checkerboard and where it was counted.

    Fields:
        columns, rows: inner corners, the longer way first.
        images: rising indices of those that show all of them.
        others: sizes that a fair share of the images shows instead.
        ends: whether some images show where it ends on all sides; without, it may be larger.
        plain: whether nothing is printed in its white squares.

    >>> from motorcade.tracking import Checkerboard
    >>> from motorcade.tracking.targets.chessboards import checkerboard_seen
    >>> image, _ = Checkerboard(7, 5, 0.03).draw(pixels_per_m=1500.0)
    >>> checkerboard_seen([image, image])
    CountedBoard(columns=7, rows=5, images=(0, 1), others=(), ends=True, plain=True)
    """

    columns: int
    rows: int
    images: tuple[int, ...]
    others: tuple[tuple[int, int], ...] = ()
    ends: bool = True
    plain: bool = True

    @property
    def board(self) -> Checkerboard:
        """The board with squares of length 1."""
        return Checkerboard(self.columns, self.rows, 1.0)

    @property
    def doubt(self) -> str:
        """Why the count may be wrong, and how to say it; empty where nothing speaks against it."""
        if self.others:
            sizes = [f"{columns} x {rows}" for columns, rows in self.others]
            why, columns, rows = f"other images show {', '.join(sizes)}", *self.others[0]
        elif not self.ends:
            why, columns, rows = "no image shows all its sides", self.columns + 1, self.rows
        else:
            return ""
        count = f"the board is counted as {self.columns} x {self.rows}"
        return (
            f"{count}, but {why}: if it is another, name it: --board checkerboard_{columns}x{rows}"
        )


def checkerboard_seen(
    images: Sequence[GrayImage], stated: tuple[int, int] | None = None
) -> CountedBoard | None:
    """Count the inner corners of the checkerboard that images show; None where they show none.

    Args:
        images: grey uint8 ``(height, width)``. Of three and more, at least two must agree, and a
            fifth of those that show any checkerboard.
        stated: columns and rows that are looked for first, in a tenth of the time; an image counts
            by them only where the board ends about them on all sides.

    Raises:
        ValueError: not grey uint8 images.
    """
    small = [shrunk(checked_gray(image), _LONGEST_PX) for image in images]
    every = track(small, "counting squares", len(small))
    grids = [_first(image, stated) for image in every]
    for size in _for_second(grids):
        grids = [_better(grid, image, size) for grid, image in zip(grids, small, strict=True)]
    shown = [grid for grid in grids if grid is not None]
    least = max(1 if len(images) < 3 else 2, _LEAST_SHARE * len(shown))
    votes = Counter(grid.size for grid in shown if grid.whole)
    agreed = [size for size, count in votes.most_common(_MOST_SIZES) if count >= least]
    sure = [size for size in agreed if _confirmed(size, grids, small)]
    plain = not any(
        printed_squares(image, grid) for image, grid in zip(small, grids, strict=True) if grid
    )
    if sure:
        return CountedBoard(*sure[0], _showing(sure[0], grids), tuple(sure[1:]), plain=plain)
    for size in _extents(shown):
        rows = _showing(size, grids)
        fitting = sum(_fits(grid, size) for grid in shown)
        if fitting >= _MOSTLY * len(shown) and len(rows) >= min(least, 2):
            return CountedBoard(*size, rows, ends=False, plain=plain)
    return None


def _first(image: GrayImage, stated: tuple[int, int] | None) -> SeenGrid | None:
    """The grid that an image shows, by the stated size where the board ends about it."""
    grid = None if stated is None else grown_grid(image, seed_grid(image, stated))
    return grid if grid is not None and grid.whole else grown_grid(image, seed_grid(image))


def _for_second(grids: Sequence[SeenGrid | None]) -> list[tuple[int, int]]:
    """Sizes for the second detector: the boards seen whole most often, or the largest extent."""
    shown = [grid for grid in grids if grid is not None]
    whole = Counter(grid.size for grid in shown if grid.whole)
    return [size for size, _ in whole.most_common(_MOST_SECOND)] or _extents(shown)[:1]


def _extents(shown: Sequence[SeenGrid]) -> list[tuple[int, int]]:
    """All sizes of grids, the largest first."""
    return sorted({grid.size for grid in shown}, key=lambda size: (-size[0] * size[1], size))


def _better(grid: SeenGrid | None, image: GrayImage, size: tuple[int, int]) -> SeenGrid | None:
    """A grid, or what the detector by contours finds of a size, where that tells more."""
    if grid is not None and grid.whole:
        return grid
    other = grown_grid(image, seed_grid(image, size))
    return max(
        (grid, other), key=lambda seen: (seen.whole, seen.seen.sum()) if seen else (False, 0)
    )


def _showing(size: tuple[int, int], grids: Sequence[SeenGrid | None]) -> tuple[int, ...]:
    """The images whose grid has this size, whether it ends there or not."""
    return tuple(row for row, grid in enumerate(grids) if grid is not None and grid.size == size)


def _confirmed(
    size: tuple[int, int], grids: Sequence[SeenGrid | None], images: Sequence[GrayImage]
) -> bool:
    """Whether a board of a size is found by it, in half of some images that show so many."""
    shown = _showing(size, grids)
    places = np.unique(np.linspace(0, len(shown) - 1, min(len(shown), _MOST_ASKED)).astype(int))
    board = Checkerboard(*size, 1.0)
    count = sum(board.detect(images[shown[place]]) is not None for place in places)
    return 2 * count >= len(places)


def _fits(grid: SeenGrid, size: tuple[int, int]) -> bool:
    """Whether a board of a size may be what a grid shows."""
    (rows, columns), (top, right, bottom, left) = grid.seen.shape, grid.ended
    return any(
        (rows == down if top and bottom else rows <= down)
        and (columns == across if left and right else columns <= across)
        for across, down in (size, size[::-1])
    )
