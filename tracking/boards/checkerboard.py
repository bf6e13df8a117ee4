"""Checkerboards: black and white squares, found whole, numbered by their colours.

The printed picture has a black square above and left of its first inner corner. Turned by 180
degrees a board with an odd sum of inner columns and rows has a white one there, so its numbering
is unique. With an even sum (and, for as many columns as rows, under quarter turns too) the print
looks the same turned: then the numbering is the one whose rows run most nearly to the right in
the picture, and `aligned` keeps it steady over time; no picture can tell which way such a board
was printed.

How large a board looks is told too, whether the print goes on beyond what is described, or ends: a
board that is described too small can be found as a part of the print, one too large where chance
or the edge of the print lends corners. Poses then come out, and are wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import BoardCorners, Pattern
from motorcade.tracking.boards.squares import SquaresBoard, contrast, refine_saddles
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, check_count, check_length, checked_gray
from motorcade.tracking.measurements import MarkerObservation

QUICK = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
_CLEAR_SHARE = 0.45


@dataclass(frozen=True)
class Checkerboard(SquaresBoard):
    """A checkerboard of `columns` by `rows` inner corners with squares of `square_m`.

    Raises:
        ValueError: fewer than 3 columns or rows, or a square that is not above zero.

    >>> from motorcade.tracking import Checkerboard
    >>> board = Checkerboard(columns=9, rows=6, square_m=0.03)
    >>> board.points_m[[0, 8, 53]]  # first, last of the first row, last of all: y is up as printed
    array([[ 0.  ,  0.  ,  0.  ],
           [ 0.24,  0.  ,  0.  ],
           [ 0.24, -0.15,  0.  ]])
    >>> picture, origin_px = board.draw(pixels_per_m=1000.0)
    >>> len(board.detect(picture))
    54
    """

    columns: int
    rows: int
    square_m: float

    def __post_init__(self) -> None:
        check_count(self.columns, "Checkerboard.columns", 3)
        check_count(self.rows, "Checkerboard.rows", 3)
        check_length(self.square_m, "Checkerboard.square_m")

    @property
    def name(self) -> str:
        """For example ``checkerboard_9x6_40mm``."""
        return f"checkerboard_{self.columns}x{self.rows}_{self.square_m * 1e3:g}mm"

    @property
    def _inner(self) -> tuple[int, int]:
        return self.columns, self.rows

    @property
    def _clear_m(self) -> float:
        return _CLEAR_SHARE * self.square_m

    @cached_property
    def pattern(self) -> Pattern:
        """The squares as cells; the quiet zone is half a square wide."""
        white = np.indices((self.rows + 1, self.columns + 1)).sum(axis=0) % 2 == 1
        x_edges = self.square_m * np.arange(-1.0, self.columns + 1.0)
        y_edges = self.square_m * np.arange(-1.0, self.rows + 1.0)
        return Pattern(white, x_edges, y_edges, 0.5 * self.square_m)

    def detect(self, image: GrayImage, camera: Camera | None = None) -> BoardCorners | None:
        """Find all inner corners; None unless every one is seen.

        A quick search by contours goes first, the slower and more robust sector-based one
        (Duda & Frese 2018) where it fails. `camera` is not needed.

        Raises:
            ValueError: not a grey uint8 picture.
        """
        size = (self.columns, self.rows)
        found, raw = cv2.findChessboardCorners(checked_gray(image), size, flags=QUICK)
        if not found:
            cv2.setRNGSeed(1)  # it draws random numbers: the same picture, the same corners
            found, raw = cv2.findChessboardCornersSB(image, size, flags=0)
        if not found:
            return None
        grid = raw.astype(np.float64).reshape(self.rows, self.columns, 2)
        numbered = self._numbered(image, grid)
        return None if numbered is None else self.refine_corners(image, numbered)

    def aligned(self, corners: BoardCorners, expected_px: FloatArray) -> BoardCorners:
        """Of the numberings that the colours allow, the one nearest to the expected pixels."""
        distances = [
            np.linalg.norm(expected_px[turn[corners.ids]] - corners.corners_px, axis=-1).mean()
            for turn in self.turns
        ]
        turned = self.turns[int(np.argmin(distances))][corners.ids]
        order = np.argsort(turned)
        ids = turned[order]
        return BoardCorners(ids, corners.corners_px[order], self.points_m[ids])

    def coloured_alike(self, image: GrayImage, corners: BoardCorners) -> bool:
        """Whether most corners have the colours about them that their numbers say."""
        signal = contrast(
            image,
            corners.points_m[:, :2],
            corners.corners_px,
            self._black_up_left(corners.ids),
            0.5 * _CLEAR_SHARE * self.square_m,
        )
        return bool(np.median(signal) > 0.0)

    @cached_property
    def turns(self) -> list[IntArray]:
        """Renumberings ``new_id = turn[old_id]`` under which the print looks the same."""
        grid = np.arange(self.columns * self.rows).reshape(self.rows, self.columns)
        even_sum = (self.columns + self.rows) % 2 == 0
        quarter = self.columns == self.rows and self.columns % 2 == 0
        quarters = [0, 1, 2, 3] if quarter else [0, 2] if even_sum else [0]
        return [np.rot90(grid, k).ravel() for k in quarters]

    def _numbered(self, image: GrayImage, grid: FloatArray) -> BoardCorners | None:
        """Number a raw grid ``(rows, columns, 2)`` so that it is unmirrored, coloured as printed,
        and upright where the colours leave a choice.
        """
        across = grid[:, -1].mean(axis=0) - grid[:, 0].mean(axis=0)
        down = grid[-1].mean(axis=0) - grid[0].mean(axis=0)
        if across[0] * down[1] - across[1] * down[0] < 0.0:
            grid = grid[::-1]
        quarters = range(4) if self.columns == self.rows else (0, 2)
        ids = np.arange(self.columns * self.rows)
        best: tuple[float, FloatArray] | None = None
        for quarter in quarters:
            turned = np.rot90(grid, quarter)
            corners = turned.reshape(-1, 2)
            coloured = self.coloured_alike(image, BoardCorners(ids, corners, self.points_m))
            rightward = float((turned[:, -1] - turned[:, 0])[:, 0].mean())
            if coloured and (best is None or rightward > best[0]):
                best = (rightward, corners)
        return None if best is None else BoardCorners(ids, best[1], self.points_m)


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
