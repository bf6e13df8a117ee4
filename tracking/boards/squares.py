"""What boards of black and white squares share: a grid of saddles whose colours alternate.

Saddle corners, where two black and two white squares meet: refining and checking them.

Points are printed coordinates in the board frame (metres, y up); pixels as the house has them.
Sub-pixel places come from OpenCV's ``cornerSubPix`` (Förstner's gradient orthogonality); where blur
is wide beside the squares, from quadrics (Lucchese & Mitra 2002).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import cached_property, partial
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.corners import Board, BoardCorners
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import grey_levels

# Up-left, up-right, down-right, down-left of a corner, in the board frame.
_DIAGONALS = np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
_RIGHT, _UP = np.eye(2)
_WINDOW_PX, _WINDOW_SHARE = (2, 11), 0.7
_STOP = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
_LEAST_CONTRAST, _COMPARABLE = 1.0 / 3.0, 0.5
_UNLIKE, _TIMES_UNLIKE = 0.1, 2.5
"""Of the contrast, and of what noise makes of the others: what a saddle half covered differs by
from itself turned round. Open ones differ by less than 0.07, those half a pixel off by 0.14."""
_HALF_WINDOW = np.stack(np.meshgrid(np.linspace(-0.8, 0.8, 8), np.linspace(0.1, 0.8, 4)), axis=-1)
_BLURRED = 0.95
"""Of the contrast at the end of what is clear about a corner, what sharp squares have within it."""
_ROUNDS, _SAMPLES = 4, 7
_GOES_ON = 3
"""Corners on a line beyond a board's edge that are no chance."""


def refine_saddles(
    image: GrayImage,
    points_m: FloatArray,
    corners_px: FloatArray,
    black_up_left: NDArray[np.bool_],
    clear_m: float,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Refine corners to the saddles near them.

    Args:
        image: grey image.
        points_m: ``(n, 2)`` the corners on the board, n at least 4 and not all on one line.
        corners_px: ``(n, 2)`` where they are, to a pixel or two.
        black_up_left: ``(n,)`` whether the square above and left of the corner is black.
        clear_m: how far from a corner along x and y the print is nothing but its four squares.

    Returns:
        places ``(n, 2)``, and a mask ``(n,)`` of those that look like the print there: inside the
        image, coloured as expected with at least a third of the usual contrast, the same turned by
        180 degrees, and not drawn away from where they were expected by more than the window.
    """
    homography = plane_homography(points_m, corners_px)
    if homography is None:
        return corners_px, np.zeros(len(corners_px), bool)
    reach = _lengths_px(homography, points_m, clear_m)
    window = int(np.clip(_WINDOW_SHARE * np.median(reach), *_WINDOW_PX))
    inside = _inside(image, corners_px, window + 1)
    places = corners_px.copy()
    if inside.any():
        refined = cv2.cornerSubPix(
            image,
            corners_px[inside].astype(np.float32).reshape(-1, 1, 2),
            (window, window),
            (-1, -1),
            _STOP,
        )
        places[inside] = refined.reshape(-1, 2)
    seen = partial(contrast, image, points_m, black_up_left=black_up_left, homography=homography)
    signal = seen(places, offset_m=0.6 * clear_m)
    if np.median(signal) < _BLURRED * np.median(seen(places, offset_m=clear_m)):
        half_px = _WINDOW_SHARE * float(np.median(reach))
        places, saddle = _blurred_saddles(image, corners_px, half_px)
        inside &= saddle
        signal = seen(places, offset_m=0.6 * clear_m)
    near = np.linalg.norm(places - corners_px, axis=1) <= window
    most = float(signal.max())
    usual = float(np.median(signal[signal >= _COMPARABLE * most])) if most > 0.0 else 0.0
    good = inside & near & (signal >= max(_LEAST_CONTRAST * usual, 1.0))
    unlike = _asymmetry(image, points_m, places, homography, clear_m)
    noise = float(np.median(unlike[good])) if good.any() else 0.0
    return places, good & (unlike <= max(_UNLIKE * usual, _TIMES_UNLIKE * noise))


def _asymmetry(
    image: GrayImage,
    points_m: FloatArray,
    corners_px: FloatArray,
    homography: FloatArray,
    clear_m: float,
) -> FloatArray:
    """Grey levels ``(n,)``, root mean square, between what is about a corner and that turned round.

    Black and white squares, blurred or not, look the same; what covers one of them does not, nor
    does a print about a place beside its corner.
    """
    offsets = clear_m * _HALF_WINDOW.reshape(-1, 2)
    about = points_m[:, None] + np.concatenate([offsets, -offsets])
    shift = map_plane(homography, about) - map_plane(homography, points_m)[:, None]
    levels = grey_levels(image, corners_px[:, None] + shift)
    apart = levels[:, : len(offsets)] - levels[:, len(offsets) :]
    return np.asarray(np.sqrt(0.5 * np.mean(apart**2, axis=1)), np.float64)


def _blurred_saddles(
    image: GrayImage, corners_px: FloatArray, half_px: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Saddles ``(n, 2)`` of quadrics fitted to the levels about corners, and where there is one.

    ``cornerSubPix`` asks gradients to be square to the way to the corner. So they are along edges;
    on a saddle that blur has made of them they are not, and it goes away from it. The quadric's is
    as good from squares of 8 px on that are blurred by a tenth of a side, and holds up to a third.
    """
    steps = np.linspace(-half_px, half_px, _SAMPLES)
    x, y = (grid.ravel() for grid in np.meshgrid(steps, steps))
    weight = np.exp(-(x**2 + y**2) / half_px**2)[:, None]
    basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    fitted = np.linalg.pinv(weight * basis) * weight.T
    places, saddle = corners_px.copy(), np.ones(len(corners_px), bool)
    for _ in range(_ROUNDS):
        levels = grey_levels(image, places[:, None] + np.stack([x, y], axis=-1))
        _, b, c, d, e, f = fitted @ levels.T
        depth = 4.0 * d * f - e * e
        saddle &= depth < 0.0
        step = np.stack([e * c - 2.0 * f * b, e * b - 2.0 * d * c], axis=-1)
        step /= np.where(saddle, depth, -np.inf)[:, None]
        places = places + np.clip(step, -half_px, half_px)
    return places, saddle


def contrast(
    image: GrayImage,
    points_m: FloatArray,
    corners_px: FloatArray,
    black_up_left: NDArray[np.bool_],
    offset_m: float,
    homography: FloatArray | None = None,
) -> FloatArray:
    """Grey levels ``(n,)`` by which the white squares at each corner outshine the black ones.

    Negative where the colours are the other way round; near zero where there is no saddle. The
    smaller of the two whites against the larger of the two blacks decides.
    """
    if homography is None:
        homography = plane_homography(points_m, corners_px)
    if homography is None:
        return np.zeros(len(corners_px))
    around = points_m[:, None] + offset_m * _DIAGONALS
    probes = (
        corners_px[:, None]
        + map_plane(homography, around)
        - map_plane(homography, points_m)[:, None]
    )
    levels = grey_levels(image, probes)
    first, second = levels[:, 0::2], levels[:, 1::2]
    whites = np.where(black_up_left[:, None], second, first)
    blacks = np.where(black_up_left[:, None], first, second)
    upright = whites.min(axis=1) - blacks.max(axis=1)
    reversed_ = blacks.min(axis=1) - whites.max(axis=1)
    signed: FloatArray = np.where(reversed_ > 0.0, -reversed_, upright)
    return signed


def plane_homography(points_m: FloatArray, corners_px: FloatArray) -> FloatArray | None:
    """Board to pixels; None where the corners lie on one line or on one spot."""
    homography, _ = cv2.findHomography(points_m, corners_px, 0)
    return cast("FloatArray | None", homography)


def map_plane(homography: FloatArray, points: FloatArray) -> FloatArray:
    """Pixels ``(*, 2)`` of points ``(*, 2)`` on the board."""
    mapped = points @ homography[:, :2].T + homography[:, 2]
    plane: FloatArray = mapped[..., :2] / mapped[..., 2:]
    return plane


def _lengths_px(homography: FloatArray, points_m: FloatArray, length_m: float) -> FloatArray:
    """The shorter of the two sides, in pixels, that a square of `length_m` has at each point."""
    here = map_plane(homography, points_m)
    across = map_plane(homography, points_m + length_m * _RIGHT) - here
    along = map_plane(homography, points_m + length_m * _UP) - here
    shorter: FloatArray = np.minimum(
        np.linalg.norm(across, axis=-1), np.linalg.norm(along, axis=-1)
    )
    return shorter


def _inside(image: GrayImage, places: FloatArray, margin: int) -> NDArray[np.bool_]:
    height, width = image.shape
    limit = np.array([width - 1 - margin, height - 1 - margin])
    return cast("NDArray[np.bool_]", ((places >= margin) & (places <= limit)).all(axis=-1))


class SquaresBoard(Board):
    """Inner corners in rows and columns, numbered row by row as printed."""

    square_m: float

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

    @property
    def corner_reach_m(self) -> float:
        """How far from a corner the print has a part in where it is seen, metres."""
        return _WINDOW_SHARE * self._clear_m

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

    def confirms(
        self, image: GrayImage, corners: BoardCorners, project: Callable[[FloatArray], FloatArray]
    ) -> bool:
        """Whether the board ends where the corners' numbers say, in the image.

        A grid explains a board's corners as well from whole squares beside its place; then lines
        of corners go on beyond its edge on one side, and are missing on the other.
        """
        if len(corners) == len(self.points_m):
            return True
        across, down = self._inner
        row, column = np.divmod(np.arange((across + 2) * (down + 2)), across + 2) - np.array(
            [[1], [1]]
        )
        sides = np.stack([column < 0, column == across, row < 0, row == down])
        around = sides.sum(axis=0) == 1
        points = np.stack([column, -row, np.zeros_like(row)], axis=-1)[around] * self.square_m
        points = np.concatenate([points, corners.points_m])
        px = project(points)
        if not np.isfinite(px).all():
            return True
        seen = np.rint(points[:, :2] / self.square_m).astype(np.int64)
        black = (seen.sum(axis=1) % 2 == 0) != self._white_first
        _, good = refine_saddles(image, points[:, :2], px, black, self._clear_m)
        beyond = sides[:, around] & good[: np.count_nonzero(around)]
        return bool(beyond.sum(axis=1).max() < _GOES_ON)

    @property
    def _white_first(self) -> bool:
        """Whether the square above and left of the first corner is white."""
        return False

    def _black_up_left(self, ids: IntArray) -> NDArray[np.bool_]:
        row, column = np.divmod(ids, self._inner[0])
        return cast("NDArray[np.bool_]", ((row + column) % 2 == 0) != self._white_first)
