"""Checkerboards: black and white squares, found whole, numbered by their colours.

The printed image has a black square above and left of its first inner corner. Turned by 180
degrees a board with an odd sum of inner columns and rows has a white one there, so its numbering
is unique. With an even sum (and, for as many columns as rows, under quarter turns too) the print
looks the same turned: then the numbering is the one whose rows run most nearly to the right in
the image, and `aligned` keeps it steady over time; no image can tell which way such a board
was printed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import BoardCorners, Pattern
from motorcade.tracking.boards.squares import SquaresBoard, contrast
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, check_count, check_length, checked_gray

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
    >>> image, origin_px = board.draw(pixels_per_m=1000.0)
    >>> len(board.detect(image))
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
            ValueError: not a grey uint8 image.
        """
        size = (self.columns, self.rows)
        seen, raw = cv2.findChessboardCorners(checked_gray(image), size, flags=QUICK)
        if not seen:
            cv2.setRNGSeed(1)  # it draws random numbers: the same image, the same corners
            seen, raw = cv2.findChessboardCornersSB(image, size, flags=0)
        if not seen:
            return None
        grid = raw.astype(np.float64).reshape(self.rows, self.columns, 2)
        numbered = self._numbered(image, grid)
        return None if numbered is None else self.refine_corners(image, numbered)

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
