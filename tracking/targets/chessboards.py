"""How many inner corners a checkerboard has, by counting them in several pictures.

Each picture gives the largest grid of saddles that OpenCV grows from what it finds (Duda & Frese
2018). A board that lies partly outside, or behind something, gives a smaller one; so the largest
grid is taken that a fair share of the pictures agrees on, and it must be found again by its size.
What lies beside a print may lend it a line of corners by chance: then more pictures count the print
without it, and the print is found by its own size even where the larger grid was counted, as no
part of a larger board would be.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.pictures import shrunk

_LONGEST_PX = 1280
_FEWEST = 3
_MOST = 60
_LEAST_SHARE = 0.2
_MOST_ASKED = 6


@dataclass(frozen=True)
class CountedBoard:
    """A checkerboard and where it was counted.

    Fields:
        columns, rows: inner corners, the longer way first.
        pictures: rising indices of those that show all of it.

    >>> from motorcade.tracking import Checkerboard
    >>> from motorcade.tracking.targets import checkerboard_seen
    >>> picture, _ = Checkerboard(7, 5, 0.03).draw(pixels_per_m=1500.0)
    >>> checkerboard_seen([picture, picture])
    CountedBoard(columns=7, rows=5, pictures=(0, 1))
    """

    columns: int
    rows: int
    pictures: tuple[int, ...]

    @property
    def board(self) -> Checkerboard:
        """The board with squares of length 1."""
        return Checkerboard(self.columns, self.rows, 1.0)


def checkerboard_seen(pictures: Sequence[GrayImage]) -> CountedBoard | None:
    """Count the inner corners of the checkerboard that pictures show; None where they show none.

    Args:
        pictures: grey uint8 ``(height, width)``. Of three and more, at least two must agree, and a
            fifth of those that show any checkerboard.

    Raises:
        ValueError: not grey uint8 pictures.
    """
    sizes = [_counted(shrunk(checked_gray(one), _LONGEST_PX)) for one in pictures]
    votes = Counter(size for size in sizes if size is not None)
    least = max(1 if len(pictures) < 3 else 2, _LEAST_SHARE * votes.total())
    agreed = [size for size, count in votes.items() if size is not None and count >= least]
    for size in sorted(agreed, key=lambda one: (-_area(one), -votes[one])):
        shown = tuple(index for index, one in enumerate(sizes) if one == size)
        some = [shrunk(pictures[index], _LONGEST_PX) for index in _spread(shown)]
        own = _times_found(size, some)
        others = (one for one in agreed if votes[one] > votes[size] and _area(one) < _area(size))
        if any(_times_found(one, some) >= max(own, 1) for one in others):
            continue
        return CountedBoard(*size, shown) if 2 * own >= len(some) else None
    return None


def _area(size: tuple[int, int]) -> int:
    return size[0] * size[1]


def _spread(rows: Sequence[int]) -> list[int]:
    """A few of them, from the first to the last."""
    places = np.linspace(0, len(rows) - 1, min(len(rows), _MOST_ASKED))
    return [rows[round(one)] for one in places.tolist()]


def _times_found(size: tuple[int, int], pictures: Sequence[GrayImage]) -> int:
    """In how many pictures a board of a size is found whole."""
    board = Checkerboard(*size, 1.0)
    return sum(board.detect(one) is not None for one in pictures)


def _counted(gray: GrayImage) -> tuple[int, int] | None:
    """Inner corners of the largest grid of one picture, the longer way first."""
    flags = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_NORMALIZE_IMAGE
    found, _, grid = cv2.findChessboardCornersSBWithMeta(gray, (_FEWEST, _FEWEST), flags)[:3]
    if not found or grid is None:
        return None
    rows, columns = sorted(grid.shape[:2])
    return (columns, rows) if rows >= _FEWEST and columns <= _MOST else None
