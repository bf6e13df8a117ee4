"""Grids of black circles, symmetric or asymmetric, as OpenCV, Kalibr and calib.io print them.

Rows of a symmetric grid stand below each other. Of an asymmetric one `spacing_m` is the distance of
its rows, circles of a row stand twice that apart, and every second row is shifted by one spacing to
the right. Places are the circles' own centres: a perspective image moves the middle of an ellipse
away from them, so dark areas are balanced on the board's plane and not in the image.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import Board, BoardCorners, Pattern
from motorcade.tracking.boards.squares import map_plane, plane_homography
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, check_count, check_length, checked_gray
from motorcade.tracking.images import grey_levels

_CELLS = 48
"""Cells of the printed pattern across a circle."""
_SAMPLES, _ROUNDS = 33, 3
_LEAST_CONTRAST, _LEAST_LEVELS = 1.0 / 3.0, 4.0


@dataclass(frozen=True)
class CircleGrid(Board):
    """A grid of `columns` by `rows` circles; OpenCV's 4 by 11 is the usual asymmetric one.

    The first circle is the frame's origin. A symmetric grid looks the same turned round, as does
    an asymmetric one with an even count of rows (see `checkerboard`).

    Raises:
        ValueError: fewer than 3 columns or rows, lengths not above zero, or circles that touch.

    >>> from motorcade.tracking.boards import CircleGrid
    >>> board = CircleGrid(columns=4, rows=5, spacing_m=0.02, diameter_m=0.014, asymmetric=True)
    >>> board.points_m[4]  # the first of the second row
    array([ 0.02, -0.02,  0.  ])
    >>> len(board.detect(board.draw(pixels_per_m=2000.0)[0]))
    20
    """

    columns: int
    rows: int
    spacing_m: float
    diameter_m: float
    asymmetric: bool = False

    def __post_init__(self) -> None:
        for key in ("columns", "rows"):
            check_count(getattr(self, key), f"CircleGrid.{key}", 3)
        for key in ("spacing_m", "diameter_m"):
            check_length(getattr(self, key), f"CircleGrid.{key}")
        if self.diameter_m >= self._nearest_m:
            raise ValueError(
                f"CircleGrid.diameter_m: expected less than {self._nearest_m:g}, between the "
                f"centres of neighbours, got {self.diameter_m}"
            )

    @property
    def name(self) -> str:
        """For example ``circles_7x5_30mm_15mm``, ``circles_4x11_20mm_16mm_asymmetric``."""
        lengths = f"{self.spacing_m * 1e3:g}mm_{self.diameter_m * 1e3:g}mm"
        return f"circles_{self.columns}x{self.rows}_{lengths}" + "_asymmetric" * self.asymmetric

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height over all circles, metres."""
        across, down = self.points_m[:, :2].max(axis=0) - self.points_m[:, :2].min(axis=0)
        return float(across) + self.diameter_m, float(down) + self.diameter_m

    @cached_property
    def points_m(self) -> FloatArray:
        """Centres ``(n, 3)``, row by row as printed."""
        row, column = np.divmod(np.arange(self.columns * self.rows), self.columns)
        if self.asymmetric:
            column = 2 * column + row % 2
        points = np.stack([column, -row, np.zeros_like(row)], axis=-1) * self.spacing_m
        points.setflags(write=False)
        return points

    @property
    def _nearest_m(self) -> float:
        """Between the centres of neighbours."""
        return self.spacing_m * (2.0**0.5 if self.asymmetric else 1.0)

    @cached_property
    def pattern(self) -> Pattern:
        """Circles as small cells; the quiet zone is as wide as the gap between circles."""
        cell_m = self.diameter_m / _CELLS
        centres = self.points_m[:, :2] * [1.0, -1.0] / cell_m + 0.5 * _CELLS
        columns, rows = np.ceil(centres.max(axis=0) + 0.5 * _CELLS).astype(int).tolist()
        white = np.ones((rows, columns), np.uint8)
        for centre in np.rint((centres - 0.5) * 256.0).astype(int).tolist():
            cv2.circle(white, centre, 128 * (_CELLS - 1), 0, -1, cv2.LINE_8, 8)
        edges = [cell_m * (np.arange(cells + 1) - 0.5 * _CELLS) for cells in (columns, rows)]
        return Pattern(white > 0, edges[0], edges[1], self._nearest_m - self.diameter_m)

    def detect(self, image: GrayImage, camera: Camera | None = None) -> BoardCorners | None:
        """Find all circles; None unless every one is seen. `camera` is not needed.

        Raises:
            ValueError: not a grey uint8 image.
        """
        kind = cv2.CALIB_CB_ASYMMETRIC_GRID if self.asymmetric else cv2.CALIB_CB_SYMMETRIC_GRID
        gray = checked_gray(image)
        for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
            seen, raw = cv2.findCirclesGrid(gray, (self.columns, self.rows), flags=flags)
            if seen:
                return self._numbered(gray, np.asarray(raw, np.float64).reshape(-1, 2))
        return None

    def _numbered(self, image: GrayImage, px: FloatArray) -> BoardCorners | None:
        """Circles numbered unmirrored, and upright where the print leaves a choice; refined."""
        grid = px.reshape(self.rows, self.columns, 2)
        across = (grid[:, -1] - grid[:, 0]).mean(axis=0)
        down = grid[-1].mean(axis=0) - grid[0].mean(axis=0)
        if across[0] * down[1] - across[1] * down[0] < 0.0:
            grid = grid[::-1]
        px, right_m = grid.reshape(-1, 2), self.points_m[:, 0] - self.points_m[:, 0].mean()
        turn = max(self.turns, key=lambda turned: float(px[turned, 0] @ right_m))
        numbered = BoardCorners(np.arange(len(px)), px[turn], self.points_m)
        sharp = self.refine_corners(image, numbered)
        return sharp if sharp.spanning else None

    @cached_property
    def turns(self) -> list[IntArray]:
        """Renumberings ``new_id = turn[old_id]`` under which the print looks the same."""
        grid = np.arange(self.columns * self.rows).reshape(self.rows, self.columns)
        if self.asymmetric:
            quarters = [0] if self.rows % 2 else [0, 2]
        else:
            quarters = [0, 1, 2, 3] if self.columns == self.rows else [0, 2]
        return [np.rot90(grid, quarter).ravel() for quarter in quarters]

    def refine_corners(
        self, image: GrayImage, corners: BoardCorners, camera: Camera | None = None
    ) -> BoardCorners:
        """Put each centre where the dark area about it balances, on the board's plane.

        Needs four that span the board. Those that leave the image, or have no contrast, are left
        out. `camera` is not needed.
        """
        if not corners.spanning:
            return corners.keep(np.zeros(len(corners), bool))
        px, good = self._balanced(image, corners.points_m[:, :2], corners.corners_px)
        return corners.at(px).keep(good)

    def _balanced(
        self, image: GrayImage, plane_m: FloatArray, px: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Refined centres ``(n, 2)`` px, and which of them are circles, all within the image."""
        homography = plane_homography(plane_m, px)
        if homography is None:
            return px, np.zeros(len(px), bool)
        axis = np.linspace(-0.5, 0.5, _SAMPLES) * self._nearest_m
        square = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
        around = square[np.linalg.norm(square, axis=1) <= 0.5 * self._nearest_m]
        bent = px - map_plane(homography, plane_m)  # what a lens adds there
        moved = np.zeros_like(plane_m)
        for _ in range(_ROUNDS):
            probes = map_plane(homography, (plane_m + moved)[:, None] + around) + bent[:, None]
            levels = grey_levels(image, probes)
            black, white = np.percentile(levels, (5, 95), axis=1)
            contrast = white - black
            dark = (white[:, None] - levels) / np.maximum(contrast, 1.0)[:, None]
            weight = np.clip(2.0 * dark - 0.5, 0.0, 1.0)
            moved += weight @ around / np.maximum(weight.sum(axis=1), 1e-9)[:, None]
        limit = np.array(image.shape[::-1]) - 1.0
        inside = ((probes >= 0.0) & (probes <= limit)).all(axis=(1, 2))
        near = np.linalg.norm(moved, axis=1) <= 0.5 * self.diameter_m
        least = max(_LEAST_CONTRAST * float(np.median(contrast)), _LEAST_LEVELS)
        places = map_plane(homography, plane_m + moved) + bent
        return places, inside & near & (contrast >= least)

    def confirms(
        self, image: GrayImage, corners: BoardCorners, project: Callable[[FloatArray], FloatArray]
    ) -> bool:
        """True: a grid is only ever found whole, and no circle moves by half of a diameter."""
        return True
