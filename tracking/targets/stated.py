"""What is stated of a board's markers against how they stand in the images, and what mends it.

The stated layout is tried first. Where it does not explain how the markers stand, all layouts known
here are tried, and the one that does names the key that is wrong.

How many circles a grid in images has, and how its rows stand: told from their count.

An image that shows a grid whole shows as many blobs as the product of its columns and rows, and
seldom a few more. So each way to write such a count as a product is tried, symmetric and shifted,
and holds where one homography of the plane puts all circles where they are seen.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.boards.circles import CircleGrid
from motorcade.tracking.boards.corners import Board, BoardCorners
from motorcade.tracking.boards.markers import MarkerGrid, SingleMarker
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import grey_levels
from motorcade.tracking.targets.chessboards import checkerboard_seen
from motorcade.tracking.targets.families import families_seen, words_of
from motorcade.tracking.targets.finding import find_target, seen_markers
from motorcade.tracking.targets.layouts import (
    LayoutFit,
    SeenMarkers,
    board_of_markers,
    layout_fits,
)

NAME = "board_layout"
_PITCH_SHARE, _EDGE_PX = 0.02, 1.0
"""What printing, and bright or blurred edges, take off a side: a share of it, and pixels."""
_MANY, _MOST = 7, 0.5
"""Of the images: so many must deny a layout."""


def compare_layout(
    board: Board, images: Sequence[GrayImage], camera: Camera | None = None
) -> AuditFinding | None:
    """Compare the layout of a board with images of it, and whether its markers stand there once.

    Args:
        board: as stated.
        images: grey, a few spread over a recording.
        camera: straightens what its lens bends.

    Returns:
        what was found; None for boards of other kinds, of which nothing can be told so.

    >>> from motorcade.tracking import MarkerGrid
    >>> from motorcade.tracking.targets.stated import compare_layout
    >>> printed = MarkerGrid("tag36h11", 4, 3, marker_m=0.06, gap_m=0.018, order="up")
    >>> stated = MarkerGrid("tag36h11", 4, 3, marker_m=0.06, gap_m=0.018)
    >>> compare_layout(stated, [printed.draw(pixels_per_m=1000.0)[0]]).sentence
    'ids run upwards from the bottom row, not downwards; say order = "up"'
    """
    if isinstance(board, Checkerboard):
        return _counted(board, images)
    if isinstance(board, CircleGrid):
        return _circled(board, images)
    if not isinstance(board, MarkerGrid | CharucoBoard | SingleMarker):
        return None
    seen = seen_markers(board.family, images)
    doubled = _doubled(sorted({*seen.twice}.intersection(_ids(board))))
    if isinstance(board, SingleMarker):
        return doubled
    own = [_only(markers, _ids(board)) for markers in seen.markers]
    fits = [
        min(pair, key=lambda fit: fit.askew)
        for pair in zip(layout_fits(board, own, camera), layout_fits(board, own), strict=False)
    ]
    if not fits:
        summary = "no image shows four of the board's markers that would tell its layout"
        return doubled or AuditFinding(NAME, "unknown", None, "share", summary)
    wrong = float(np.mean([not fit.good for fit in fits]))
    if wrong <= _MOST:
        details = _details(board, [fit for fit in fits if fit.good])
        return doubled if doubled is not None and details.passed else details
    target = find_target(images)
    other = None if target is None else target.board
    if not isinstance(other, MarkerGrid | CharucoBoard):
        shown = [own, seen.markers]
        if camera is not None:
            shown += [[one.undistorted(camera) for one in markers] for markers in shown]
        boards = (board_of_markers(board.family, markers) for markers in shown)
        other = next(filter(None, boards), None)
    if not isinstance(other, MarkerGrid | CharucoBoard):
        summary = "the markers stand otherwise than stated, and in no grid known here"
        advice = "state the board as it is printed, or its markers as loose ones ([markers])"
        return AuditFinding(NAME, "contradicted", wrong, "share", summary, advice)
    return _otherwise(board, other, wrong)


def _doubled(ids: Sequence[int]) -> AuditFinding | None:
    """The finding on a board's ids that stand twice in images."""
    if not ids:
        return None
    summary = f"of the board's markers {', '.join(map(str, ids[:4]))} stand twice in images"
    advice = "leave one print of them in view: which was tracked is chance"
    return AuditFinding(NAME, "doubtful", float(len(ids)), "markers", summary, advice)


def _counted(board: Checkerboard, images: Sequence[GrayImage]) -> AuditFinding:
    """The finding on how many corners a checkerboard has; where it ends must be in view."""
    name, stated = "board_corners", (board.columns, board.rows)
    counted = checkerboard_seen(images, stated)
    printed = None if counted is not None and counted.plain else _charuco_seen(images)
    looks = None if counted is None else (counted.columns, counted.rows)
    if printed is not None:
        inner = {printed.columns - 1, printed.rows - 1}
        if inner in (set(stated), set(looks or ())):
            size = f"{printed.columns} by {printed.rows}"
            summary = f"markers stand in the squares: the board is a ChArUco board, {size}"
            return AuditFinding(name, "contradicted", 1.0, "share", summary, _keys(board, printed))
    if counted is None or looks is None or not counted.ends:
        return AuditFinding(name, "unknown", None, "corners", "no image shows where the board ends")
    off = float(np.abs(np.sort(looks) - np.sort(stated)).max())
    seen = "the board looks like {} x {} inner corners".format(*looks)
    if off == 0.0 or tuple(sorted(stated, reverse=True)) in counted.others:
        return AuditFinding(name, "consistent", off, "corners", f"{seen}, as stated")
    summary = "{}, not {} x {} as stated".format(seen, *stated)
    return AuditFinding(name, "contradicted", off, "corners", summary, _keys(board, counted.board))


def _circled(board: CircleGrid, images: Sequence[GrayImage]) -> AuditFinding:
    """The finding on how many circles a grid has, and how its rows stand."""
    name, looks = "board_corners", circles_seen(images)
    if looks is None:
        target = find_target(images)
        if target is None or target.board is None:
            return AuditFinding(name, "unknown", None, "corners", "no image shows a whole grid")
        summary, keys = f"the images show {target.summary}", _keys(board, target.board)
        return AuditFinding(name, "contradicted", 1.0, "share", summary, keys)
    size = (looks.columns, looks.rows)
    seen = "the board looks like {} x {} circles".format(*size) + ", shifted" * looks.asymmetric
    ways = (size,) if looks.asymmetric else (size, size[::-1])
    if (board.columns, board.rows) in ways and looks.asymmetric == board.asymmetric:
        return AuditFinding(name, "consistent", 0.0, "corners", f"{seen}, as stated")
    return AuditFinding(name, "contradicted", 1.0, "share", seen, _keys(board, looks))


def _charuco_seen(images: Sequence[GrayImage]) -> CharucoBoard | None:
    """The ChArUco board whose markers images show, its squares of length 1."""
    some = images[::3] if len(images) >= _MANY else images  # markers in squares are in all
    families = families_seen(some) and families_seen(images)
    for family in families[:1]:
        seen = seen_markers(family.family, images, set(family.marker_ids))
        board = board_of_markers(family.family, seen.markers)
        return board if isinstance(board, CharucoBoard) else None
    return None


def name_target(images: Sequence[GrayImage], stated: Board | str) -> str:
    """What target images show in place of a stated one that was seen in none, and what mends it.

    Args:
        images: grey, a few spread over a recording.
        stated: the board, or the family of loose markers.

    Returns:
        a clause, empty where they show none, as they are or mirrored.

    >>> from motorcade.tracking import MarkerGrid
    >>> from motorcade.tracking.targets.stated import name_target
    >>> image, _ = MarkerGrid("tag36h11", 4, 3, marker_m=0.06, gap_m=0.018).draw(1000.0)
    >>> name_target([image], MarkerGrid("tag25h9", 4, 3, marker_m=0.06, gap_m=0.018))
    'the images show a grid of 4 x 3 markers tag36h11, in 1 of 1 images; say family = "tag36h11"'
    """
    target = find_target(images)
    if target is None or (target.family is None and not isinstance(stated, Checkerboard)):
        mirrored = find_target([np.ascontiguousarray(image[:, ::-1]) for image in images])
        if mirrored is not None and mirrored.family is not None:
            return (
                f"the images are mirrored: as in a mirror they show {mirrored.summary}; mirror "
                "them back, left to right"
            )
    unmarked = target is None or isinstance(target.board, Checkerboard)
    circles = circles_seen(images) if unmarked else None
    if circles is not None and isinstance(stated, Board):
        shape = f"{circles.columns} x {circles.rows} circles" + ", shifted" * circles.asymmetric
        return f"the images show {shape}; {_keys(stated, circles)}"
    if target is None:
        return ""
    seen = f"the images show {target.summary}"
    if isinstance(stated, str):
        as_stated = target.family in (None, stated)
        return seen if as_stated else f'{seen}; say family = "{target.family}"'
    if target.board is not None and not isinstance(stated, SingleMarker):
        return "; ".join(filter(None, (seen, _keys(stated, target.board))))
    if not isinstance(stated, SingleMarker) or target.family is None:
        return seen
    keys = [f'family = "{target.family}"'] * (target.family != stated.family)
    if len(target.marker_ids) == 1 and target.marker_ids != (stated.marker_id,):
        keys.append(f"marker_id = {target.marker_ids[0]}")
    return f"{seen}; say {', '.join(keys)}" if keys else seen


def _ids(board: MarkerGrid | CharucoBoard | SingleMarker) -> range:
    if isinstance(board, SingleMarker):
        return range(board.marker_id, board.marker_id + 1)
    first = board.first_id if isinstance(board, MarkerGrid) else 0
    count = board.columns * board.rows
    return range(first, first + (count if isinstance(board, MarkerGrid) else (count + 1) // 2))


def _only(seen: SeenMarkers, ids: range) -> SeenMarkers:
    kept = np.isin(seen.ids, np.array(ids))
    return SeenMarkers(seen.ids[kept], seen.corners_px[kept])


def _otherwise(
    stated: MarkerGrid | CharucoBoard, other: MarkerGrid | CharucoBoard, wrong: float
) -> AuditFinding:
    """The finding on a layout that does not explain the images."""
    if type(other) is not type(stated):
        kind = "marker_grid" if isinstance(other, MarkerGrid) else "charuco"
        summary = f"the markers stand as those of a {kind}, {other.columns} by {other.rows}"
    elif other.columns != stated.columns:
        counts = f"{other.columns} by {other.rows}, not {stated.columns} by {stated.rows}"
        summary = f"the board stands {counts}"
    elif words_of(other.family) != words_of(stated.family):
        summary = f"the markers are of {other.family}, not {stated.family}"
    elif isinstance(other, CharucoBoard):
        summary = f"the board is {'a legacy ChArUco board' if other.legacy else 'no legacy one'}"
    elif isinstance(stated, MarkerGrid) and other.order == stated.order:
        summary = f"ids count from {other.first_id}, not from {stated.first_id}"
    else:
        way = ("upwards from the bottom row", "downwards from the top row")
        own, others = way if other.order == "up" else way[::-1]
        summary = f"ids run {own}, not {others.split()[0]}"
    return AuditFinding(NAME, "contradicted", wrong, "share", summary, _keys(stated, other))


_KINDS: dict[type[Board], tuple[str, ...]] = {
    Checkerboard: ("checkerboard", "columns", "rows"),
    MarkerGrid: ("marker_grid", "family", "columns", "rows", "first_id", "order", "turned_deg"),
    CharucoBoard: ("charuco", "family", "columns", "rows", "legacy"),
    CircleGrid: ("circles", "columns", "rows", "asymmetric"),
}
_LENGTHS = {
    MarkerGrid: "marker_m and gap_m",
    CharucoBoard: "square_m and marker_m",
    CircleGrid: "spacing_m and diameter_m",
}


def _keys(stated: Board, other: Board) -> str:
    """The keys of a manifest that would state the other board; empty where none does."""
    kind, *keys = _KINDS[type(other)]
    values = {key: getattr(other, key) for key in keys}
    lengths = f", and {_LENGTHS.get(type(other), 'square_m')} as measured"
    if type(stated) is type(other):
        lengths, own = "", {key: getattr(stated, key) for key in keys}
        differing = {key for key in keys if own[key] != values[key]}
        if "family" in keys and words_of(own["family"]) == words_of(values["family"]):
            differing -= {"family"}  # of nested dictionaries the smallest is seen
        if "columns" in differing or (isinstance(other, Checkerboard | CircleGrid) and differing):
            differing |= {"columns", "rows"}
        else:
            differing -= {"rows"}  # those beyond the last marker seen are not known
        values = {key: value for key, value in values.items() if key in differing}
    else:
        values = {"type": kind} | values
    shown = [
        f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {str(value).lower()}"
        for key, value in values.items()
    ]
    return f"say {', '.join(shown)}{lengths}" if shown else ""


def _details(board: MarkerGrid | CharucoBoard, fits: Sequence[LayoutFit]) -> AuditFinding:
    """The finding on turns and gaps, where the order is as stated."""
    sides = [fit.turned_deg for fit in fits]
    turned = max(set(sides), key=sides.count)
    stated_deg = board.turned_deg if isinstance(board, MarkerGrid) else 0
    if turned != stated_deg:
        summary = f"tags are turned by {turned}° in their places, not by {stated_deg}°"
        advice = f"say turned_deg = {turned}"
        return AuditFinding(NAME, "contradicted", turned, "deg", summary, advice)
    side_m = board.marker_m
    pitch_m = side_m + board.gap_m if isinstance(board, MarkerGrid) else board.square_m
    ratios = np.array([1.0 / fit.side for fit in fits])
    off = float(np.median(ratios)) - pitch_m / side_m
    edges = _PITCH_SHARE + _EDGE_PX / float(np.median([fit.side_px for fit in fits]))
    gap_mm = 1e3 * (pitch_m + off * side_m - side_m)
    if abs(off) <= edges * pitch_m / side_m:
        summary = f"the markers stand as stated, {gap_mm:.1f} mm apart"
        return AuditFinding(NAME, "consistent", abs(off), "sides", summary)
    if isinstance(board, CharucoBoard):
        side_m = board.square_m / float(np.median(ratios))
        square_m = board.marker_m * float(np.median(ratios))
        summary = (
            f"you say markers of {1e3 * board.marker_m:g} mm; the squares say {1e3 * side_m:.1f} mm"
        )
        advice = (
            f"say marker_m = {side_m:.4g}, or square_m = {square_m:.4g} if the markers are right"
        )
        return AuditFinding(NAME, "contradicted", abs(off), "sides", summary, advice)
    summary = f"you say a gap of {1e3 * board.gap_m:g} mm; the tags stand {gap_mm:.1f} mm apart"
    advice = f"say gap_m = {1e-3 * gap_mm:.4g}"
    if board.gap_m > 0.0 and gap_mm > 0.0:
        marker_m = side_m * board.gap_m / (1e-3 * gap_mm)
        advice += f", or marker_m = {marker_m:.4g} if the gap is right"
    return AuditFinding(NAME, "contradicted", abs(off), "sides", summary, advice)


_FEWEST, _MOST_CIRCLES, _LONGEST = 3, 400, 40
_BESIDE = 2
"""Blobs beside a grid that are allowed for."""
_IMAGES = 6
_STEPS, _SQUARE = 27, 1.2
_ASKEW = 0.08
"""Of the distance of neighbours, RMS: what lens distortion leaves of a right guess."""


def circles_seen(images: Sequence[GrayImage]) -> CircleGrid | None:
    """The grid of circles that most of some images show, its spacing 1; None where none does.

    Its diameter is not told: half of the spacing. A symmetric grid's longer way is named first.

    Breaks down for grids that leave the images, and where more than two blobs lie beside them.

    >>> from motorcade.tracking.boards import CircleGrid
    >>> from motorcade.tracking.targets.stated import circles_seen
    >>> circles_seen([CircleGrid(7, 5, 0.03, 0.015).draw(pixels_per_m=1500.0)[0]]).name
    'circles_7x5_1000mm_500mm'
    """
    some = images[:: -(-len(images) // _IMAGES)] if images else ()
    counts = Counter(filter(None, map(_grid_in, some)))
    grid, times = next(iter(counts.most_common(1)), (None, 0))
    return grid if 2 * times >= sum(counts.values()) else None


def _grid_in(image: GrayImage) -> CircleGrid | None:
    blobs = len(cv2.SimpleBlobDetector.create().detect(image))
    if blobs > _MOST_CIRCLES:
        return None
    guesses = (
        guess for count in range(blobs, blobs - _BESIDE - 1, -1) for guess in _guesses(count)
    )
    return next((guess for guess in guesses if _fits(guess, image)), None)


def _guesses(count: int) -> Iterator[CircleGrid]:
    """The grids of so many circles, the squarest first."""
    sizes = [
        (count // rows, rows)
        for rows in range(_FEWEST, _LONGEST + 1)
        if count % rows == 0 and _FEWEST <= count // rows <= _LONGEST
    ]
    for columns, rows in sorted(sizes, key=lambda size: (abs(size[0] - size[1]), -size[0])):
        if columns >= rows:
            yield CircleGrid(columns, rows, 1.0, 0.5)
        yield CircleGrid(columns, rows, 1.0, 0.5, asymmetric=True)


def _fits(guess: CircleGrid, image: GrayImage) -> bool:
    seen = replace(guess, diameter_m=0.99).detect(image)
    if seen is None or len(seen) < len(guess.points_m):
        return False
    to_plane, _ = cv2.findHomography(seen.corners_px, seen.points_m[:, :2], 0)
    if to_plane is None:
        return False
    placed = cv2.perspectiveTransform(seen.corners_px.reshape(-1, 1, 2), to_plane)
    off = placed.reshape(-1, 2) - seen.points_m[:, :2]
    return bool(np.sqrt((off**2).sum(axis=1).mean()) <= _ASKEW) and _round(seen, image, to_plane)


def _round(seen: BoardCorners, image: GrayImage, to_plane: FloatArray) -> bool:
    """Whether blobs reach as far along their diagonals as along rows: squares do not."""
    angles = np.radians(np.arange(0.0, 360.0, 45.0))
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    rays = ways[:, None] * np.linspace(0.05, 0.7, _STEPS)[:, None]
    plane = seen.points_m[:, None, None, :2] + rays
    px = cv2.perspectiveTransform(plane.reshape(-1, 1, 2), np.linalg.inv(to_plane))
    levels = np.median(grey_levels(image, px.reshape(*plane.shape[:3], 2)), axis=0)
    dark = (levels < 0.5 * (levels.min() + levels.max())).sum(axis=1)
    return bool(dark[1::2].sum() < _SQUARE * dark[::2].sum())
