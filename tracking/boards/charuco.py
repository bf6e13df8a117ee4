"""ChArUco boards: a checkerboard whose white squares hold markers, so part of it is enough.

The board is OpenCV's since 4.6: the printed top-left square is black, markers are numbered row by
row. Before, boards with an even number of rows had a white one there (`legacy`). Corners are the
inner corners of the squares, row by row; the frame's origin is the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.boards.corners import BoardCorners, Pattern
from motorcade.tracking.boards.squares import SquaresBoard
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, check_count, check_length, checked_gray
from motorcade.tracking.markers.families import dictionary, family_size, marker_cells


@dataclass(frozen=True)
class CharucoBoard(SquaresBoard):
    """A ChArUco board of `columns` by `rows` squares.

    Args:
        family: one of `families.OPENCV_FAMILIES`; ids count from 0.
        columns, rows: squares across and down (inner corners are one fewer each way).
        square_m: side of a square.
        marker_m: side of a marker's black square, smaller than `square_m`.
        legacy: whether the printed top-left square is white and holds a marker although the
            number of rows is even, as OpenCV printed before 4.6. No difference for odd numbers.

    Raises:
        ValueError: a family that OpenCV does not know or one with too few markers, fewer than 3
            squares either way, lengths not above zero, markers that do not fit into the squares.

    >>> from motorcade.tracking import CharucoBoard
    >>> board = CharucoBoard("aruco_5x5_100", columns=5, rows=4, square_m=0.04, marker_m=0.03)
    >>> image, origin_px = board.draw(pixels_per_m=2000.0)
    >>> len(board.detect(image)), board.name
    (12, 'charuco_aruco_5x5_100_5x4_40mm_30mm')
    """

    family: str
    columns: int
    rows: int
    square_m: float
    marker_m: float
    legacy: bool = False

    def __post_init__(self) -> None:
        check_count(self.columns, "CharucoBoard.columns", 3)
        check_count(self.rows, "CharucoBoard.rows", 3)
        check_length(self.square_m, "CharucoBoard.square_m")
        check_length(self.marker_m, "CharucoBoard.marker_m")
        if self.marker_m >= self.square_m:
            raise ValueError(
                f"CharucoBoard.marker_m: expected less than square_m = {self.square_m}, "
                f"got {self.marker_m}"
            )
        dictionary(self.family)
        needed, size = self.columns * self.rows // 2, family_size(self.family)
        if needed > size:
            raise ValueError(
                f"CharucoBoard.family: {self.family} has {size} markers, this board needs {needed}"
            )

    @property
    def name(self) -> str:
        """For example ``charuco_aruco_4x4_50_7x5_40mm_30mm``."""
        return (
            f"charuco_{self.family}_{self.columns}x{self.rows}"
            f"_{self.square_m * 1e3:g}mm_{self.marker_m * 1e3:g}mm" + "_legacy" * self.legacy
        )

    @property
    def _inner(self) -> tuple[int, int]:
        return self.columns - 1, self.rows - 1

    @property
    def _white_first(self) -> bool:
        """Whether the printed top-left square is white."""
        return self.legacy and self.rows % 2 == 0

    @property
    def _clear_m(self) -> float:
        return min(0.45 * self.square_m, 0.5 * (self.square_m - self.marker_m))

    @cached_property
    def pattern(self) -> Pattern:
        """Squares, margins and bits as cells; the quiet zone is half a square wide."""
        side = len(marker_cells(self.family, 0))
        cells = side + 2
        white = np.zeros((self.rows * cells, self.columns * cells), bool)
        marker = 0
        for row in range(self.rows):
            for column in range(self.columns):
                if (row + column + self._white_first) % 2 == 1:
                    square = np.pad(marker_cells(self.family, marker), 1, constant_values=True)
                    top, left = row * cells, column * cells
                    white[top : top + cells, left : left + cells] = square
                    marker += 1
        return Pattern(
            white, self._edges(self.columns), self._edges(self.rows), 0.5 * self.square_m
        )

    def detect(self, image: GrayImage, camera: Camera | None = None) -> BoardCorners | None:
        """Find the inner corners that are seen; None unless four of them span the board.

        `camera` is not needed.

        Raises:
            ValueError: not a grey uint8 image.
        """
        places, ids, _, _ = _detector(self).detectBoard(checked_gray(image))
        if ids is None or len(ids) == 0:
            return None
        ids = np.ravel(ids)
        order = np.argsort(ids)
        ids, places = ids[order], np.asarray(places, np.float64).reshape(-1, 2)[order]
        corners = BoardCorners(ids, places, self.points_m[ids])
        if not corners.spanning:
            return None
        sharp = self.refine_corners(image, corners)
        return sharp if sharp.spanning else None

    def _edges(self, count: int) -> FloatArray:
        side = len(marker_cells(self.family, 0))
        margin = 0.5 * (self.square_m - self.marker_m)
        inner = margin + np.arange(side + 1) * (self.marker_m / side)
        starts = (np.arange(count)[:, None] - 1) * self.square_m
        edges = (starts + np.concatenate([[0.0], inner])).ravel()
        return np.append(edges, (count - 1) * self.square_m)


@cache
def _detector(board: CharucoBoard) -> cv2.aruco.CharucoDetector:
    family = dictionary(board.family)
    # only the markers on the board: with a large family the search is several times faster
    used = cv2.aruco.Dictionary(
        family.bytesList[: board.columns * board.rows // 2],
        family.markerSize,
        family.maxCorrectionBits,
    )
    printed = cv2.aruco.CharucoBoard(
        (board.columns, board.rows), board.square_m, board.marker_m, used
    )
    printed.setLegacyPattern(board.legacy)
    return cv2.aruco.CharucoDetector(printed)
