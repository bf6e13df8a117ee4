"""Grids of checkerboard corners in one image: where a board ends, and where only the view ends.

A detector's grid is a seed. Lines of it that are no saddles are dropped: a line printed beside a
board, or a screen's edge, has the colours in turn on one side only. Then it grows by extrapolated
lines as long as most of their corners are saddles, which carries it through glare. Each side then
either ends (a ring of squares in turn, and no saddles behind it) or is open: it leaves the image,
or something hides it. A grid that ends on all sides is a whole board, and tells its size; any other
tells the least that it is.

Which corners of a known checkerboard a part shows: a part with a left end and a top end has its
place, one that is open at the left and at the right may be anywhere between; the colours of the
squares rule out every second place. Where more than one place is left the part is not used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.checkerboard import QUICK, Checkerboard
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.images import grey_levels

_FEWEST, _MOST, _SEED = 3, 60, 1
_PROBE = 0.3
"""Of a square: how far from a corner, along both sides, the four colours are compared."""
_RING = 0.75
"""Of a square: how far beyond its innermost corners an outer square must still have its colour."""
_DRAWN = 0.25
"""Of a square: how far a saddle may lie from where its neighbours say."""
_BENT = 0.03
"""Of a square, RMS for each corner along the longer side: more than lenses bend a plane."""
_LEAST_LEVELS = 4.0
_LEAST_SHARE = 0.1
_MIDDLE = np.linspace(0.2, 0.8, 7)
"""Of a square, where its grey levels are compared."""
_WINDOW_PX = (2, 11)
_STOP = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 20, 1e-2)
_QUARTERS = 4
_MOSTLY = 0.5


@dataclass(frozen=True, eq=False)
class SeenGrid:
    """Corners of a checkerboard in an image.

    Fields:
        corners_px: ``(rows, columns, 2)``.
        seen: ``(rows, columns)`` which of them look like corners; the others are extrapolated.
        ended: whether the board ends at the top, right, bottom and left of the grid.
    """

    corners_px: FloatArray
    seen: NDArray[np.bool_]
    ended: tuple[bool, bool, bool, bool]

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows, the longer way first."""
        rows, columns = sorted(self.seen.shape)
        return columns, rows

    @property
    def whole(self) -> bool:
        """Whether it ends on all sides."""
        return all(self.ended)


def seed_grid(gray: GrayImage, size: tuple[int, int] | None = None) -> FloatArray | None:
    """Corners ``(rows, columns, 2)`` as OpenCV finds them, None where it finds none.

    Without a size the largest grid that its sector-based detector grows (Duda & Frese 2018); with
    one, columns and rows, what its detector by contours finds of it.
    """
    if size is not None:
        success, corners = cv2.findChessboardCorners(gray, size, flags=QUICK)
        return np.asarray(corners, np.float64).reshape(*size[::-1], 2) if success else None
    flags = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_NORMALIZE_IMAGE
    cv2.setRNGSeed(_SEED)  # the detector draws random numbers: the same image, the same grid
    success, corners, grid = cv2.findChessboardCornersSBWithMeta(gray, (_FEWEST, _FEWEST), flags)[
        :3
    ]
    if not success or grid is None or max(grid.shape[:2]) > _MOST:
        return None
    return np.asarray(corners, np.float64).reshape(*grid.shape[:2], 2)


def grown_grid(gray: GrayImage, seed_px: FloatArray | None) -> SeenGrid | None:
    """Drop a grid's lines that are no saddles, and add those that are; None where nothing stays.

    Args:
        gray: the image.
        seed_px: ``(rows, columns, 2)`` corners in it, at least 3 by 3, or None.
    """
    if seed_px is None:
        return None
    image = cv2.blur(gray, (3, 3))
    contrast = _contrast(image, seed_px)
    least = max(_LEAST_LEVELS, _LEAST_SHARE * float(np.median(contrast)))
    grid, seen = _trimmed(seed_px, contrast >= least)
    if min(seen.shape) < _FEWEST or seen.mean() < _MOSTLY:
        return None
    ended = []
    for _ in range(_QUARTERS):  # each side is the top one once: turned, it is the one at the right
        ends = None
        while ends is None and len(grid) <= _MOST:
            line, good, inside = _next_line(image, grid, least)
            if good.sum() >= max(2.0, _MOSTLY * inside.sum()):
                grid = np.concatenate([line[None], grid])
                seen = np.concatenate([good[None], seen])
            else:
                ends = bool(inside.mean() > _MOSTLY) and _ringed(image, grid, seen[0], least)
        ended.append(bool(ends))
        grid, seen = np.rot90(grid), np.rot90(seen)
    if not _plane(grid, seen):
        return None
    return SeenGrid(grid, seen, (ended[0], ended[1], ended[2], ended[3]))


def printed_squares(gray: GrayImage, seen: SeenGrid) -> bool:
    """Whether most white squares of a grid are not plainly white, as where markers stand in them.

    A marker's border, or its cells, lie within the middle of its square, whatever its size.
    """
    grid = seen.corners_px
    square = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, :-1], grid[1:, 1:]], axis=2)
    share = np.stack(np.meshgrid(_MIDDLE, _MIDDLE), axis=-1).reshape(-1, 1, 2)
    weights = np.abs(np.array([[1, 1], [0, 1], [1, 0], [0, 0]]) - share).prod(axis=-1)
    levels = grey_levels(cv2.blur(gray, (3, 3)), weights @ square)
    even = np.indices(levels.shape[:2]).sum(axis=0) % 2 == 0
    first, second = sorted((levels[even], levels[~even]), key=np.median)
    step = float(np.median(second) - np.median(first))
    return bool(np.median(np.ptp(second, axis=-1)) > _MOSTLY * step)


def _plane(grid: FloatArray, seen: NDArray[np.bool_]) -> bool:
    """Whether corners are a plane's, as far as a lens leaves its lines straight."""
    squares = np.argwhere(seen)[:, ::-1].astype(np.float64)
    to_squares, _ = cv2.findHomography(grid[seen], squares, 0)
    if to_squares is None:
        return False
    off = cv2.perspectiveTransform(grid[seen][None], to_squares)[0] - squares
    return bool(np.sqrt((off**2).sum(axis=-1).mean()) <= _BENT * max(seen.shape))


def _trimmed(grid: FloatArray, seen: NDArray[np.bool_]) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Without outer lines of which less than half are saddles."""
    left = _QUARTERS
    while left and min(seen.shape) >= _FEWEST:
        if seen[0].mean() < _MOSTLY:
            grid, seen, left = grid[1:], seen[1:], _QUARTERS
        else:
            grid, seen, left = np.rot90(grid), np.rot90(seen), left - 1
    return grid, seen


def _next_line(
    image: GrayImage, grid: FloatArray, least: float
) -> tuple[FloatArray, NDArray[np.bool_], NDArray[np.bool_]]:
    """The line before the first of a grid: corners ``(columns, 2)``, which look it, which can."""
    guess = 3.0 * grid[0] - 3.0 * grid[1] + grid[2]  # keeps perspective and distortion
    sides = np.linalg.norm(guess - grid[0], axis=-1)
    reach = np.ceil(_PROBE * sides)[:, None]
    limit = np.array(image.shape[::-1]) - 1.0
    inside = ((guess >= reach) & (guess <= limit - reach)).all(axis=-1)
    line = guess.copy()
    if inside.any():
        window = int(np.clip(0.35 * np.median(sides), *_WINDOW_PX))
        start = np.ascontiguousarray(guess[inside][:, None], np.float32)
        line[inside] = cv2.cornerSubPix(image, start, (window, window), (-1, -1), _STOP)[:, 0]
    near = inside & (np.linalg.norm(line - guess, axis=-1) <= _DRAWN * sides)
    line = np.where(near[:, None], line, guess)
    contrast = _contrast(image, np.concatenate([line[None], grid]))[0]
    return line, near & (contrast >= least), inside


def _ringed(image: GrayImage, grid: FloatArray, seen: NDArray[np.bool_], least: float) -> bool:
    """Whether whole squares lie beyond the first line of a grid, their colours in turn."""
    out = grid[0] - grid[1]
    middles = 0.5 * (grid[0, 1:] + grid[0, :-1])
    beyond = 0.5 * (out[1:] + out[:-1])
    step = grey_levels(image, middles + _RING * beyond) - grey_levels(image, middles - 0.5 * beyond)
    turned = step * (-1.0) ** np.arange(len(step))
    turned *= np.sign(np.median(turned))
    asked = seen[1:] & seen[:-1]
    return bool(np.count_nonzero((turned >= least)[asked]) > _MOSTLY * np.count_nonzero(asked))


def _contrast(image: GrayImage, grid: FloatArray) -> FloatArray:
    """Levels ``(rows, columns)`` by which the white squares at each corner outshine the black.

    The darker of the two whites against the lighter of the two blacks, the colours in turn from
    corner to corner as most of the grid has them; below zero where there is no saddle.
    """
    down, across = (np.asarray(step) for step in np.gradient(grid, axis=(0, 1)))
    ways = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]])
    probes = grid[:, :, None] + _PROBE * (
        ways[:, :1] * down[:, :, None] + ways[:, 1:] * across[:, :, None]
    )
    levels = grey_levels(image, probes)
    fallen, risen = levels[..., 0::2], levels[..., 1::2]  # along the one diagonal, the other
    falling = risen.min(axis=-1) - fallen.max(axis=-1)
    rising = fallen.min(axis=-1) - risen.max(axis=-1)
    even = np.indices(falling.shape).sum(axis=0) % 2 == 0
    first, second = np.where(even, falling, rising), np.where(even, rising, falling)
    signed: FloatArray = first if np.median(first) > np.median(second) else second
    return signed


_FEWEST_CORNERS = 9
_FOUND_AGAIN = 0.8


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
    enough = len(refined) >= max(_FEWEST_CORNERS, _FOUND_AGAIN * len(places[0]))
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
