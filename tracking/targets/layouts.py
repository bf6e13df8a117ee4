"""How markers stand on a board: grids and ChArUco boards, told from ids and corners alone.

A guess of the layout (how many columns, and where the first row begins) says where each id stands.
The plane homography of a picture from these places to the markers' centres then maps the markers'
own corners back, where they must be upright squares of one size in the middle of their cells. A
wrong guess leaves them askew. What no guess explains is no board known here: its markers stand
anywhere, and are mapped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.markers import MarkerGrid
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.families import OPENCV_FAMILIES, layout

_FEWEST_MARKERS = 4
_MOST_COLUMNS = 40
_MOST_PICTURES = 8
_ASKEW = 0.08
"""Of a marker's side, RMS: what lens distortion and a quad's corners leave of a right guess."""
_ASKEW_ANYWHERE = 0.2
_CORNERS = np.array([[-0.5, 0.5], [0.5, 0.5], [0.5, -0.5], [-0.5, -0.5]])


@dataclass(frozen=True, eq=False)
class SeenMarkers:
    """Markers of one picture: ids ``(m,)`` and corners ``(m, 4, 2)`` px, clockwise from top left.

    >>> import numpy as np
    >>> from motorcade.tracking.targets import SeenMarkers
    >>> len(SeenMarkers(np.array([3]), np.zeros((1, 4, 2))).ids)
    1
    """

    ids: IntArray
    corners_px: FloatArray


@dataclass(frozen=True)
class _Guess:
    """A layout: columns, the id of its first marker, whether it is a ChArUco board."""

    columns: int
    first_id: int
    charuco: bool

    def cells(self, ids: IntArray) -> FloatArray:
        """Column and row ``(m, 2)`` at which ids stand."""
        if not self.charuco:
            row, column = np.divmod(ids - self.first_id, self.columns)
            return np.stack([column, row], axis=-1).astype(np.float64)
        pair, place = np.divmod(ids, self.columns)  # two rows of squares hold `columns` markers
        above = self.columns // 2
        lower = place >= above
        row = 2 * pair + lower
        column = np.where(lower, 2 * (place - above), 2 * place + 1)
        return np.stack([column, row], axis=-1).astype(np.float64)


def board_of_markers(family: str, seen: Sequence[SeenMarkers]) -> MarkerGrid | CharucoBoard | None:
    """The board on which markers stand, its markers or squares of length 1; None: no such board.

    A grid's markers have sides of 1, a ChArUco board's squares. Rows beyond the last marker seen
    are not known, and not needed.

    Args:
        family: of all markers.
        seen: markers of several pictures; ids that stand twice in a picture are not for here.

    Breaks down for a lens that bends straight lines by more than a tenth of a marker's side
    between neighbours, and for fewer than four markers in every picture.

    >>> import numpy as np
    >>> from motorcade.tracking import MarkerGrid
    >>> from motorcade.tracking.targets import SeenMarkers, board_of_markers
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
    guesses = [one for one in _guesses(family, ids) if _fits(one, rich[0])]
    fitting = [one for one in guesses if all(_fits(one, other) for other in rich)]
    if not fitting:
        return None
    best = min(fitting, key=lambda one: (one.columns, one.first_id > 0, -one.first_id))
    share = float(np.median([_askew(best, other)[1] for other in rich]))
    return _made(family, best, ids, share)


def regapped(board: MarkerGrid, seen: Sequence[SeenMarkers], camera: Camera) -> MarkerGrid:
    """A grid with the gaps that its markers show once the lens is known.

    Args:
        board: the grid, its columns and ids right.
        seen: its markers, in pictures of that camera.
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
    guess = _Guess(board.columns, board.first_id, charuco=False)
    rich = [one for one in seen if len(one.ids) >= _FEWEST_MARKERS]
    straight = [SeenMarkers(one.ids, camera.undistort(one.corners_px)) for one in rich]
    found = [_askew(guess, one) for one in straight if np.isfinite(one.corners_px).all()]
    sides = [(side, off) for off, side in found if np.isfinite(off)]
    if not sides:
        return board
    share = float(np.median([side for side, _ in sides]))
    return replace(board, gap_m=board.marker_m * max(1.0 / share - 1.0, 0.0))


def _telling(seen: Sequence[SeenMarkers]) -> list[SeenMarkers]:
    """Some pictures with many markers, and of the others those that show further ids."""
    many = [one for one in seen if len(one.ids) >= _FEWEST_MARKERS]
    kept: list[SeenMarkers] = []
    known: set[int] = set()
    for one in sorted(many, key=lambda one: -len(one.ids)):
        if len(kept) < _MOST_PICTURES or not known.issuperset(one.ids.tolist()):
            kept.append(one)
            known.update(one.ids.tolist())
    return kept


def _guesses(family: str, ids: IntArray) -> Iterator[_Guess]:
    first = int(ids[0])
    span = int(ids[-1]) - first + 1
    for columns in range(1, min(_MOST_COLUMNS, span) + 1):
        for place in range(min(columns, first + 1)):
            yield _Guess(columns, first - place, charuco=False)
    if family in OPENCV_FAMILIES:
        for columns in range(3, _MOST_COLUMNS + 1):
            yield _Guess(columns, 0, charuco=True)


def _fits(guess: _Guess, seen: SeenMarkers) -> bool:
    return _askew(guess, seen)[0] <= _ASKEW


def _askew(guess: _Guess, seen: SeenMarkers) -> tuple[float, float]:
    """How far markers are from upright squares within their cells, RMS in sides; and the side.

    Infinite where the cells lie on a line, or no homography maps them.
    """
    cells = guess.cells(seen.ids) * (1.0, -1.0)
    centres = _crossings(seen.corners_px)
    spread = np.linalg.svd(cells - cells.mean(axis=0), compute_uv=False)
    if spread[1] < 0.5:
        return np.inf, 0.0
    to_cells, _ = cv2.findHomography(centres, cells, 0)
    if to_cells is None or not np.isfinite(to_cells).all():
        return np.inf, 0.0
    corners = cv2.perspectiveTransform(seen.corners_px.reshape(-1, 1, 2), to_cells)
    inside = corners.reshape(-1, 4, 2) - cells[:, None]
    side = float((inside * _CORNERS).sum() / (len(cells) * (_CORNERS**2).sum()))
    if not 0.05 < side < 1.0:
        return np.inf, 0.0
    off = np.sqrt((((inside - side * _CORNERS) / side) ** 2).sum(axis=-1).mean(axis=-1))
    return (float(np.median(off)) if off.max() <= _ASKEW_ANYWHERE else np.inf), side


def _crossings(corners_px: FloatArray) -> FloatArray:
    """Where the diagonals cross ``(m, 2)``: the centre of a square, seen from anywhere."""
    ones = np.ones((*corners_px.shape[:2], 1))
    first, second, third, fourth = np.moveaxis(np.concatenate([corners_px, ones], axis=-1), 1, 0)
    crossing = np.cross(np.cross(first, third), np.cross(second, fourth))
    places: FloatArray = crossing[:, :2] / crossing[:, 2:]
    return places


def _made(
    family: str, guess: _Guess, ids: IntArray, share: float
) -> MarkerGrid | CharucoBoard | None:
    """The board of a guess; None where it would hold more markers than the family."""
    cells = guess.cells(ids)
    rows = int(cells[:, 1].max()) + 1
    try:
        if guess.charuco:
            return CharucoBoard(family, guess.columns, max(rows, 3), 1.0, share)
        gap = 1.0 / share - 1.0
        margin = layout(family).margin / layout(family).side_cells
        return MarkerGrid(family, guess.columns, rows, 1.0, max(gap, 2.0 * margin), guess.first_id)
    except ValueError:
        return None
