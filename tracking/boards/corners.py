"""What every board is to the rest of the room, and what a detection of one holds.

Board frame: origin at the board's first (inner) corner, x to the right as printed, y up as printed,
z out of the printed face; metres. Corners below the first one therefore have negative y. The order
of corners is the board's own, row by row as printed; marker corners run clockwise from the printed
top-left one.

Flat patterns of black and white cells, and images of them drawn by exact area coverage.

A pattern lives in printed coordinates: metres, x right and y down from the board's origin (so
printed y is minus the board frame's y). Images follow the house: pixel (0, 0) is the centre of
the top-left pixel, 0 is black.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive, frozen
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage


@dataclass(frozen=True)
class Pattern:
    """Cells between rising edges.

    Fields:
        white: ``(rows, columns)`` bool, True where the paper stays white.
        x_edges_m, y_edges_m: ``(columns + 1,)`` and ``(rows + 1,)`` edges, metres from the origin.
        quiet_m: width of the white zone that the pattern needs around it, metres.

    >>> from motorcade.tracking import SingleMarker
    >>> pattern = SingleMarker("aruco_4x4_50", 0, side_m=0.06).pattern
    >>> pattern.white.shape, pattern.x_edges_m[-1].item()  # 4 x 4 bits in a black border
    ((6, 6), 0.06)
    """

    white: NDArray[np.bool_]
    x_edges_m: FloatArray
    y_edges_m: FloatArray
    quiet_m: float


def draw(pattern: Pattern, pixels_per_m: float) -> tuple[NDArray[np.uint8], tuple[float, float]]:
    """Draw a pattern at any scale; every pixel is the mean of the paper that it covers.

    Returns:
        the uint8 image, and the pixel ``(column, row)`` of the origin in it: the printed point
        ``(x, y)`` lies at ``origin + pixels_per_m * (x, y)``.

    Raises:
        ValueError: a scale that is not above zero, or too small to give the pattern any pixel.
    """
    checked_positive(pixels_per_m, "pixels_per_m")
    weights, origin = [], []
    for edges in (pattern.x_edges_m, pattern.y_edges_m):
        start = int(np.floor((edges[0] - pattern.quiet_m) * pixels_per_m))
        stop = int(np.ceil((edges[-1] + pattern.quiet_m) * pixels_per_m))
        weights.append(_coverage(edges * pixels_per_m - start, stop - start))
        origin.append(-start - 0.5)
    across, down = weights
    black = down @ (~pattern.white).astype(np.float64) @ across.T
    image = np.rint(255.0 * (1.0 - black)).astype(np.uint8)
    return image, (origin[0], origin[1])


def _coverage(edges_px: FloatArray, pixels: int) -> FloatArray:
    """Share ``(pixels, cells)`` of each pixel's length that each cell covers."""
    left = np.arange(pixels)[:, None]
    overlap = np.minimum(left + 1, edges_px[1:]) - np.maximum(left, edges_px[:-1])
    share: FloatArray = np.clip(overlap, 0.0, 1.0)
    return share


_FLATTEST = 1e-3


@dataclass(frozen=True, eq=False)
class BoardCorners:
    """Corners of a board seen in one image.

    Args:
        ids: ``(n,)`` whole numbers, rising; each is the corner's row in its board's ``points_m``.
        corners_px: ``(n, 2)`` pixels.
        points_m: ``(n, 3)`` board frame, metres.

    Raises:
        ValueError: shapes that do not agree, numbers that are not finite, ids that do not rise.

    >>> import numpy as np
    >>> from motorcade.tracking import Checkerboard
    >>> from motorcade.tracking.boards import BoardCorners
    >>> points_m = Checkerboard(3, 3, 0.05).points_m
    >>> corners = BoardCorners(np.arange(9), 100.0 + 400.0 * points_m[:, :2], points_m)
    >>> corners.spanning, corners.keep(corners.ids < 3).spanning  # a row alone is on one line
    (True, False)
    """

    ids: IntArray
    corners_px: FloatArray
    points_m: FloatArray

    def __post_init__(self) -> None:
        ids = np.array(self.ids)
        if ids.ndim != 1 or (ids.size and ids.dtype.kind not in "iu"):
            raise ValueError(
                f"BoardCorners.ids: expected (n,) whole numbers, got {ids.dtype} {ids.shape}"
            )
        if np.any(np.diff(ids) <= 0):
            raise ValueError("BoardCorners.ids: expected rising numbers, got some out of order")
        ids = ids.astype(np.int64)
        ids.setflags(write=False)
        object.__setattr__(self, "ids", ids)
        for name, width in (("corners_px", 2), ("points_m", 3)):
            field = f"BoardCorners.{name}"
            array = frozen(checked_floats(getattr(self, name), field, (width,)))
            if array.shape != (len(ids), width):
                raise ValueError(f"{field}: expected {(len(ids), width)}, got {array.shape}")
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def spanning(self) -> bool:
        """Whether these are at least four corners that do not all lie on one line."""
        if len(self) < 4:
            return False
        plane = self.points_m[:, :2] - self.points_m[:, :2].mean(axis=0)
        long_side, short_side = np.linalg.svd(plane, compute_uv=False)
        return bool(short_side > _FLATTEST * long_side)

    def keep(self, mask: NDArray[np.bool_]) -> BoardCorners:
        """Only the corners where the mask ``(n,)`` is true."""
        return BoardCorners(self.ids[mask], self.corners_px[mask], self.points_m[mask])

    def at(self, corners_px: FloatArray) -> BoardCorners:
        """The same corners at other pixels ``(n, 2)``."""
        return BoardCorners(self.ids, corners_px, self.points_m)


class Board(ABC):
    """A printed, flat pattern whose corners can be found, refined and drawn.

    >>> from motorcade.tracking import Board, board_named
    >>> board: Board = board_named("checkerboard_9x6_40mm")
    >>> len(board.points_m)
    54
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """A short description that is unique to the board's numbers."""

    @property
    @abstractmethod
    def size_m(self) -> tuple[float, float]:
        """Width and height of the printed area without its quiet zone, metres."""

    @property
    @abstractmethod
    def points_m(self) -> FloatArray:
        """All corners ``(n, 3)`` in the board frame, metres; z is 0."""

    @property
    @abstractmethod
    def pattern(self) -> Pattern:
        """The printed pattern as black and white cells."""

    @abstractmethod
    def detect(self, image: GrayImage, camera: Camera | None = None) -> BoardCorners | None:
        """Find the board in a whole grey image, corners refined; None where it is not seen."""

    @abstractmethod
    def refine_corners(
        self, image: GrayImage, corners: BoardCorners, camera: Camera | None = None
    ) -> BoardCorners:
        """Refine corners that are right to a pixel or two to sub-pixel accuracy.

        Corners that do not look like the print are left out. With a camera, edges that its lens
        bends are undistorted before lines are fitted to them.
        """

    @abstractmethod
    def confirms(
        self, image: GrayImage, corners: BoardCorners, project: Callable[[FloatArray], FloatArray]
    ) -> bool:
        """Whether corners that were tracked are numbered rightly, as far as this image tells.

        Args:
            image: grey image.
            corners: as tracked.
            project: points ``(n, 3)`` of the board to pixels ``(n, 2)``, by the corners' pose.
        """

    @property
    def turns(self) -> list[IntArray]:
        """Renumberings ``new_id = turn[old_id]`` under which the print looks the same."""
        return [np.arange(len(self.points_m))]

    @property
    def unit_m(self) -> float:
        """The length that its kind is counted in: the first of its fields, metres."""
        return float(getattr(self, self._lengths[0]))

    def resized(self, unit_m: float) -> Self:
        """The same print at another size."""
        lengths = {key: getattr(self, key) * unit_m / self.unit_m for key in self._lengths}
        return replace(self, **lengths)  # type: ignore[type-var]

    @property
    def _lengths(self) -> list[str]:
        return [one.name for one in fields(self) if one.name.endswith("_m")]  # type: ignore[arg-type]

    def aligned(self, corners: BoardCorners, expected_px: FloatArray) -> BoardCorners:
        """Of the numberings that the pattern's symmetry allows, the one nearest to expectation.

        ``expected_px`` is ``(len(points_m), 2)``: where each corner of the board is expected.
        Corners that are numbered by markers stay as they are.
        """
        if len(self.turns) == 1:
            return corners
        distances = [
            np.linalg.norm(expected_px[turn[corners.ids]] - corners.corners_px, axis=-1).mean()
            for turn in self.turns
        ]
        turned = self.turns[int(np.argmin(distances))][corners.ids]
        order = np.argsort(turned)
        ids = turned[order]
        return BoardCorners(ids, corners.corners_px[order], self.points_m[ids])

    def draw(self, pixels_per_m: float) -> tuple[GrayImage, tuple[float, float]]:
        """The printed image with its quiet zone, and the pixel of the board's origin in it."""
        return draw(self.pattern, pixels_per_m)
