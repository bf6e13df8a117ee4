"""How markers stand on a board: grids and ChArUco boards, told from ids and corners alone.

A guess of the layout (how many columns, where the first row begins, whether rows run down or up)
says where each id stands. The plane homography of an image from these places to the markers'
centres then maps the markers' own corners back, where they must be squares of one size in the
middle of their cells, all turned alike. A wrong guess leaves them askew. What no guess explains is
no board known here: its markers stand anywhere, and are mapped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.markers import MarkerGrid
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.families import OPENCV_FAMILIES, layout

_FEWEST_MARKERS = 4
_MOST_COLUMNS = 40
_MOST_IMAGES = 8
_ASKEW = 0.08
"""Of a marker's side, RMS: what lens distortion and a quad's corners leave of a right guess."""
_ASKEW_ANYWHERE = 0.2
_CORNERS = np.array([[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]])


@dataclass(frozen=True, eq=False)
class SeenMarkers:
    """Markers of one image: ids ``(m,)`` and corners ``(m, 4, 2)`` px, clockwise from top left.

    >>> import numpy as np
    >>> from motorcade.tracking.targets import SeenMarkers
    >>> len(SeenMarkers(np.array([3]), np.zeros((1, 4, 2))).ids)
    1
    """

    ids: IntArray
    corners_px: FloatArray

    def undistorted(self, camera: Camera) -> SeenMarkers:
        """As a camera without a lens's distortion sees them; without those beyond its reach."""
        corners = camera.undistort(self.corners_px.reshape(-1, 2)).reshape(-1, 4, 2)
        whole = np.isfinite(corners).all(axis=(1, 2))
        return SeenMarkers(self.ids[whole], corners[whole])


@dataclass(frozen=True)
class _Guess:
    """A layout: columns, the id of its first marker, what kind of board, and its variant.

    A variant of a grid has ids that rise upwards, one of a ChArUco board a white first square.
    """

    columns: int
    first_id: int
    charuco: bool
    variant: bool = False

    def cells(self, ids: IntArray) -> FloatArray:
        """Column and row ``(m, 2)`` at which ids stand; rows of upward grids are negative."""
        if not self.charuco:
            row, column = np.divmod(ids - self.first_id, self.columns)
            row = -row if self.variant else row
            return np.stack([column, row], axis=-1).astype(np.float64)
        pair, place = np.divmod(ids, self.columns)  # two rows of squares hold `columns` markers
        above = (self.columns + self.variant) // 2
        lower = place >= above
        row = 2 * pair + lower
        column = 2 * np.where(lower, place - above, place) + (lower == self.variant)
        return np.stack([column, row], axis=-1).astype(np.float64)

    @classmethod
    def of(cls, board: MarkerGrid | CharucoBoard) -> _Guess:
        """The layout of a board."""
        if isinstance(board, MarkerGrid):
            return cls(board.columns, board.first_id, charuco=False, variant=board.order == "up")
        return cls(board.columns, 0, charuco=True, variant=board.legacy and board.rows % 2 == 0)


@dataclass(frozen=True)
class LayoutFit:
    """How an image's markers stand in the cells of a layout.

    Fields:
        askew: RMS of how far they are from squares within their cells, in sides; infinite where
            the cells lie on a line, or no homography maps them.
        side: of a marker, in pitches of the cells.
        turned_deg: clockwise, of all markers in their cells.
        side_px: of a marker in the image.
    """

    askew: float
    side: float = 0.0
    turned_deg: int = 0
    side_px: float = 0.0

    @property
    def good(self) -> bool:
        """Whether the layout explains the image."""
        return self.askew <= _ASKEW


def layout_fits(
    board: MarkerGrid | CharucoBoard, seen: Sequence[SeenMarkers], camera: Camera | None = None
) -> list[LayoutFit]:
    """How the layout of a board fits each image that tells; straightened where a camera is given.

    >>> import numpy as np
    >>> from motorcade.tracking import MarkerGrid
    >>> from motorcade.tracking.targets import SeenMarkers
    >>> from motorcade.tracking.targets.layouts import layout_fits
    >>> board = MarkerGrid("tag36h11", 4, 3, marker_m=0.06, gap_m=0.03)
    >>> corners = 900.0 * board.points_m[:, :2].reshape(-1, 4, 2) * [1.0, -1.0]
    >>> [fit] = layout_fits(board, [SeenMarkers(board.marker_ids, corners)])
    >>> fit.good, round(float(fit.side), 3), fit.turned_deg
    (True, 0.667, 0)
    """
    guess = _Guess.of(board)
    telling = [one for one in _telling(seen) if _spanning(guess.cells(one.ids))]
    if camera is not None:
        telling = [one.undistorted(camera) for one in telling]
    fits = [_fit(guess, one) for one in telling]
    return [fit for fit in fits if np.isfinite(fit.side_px) and fit.side_px > 0.0]


def _spanning(cells: FloatArray) -> bool:
    """Whether cells ``(m, 2)`` give a homography: no line holds all of them but one."""
    rests = (np.delete(cells, row, axis=0) for row in range(len(cells)))
    return all(np.linalg.matrix_rank(rest - rest[0]) == 2 for rest in rests)


def board_of_markers(family: str, seen: Sequence[SeenMarkers]) -> MarkerGrid | CharucoBoard | None:
    """The board on which markers stand, its markers or squares of length 1; None: no such board.

    A grid's markers have sides of 1, a ChArUco board's squares. Rows beyond the last marker seen
    are not known, and not needed.

    Args:
        family: of all markers.
        seen: markers of several images; ids that stand twice in an image are not for here.

    Breaks down for a lens that bends straight lines by more than a tenth of a marker's side
    between neighbours, and for fewer than four markers in every image.

    >>> import numpy as np
    >>> from motorcade.tracking import MarkerGrid
    >>> from motorcade.tracking.targets import SeenMarkers
    >>> from motorcade.tracking.targets.layouts import board_of_markers
    >>> print_ = MarkerGrid("tag36h11", 4, 3, marker_m=0.05, gap_m=0.02, first_id=8)
    >>> corners = 900.0 * print_.points_m[:, :2].reshape(-1, 4, 2) * [1.0, -1.0]
    >>> found = board_of_markers("tag36h11", [SeenMarkers(print_.marker_ids, corners)])
    >>> found.columns, found.rows, found.first_id, round(found.gap_m, 3)
    (4, 3, 8, 0.4)
    """
    rich = _telling(seen)
    if not rich:
        return None
    ids = np.unique(np.concatenate([one.ids for one in rich]))
    guesses = [one for one in _guesses(family, ids) if _fit(one, rich[0]).good]
    fitting = [one for one in guesses if all(_fit(one, other).good for other in rich)]
    if not fitting:
        return None
    best = min(fitting, key=lambda guess: (guess.columns, guess.first_id > 0, -guess.first_id))
    fits = [_fit(best, other) for other in rich]
    share = float(np.median([fit.side for fit in fits]))
    turned = fits[0].turned_deg
    return (
        _made(family, best, ids, share, turned)
        if {turned} == {one.turned_deg for one in fits}
        else None
    )


def regapped(board: MarkerGrid, seen: Sequence[SeenMarkers], camera: Camera) -> MarkerGrid:
    """A grid with the gaps that its markers show once the lens is known.

    Args:
        board: the grid, its columns and ids right.
        seen: its markers, in images of that camera.
        camera: undistorts their corners.

    >>> import numpy as np
    >>> from motorcade.tracking import Camera, MarkerGrid
    >>> from motorcade.tracking.targets import SeenMarkers, regapped
    >>> print_ = MarkerGrid("tag36h11", 4, 3, marker_m=0.05, gap_m=0.02)
    >>> corners = 900.0 * print_.points_m[:, :2].reshape(-1, 4, 2) * [1.0, -1.0] + 50.0
    >>> seen = [SeenMarkers(print_.marker_ids, corners)]
    >>> camera = Camera(400, 300, 500.0, 500.0, 199.5, 149.5)
    >>> round(regapped(MarkerGrid("tag36h11", 4, 3, 1.0, 0.35), seen, camera).gap_m, 6)
    0.4
    """
    shares = [fit.side for fit in layout_fits(board, seen, camera) if np.isfinite(fit.askew)]
    if not shares:
        return board
    return replace(board, gap_m=board.marker_m * max(1.0 / float(np.median(shares)) - 1.0, 0.0))


def _telling(seen: Sequence[SeenMarkers]) -> list[SeenMarkers]:
    """Some images with many markers, and of the others those that show further ids."""
    many = [one for one in seen if len(one.ids) >= _FEWEST_MARKERS]
    kept: list[SeenMarkers] = []
    known: set[int] = set()
    for markers in sorted(many, key=lambda other: -len(other.ids)):
        if len(kept) < _MOST_IMAGES or not known.issuperset(markers.ids.tolist()):
            kept.append(markers)
            known.update(markers.ids.tolist())
    return kept


def _guesses(family: str, ids: IntArray) -> Iterator[_Guess]:
    first = int(ids[0])
    span = int(ids[-1]) - first + 1
    for columns in range(1, min(_MOST_COLUMNS, span) + 1):
        for place in range(min(columns, first + 1)):
            for upwards in (False, True):
                yield _Guess(columns, first - place, charuco=False, variant=upwards)
    if family in OPENCV_FAMILIES:
        for columns in range(3, _MOST_COLUMNS + 1):
            for white_first in (False, True):
                yield _Guess(columns, 0, charuco=True, variant=white_first)


def _fit(guess: _Guess, seen: SeenMarkers) -> LayoutFit:
    sides_px = np.linalg.norm(np.diff(seen.corners_px, axis=1), axis=-1)
    side_px = float(np.median(sides_px)) if len(seen.ids) >= _FEWEST_MARKERS else np.nan
    none = LayoutFit(np.inf, side_px=side_px)
    if not np.isfinite(side_px):
        return none
    cells = guess.cells(seen.ids) * (1.0, -1.0)
    spread = np.linalg.svd(cells - cells.mean(axis=0), compute_uv=False)
    if spread[1] < 0.5:
        return LayoutFit(np.inf)
    to_cells, _ = cv2.findHomography(_crossings(seen.corners_px), cells, 0)
    if to_cells is None or not np.isfinite(to_cells).all():
        return none
    corners = cv2.perspectiveTransform(seen.corners_px.reshape(-1, 1, 2), to_cells)
    inside = corners.reshape(-1, 4, 2) - cells[:, None]
    turned = [np.roll(_CORNERS, -quarter, axis=0) for quarter in range(4)]
    sums = [float((inside * one).sum()) for one in turned]
    quarter = int(np.argmax(sums))
    side = sums[quarter] / (len(cells) * (_CORNERS**2).sum())
    if not 0.05 < side < 1.0:
        return none
    off = np.sqrt((((inside - side * turned[quarter]) / side) ** 2).sum(axis=-1).mean(axis=-1))
    askew = float(np.median(off)) if off.max() <= _ASKEW_ANYWHERE else np.inf
    return LayoutFit(askew, side, 90 * quarter, side_px)


def _crossings(corners_px: FloatArray) -> FloatArray:
    """Where the diagonals cross ``(m, 2)``: the centre of a square, seen from anywhere."""
    ones = np.ones((*corners_px.shape[:2], 1))
    first, second, third, fourth = np.moveaxis(np.concatenate([corners_px, ones], axis=-1), 1, 0)
    crossing = np.cross(np.cross(first, third), np.cross(second, fourth))
    places: FloatArray = crossing[:, :2] / crossing[:, 2:]
    return places


def _made(
    family: str, guess: _Guess, ids: IntArray, share: float, turned_deg: int
) -> MarkerGrid | CharucoBoard | None:
    """The board of a guess; None where it would hold more markers than the family."""
    cells = guess.cells(ids)
    rows = int(np.abs(cells[:, 1]).max()) + 1
    try:
        if guess.charuco:
            rows = max(rows + rows % 2 if guess.variant else rows, 3)
            board = CharucoBoard(family, guess.columns, rows, 1.0, share, guess.variant)
            return board if turned_deg == 0 else None
        margin = layout(family).margin / layout(family).side_cells
        gap = max(1.0 / share - 1.0, 2.0 * margin)
        order: Literal["down", "up"] = "up" if guess.variant else "down"
        return MarkerGrid(family, guess.columns, rows, 1.0, gap, guess.first_id, order, turned_deg)
    except ValueError:
        return None
