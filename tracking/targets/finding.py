"""What printed target images show, of which nothing was told: the one that tells most."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.boards.circles import CircleGrid
from motorcade.tracking.boards.corners import Board
from motorcade.tracking.boards.markers import MarkerGrid
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.markers.detection import Detection, detect_markers
from motorcade.tracking.targets.chessboards import checkerboard_seen
from motorcade.tracking.targets.families import SMALL_PX, SeenFamily, families_seen
from motorcade.tracking.targets.layouts import SeenMarkers, board_of_markers

_ENOUGH_SHARE = 0.5
"""Of the images: markers seen in so many are not set against a checkerboard."""
_MANY = 12
_TWICE, _TWICE_SHARE = 2, 0.1
"""Images in which an id stands twice, and their share of those that show it, beyond chance."""
_LEAST_SHARE = 0.5
"""Of the images with a ChArUco board's markers, in which its corners must be found as well."""


@dataclass(frozen=True, eq=False)
class FoundTarget:
    """A printed target, of which all but its size is known.

    Fields:
        board: what it is, with squares (of a board of bare markers: marker sides) of length 1;
            None for markers that make up no board known here.
        family: of its markers; None for a checkerboard.
        marker_ids: those seen, rising.
        markers: those of each image searched, sharp ones alone; ids that stand twice left out.
        images: rising indices of the images that show it.
        searched: how many were looked at.
        doubt: why it may be another; empty where nothing speaks against it.
        twice: ids of those that stand twice in some images, rising.

    >>> from motorcade.tracking import Checkerboard
    >>> from motorcade.tracking.targets import find_target
    >>> image, _ = Checkerboard(7, 5, 0.03).draw(pixels_per_m=1500.0)
    >>> find_target([image] * 3).summary
    'a checkerboard of 7 x 5 inner corners, in 3 of 3 images'
    """

    board: Board | None
    family: str | None
    marker_ids: tuple[int, ...]
    markers: tuple[SeenMarkers, ...]
    images: tuple[int, ...]
    searched: int
    doubt: str = ""
    twice: tuple[int, ...] = ()

    @property
    def unit(self) -> str:
        """What a length of 1 is: the side of a square, or of a marker."""
        if isinstance(self.board, CircleGrid):
            return "spacing"
        return "square" if isinstance(self.board, Checkerboard | CharucoBoard) else "marker side"

    @property
    def summary(self) -> str:
        """The target in words, and in how many images it is."""
        board = self.board
        if isinstance(board, Checkerboard):
            what = f"a checkerboard of {board.columns} x {board.rows} inner corners"
        elif isinstance(board, CharucoBoard):
            what = f"a ChArUco board of {board.columns} x {board.rows} squares with {self.family}"
        elif isinstance(board, MarkerGrid):
            what = f"a grid of {board.columns} x {board.rows} markers {self.family}"
        elif board is not None:
            what = board.name
        else:
            count = len(self.marker_ids)
            what = f"{count} loose {'marker' if count == 1 else 'markers'} {self.family}"
        return f"{what}, in {len(self.images)} of {self.searched} images"


def find_target(images: Sequence[GrayImage]) -> FoundTarget | None:
    """Look for a board or markers that images of one place show; None where there are none.

    All families of `tracking.FAMILIES` are looked for, ChArUco boards and grids of them, and
    checkerboards. Of several families the one seen most often is taken; a checkerboard where more
    images show one than show markers.

    Args:
        images: grey uint8 ``(height, width)``; a dozen or more, spread over a clip, tell chance
            from markers best.

    Breaks down for markers smaller than about 15 px, and for boards that never lie whole in an
    image and have no markers. Circles are not looked for (see `circles.circles_seen`).

    Raises:
        ValueError: not grey uint8 images.
    """
    seen = families_seen(images)
    marked = _marked(seen[0], images) if seen else None
    if marked is not None and len(marked.images) >= _ENOUGH_SHARE * len(images):
        return marked
    counted = checkerboard_seen(images)
    large = max((max(one.shape) for one in images), default=0) > SMALL_PX
    if large and counted is None and marked is None:
        # Small markers in large images: where a third show none, the others are not asked.
        some = images[::3] if len(images) >= _MANY else images
        seen = families_seen(some, whole=True) and families_seen(images, whole=True)
        return _marked(seen[0], images) if seen else None
    if counted is None or (marked and len(marked.images) >= len(counted.images)):
        return marked
    nothing = (_markers_of(()),) * len(images)
    shown, doubt = counted.images, counted.doubt
    return FoundTarget(counted.board, None, (), nothing, shown, len(images), doubt)


def seen_board(board: Board, images: Sequence[GrayImage]) -> FoundTarget:
    """Where images show a board that is known.

    Raises:
        ValueError: not grey uint8 images.

    >>> from motorcade.tracking import Checkerboard
    >>> from motorcade.tracking.targets import seen_board
    >>> board = Checkerboard(7, 5, 0.03)
    >>> seen_board(board, [board.draw(pixels_per_m=1500.0)[0]]).images
    (0,)
    """
    if isinstance(board, MarkerGrid):
        target = seen_markers(board.family, images, set(board.marker_ids.tolist()))
        return replace(target, board=board)
    shown = tuple(row for row, one in enumerate(images) if board.detect(one) is not None)
    nothing = (_markers_of(()),) * len(images)
    return FoundTarget(board, None, (), nothing, shown, len(images))


def seen_markers(
    family: str, images: Sequence[GrayImage], wanted: Set[int] | None = None
) -> FoundTarget:
    """Where images show markers of a family, wherever they stand; those wanted, or all.

    Raises:
        ValueError: an unknown family, or not grey uint8 images.

    >>> from motorcade.tracking import MarkerGrid
    >>> from motorcade.tracking.targets import seen_markers
    >>> image, _ = MarkerGrid("aruco_5x5_100", 3, 2, 0.05, 0.02).draw(pixels_per_m=1500.0)
    >>> seen_markers("aruco_5x5_100", [image], {4, 5}).marker_ids
    (4, 5)
    """
    sharp = [
        [
            detection
            for detection in detect_markers(image, family)
            if detection.sharp and (wanted is None or detection.marker_id in wanted)
        ]
        for image in images
    ]
    markers = tuple(_markers_of(detections) for detections in sharp)
    ids = sorted({marker for one in markers for marker in one.ids.tolist()})
    shown = tuple(row for row, one in enumerate(markers) if len(one.ids))
    twice = doubled_ids([[seen.marker_id for seen in detections] for detections in sharp])
    return FoundTarget(None, family, tuple(ids), markers, shown, len(images), "", twice)


def doubled_ids(ids: Sequence[Sequence[int]]) -> tuple[int, ...]:
    """Ids that stand twice in images, of which there is more than one print: no chance readings.

    Args:
        ids: those of each image.

    >>> from motorcade.tracking.targets.finding import doubled_ids
    >>> doubled_ids([[4, 4, 7, 7], [4, 4, 7], [7]])
    (4,)
    """
    shown = Counter(marker for one in ids for marker in set(one))
    twice = Counter(marker for one in ids for marker, count in Counter(one).items() if count > 1)
    least = {marker: max(_TWICE, _TWICE_SHARE * shown[marker]) for marker in twice}
    return tuple(sorted(marker for marker in twice if twice[marker] >= least[marker]))


def _marked(seen: SeenFamily, images: Sequence[GrayImage]) -> FoundTarget:
    """Markers of a family, and the board that they make up."""
    target = seen_markers(seen.family, images, set(seen.marker_ids))
    markers, shown = target.markers, target.images or seen.images
    board = board_of_markers(seen.family, markers)
    if isinstance(board, CharucoBoard):
        sample = shown[:: max(1, len(shown) // 8)]
        whole = sum(board.detect(images[row]) is not None for row in sample)
        board = board if whole >= _LEAST_SHARE * len(sample) else None
    return FoundTarget(board, seen.family, seen.marker_ids, markers, shown, len(images))


def _markers_of(detections: Iterable[Detection]) -> SeenMarkers:
    """Markers of an image whose ids stand there once."""
    listed = list(detections)
    ids = [one.marker_id for one in listed]
    once = [one for one in listed if ids.count(one.marker_id) == 1]
    return SeenMarkers(
        np.array([one.marker_id for one in once], np.int64),
        np.array([one.corners_px for one in once]).reshape(-1, 4, 2),
    )
