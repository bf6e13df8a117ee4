"""What boards of black and white squares share: a grid of saddles whose colours alternate."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.boards.picture import Pattern, draw
from motorcade.tracking.boards.saddles import refine_saddles
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage

__all__ = ["SquaresBoard"]


class SquaresBoard(ABC):
    """Inner corners in rows and columns, numbered row by row as printed."""

    square_m: float

    @property
    @abstractmethod
    def pattern(self) -> Pattern:
        """The printed pattern as black and white cells."""

    @property
    @abstractmethod
    def _inner(self) -> tuple[int, int]:
        """Inner corners across and down."""

    @property
    @abstractmethod
    def _clear_m(self) -> float:
        """How far from a corner along x and y the print is nothing but its four squares."""

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height of all squares, metres."""
        across, down = self._inner
        return (across + 1) * self.square_m, (down + 1) * self.square_m

    @cached_property
    def points_m(self) -> FloatArray:
        """Inner corners ``(n, 3)``, row by row as printed."""
        across, down = self._inner
        row, column = np.divmod(np.arange(across * down), across)
        points = np.stack([column, -row, np.zeros_like(row)], axis=-1) * self.square_m
        points.setflags(write=False)
        return points

    def refine_corners(
        self, image: GrayImage, corners: BoardCorners, camera: Camera | None = None
    ) -> BoardCorners:
        """Refine corners to the saddles near them; those that do not look like one are left out.

        Needs four corners that span the board. `camera` is not needed.
        """
        refined_px, good = refine_saddles(
            image,
            corners.points_m[:, :2],
            corners.corners_px,
            self._black_up_left(corners.ids),
            self._clear_m,
        )
        return corners.at(refined_px).keep(good)

    def draw(self, pixels_per_m: float) -> tuple[GrayImage, tuple[float, float]]:
        """The printed picture with its quiet zone, and the pixel of the first inner corner."""
        return draw(self.pattern, pixels_per_m)

    def _black_up_left(self, ids: IntArray) -> NDArray[np.bool_]:
        row, column = np.divmod(ids, self._inner[0])
        return cast("NDArray[np.bool_]", (row + column) % 2 == 0)
