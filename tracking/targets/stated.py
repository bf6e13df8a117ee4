"""What is stated of a board's markers against how they stand in the pictures, and what mends it.

The stated layout is tried first. Where it does not explain how the markers stand, all layouts known
here are tried, and the one that does names the key that is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.corners import Board
from motorcade.tracking.boards.markers import MarkerGrid
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage
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
_MOST = 0.5
"""Of the pictures: so many must deny a layout."""


def compare_layout(
    board: Board, pictures: Sequence[GrayImage], camera: Camera | None = None
) -> AuditFinding | None:
    """Compare the layout of a grid of markers, or of a ChArUco board, with pictures of it.

    Args:
        board: as stated.
        pictures: grey, a few spread over a recording.
        camera: straightens what its lens bends.

    Returns:
        what was found; None for boards of other kinds, of which nothing can be told so.

    >>> from motorcade.tracking import MarkerGrid
    >>> from motorcade.tracking.targets import compare_layout
    >>> printed = MarkerGrid("tag36h11", 4, 3, marker_m=0.06, gap_m=0.018, order="up")
    >>> stated = MarkerGrid("tag36h11", 4, 3, marker_m=0.06, gap_m=0.018)
    >>> compare_layout(stated, [printed.draw(pixels_per_m=1000.0)[0]]).sentence
    'ids run upwards from the bottom row, not downwards; say order = "up"'
    """
    if not isinstance(board, MarkerGrid | CharucoBoard):
        return None
    found = seen_markers(board.family, pictures)
    own = [_only(one, _ids(board)) for one in found.markers]
    fits = [
        min(pair, key=lambda fit: fit.askew)
        for pair in zip(layout_fits(board, own, camera), layout_fits(board, own), strict=False)
    ]
    if not fits:
        summary = "no picture shows four of the board's markers that would tell its layout"
        return AuditFinding(NAME, "unknown", None, "share", summary)
    wrong = float(np.mean([not fit.good for fit in fits]))
    if wrong > _MOST:
        other = board_of_markers(board.family, own) or board_of_markers(board.family, found.markers)
        return _otherwise(board, other, wrong)
    return _details(board, [fit for fit in fits if fit.good])


def name_target(pictures: Sequence[GrayImage]) -> str:
    """What target pictures show, for a board that was never seen; empty where they show none."""
    target = find_target(pictures)
    return "" if target is None else f"the pictures show {target.summary}"


def _ids(board: MarkerGrid | CharucoBoard) -> range:
    first = board.first_id if isinstance(board, MarkerGrid) else 0
    count = board.columns * board.rows
    return range(first, first + (count if isinstance(board, MarkerGrid) else (count + 1) // 2))


def _only(seen: SeenMarkers, ids: range) -> SeenMarkers:
    kept = np.isin(seen.ids, np.array(ids))
    return SeenMarkers(seen.ids[kept], seen.corners_px[kept])


def _otherwise(
    stated: MarkerGrid | CharucoBoard, other: MarkerGrid | CharucoBoard | None, wrong: float
) -> AuditFinding:
    """The finding on a layout that does not explain the pictures."""
    if other is None:
        summary = "the markers stand otherwise than stated, and in no grid known here"
        advice = "state the board as it is printed, or its markers as loose ones ([markers])"
    elif type(other) is not type(stated):
        kind = "marker_grid" if isinstance(other, MarkerGrid) else "charuco"
        summary = f"the markers stand as those of a {kind}, {other.columns} by {other.rows}"
        advice = f'say type = "{kind}"'
    elif other.columns != stated.columns:
        counts = f"{other.columns} by {other.rows}, not {stated.columns} by {stated.rows}"
        summary, advice = f"the board stands {counts}", _keys(stated, other)
    elif isinstance(other, CharucoBoard):
        summary = f"the board is {'a legacy ChArUco board' if other.legacy else 'no legacy one'}"
        advice = _keys(stated, other)
    elif isinstance(stated, MarkerGrid) and other.order == stated.order:
        summary = f"ids count from {other.first_id}, not from {stated.first_id}"
        advice = _keys(stated, other)
    else:
        way = ("upwards from the bottom row", "downwards from the top row")
        own, others = way if other.order == "up" else way[::-1]
        summary = f"ids run {own}, not {others.split()[0]}"
        advice = _keys(stated, other)
    return AuditFinding(NAME, "contradicted", wrong, "share", summary, advice)


def _keys(stated: MarkerGrid | CharucoBoard, other: MarkerGrid | CharucoBoard) -> str:
    """The keys of a manifest that would state the other board."""
    keys = ("columns", "rows") if stated.columns != other.columns else ()
    differing = [
        key
        for key in (*keys, "first_id", "order", "turned_deg", "legacy")
        if getattr(stated, key, None) != getattr(other, key, None)
    ]
    values = [getattr(other, key) for key in differing]
    shown = [f'"{one}"' if isinstance(one, str) else str(one).lower() for one in values]
    return "say " + ", ".join(f"{key} = {one}" for key, one in zip(differing, shown, strict=True))


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
        side_mm = 1e3 * board.square_m / float(np.median(ratios))
        summary = f"you say markers of {1e3 * side_m:g} mm; the squares say {side_mm:.1f} mm"
        return AuditFinding(NAME, "doubtful", abs(off), "sides", summary, "measure both anew")
    summary = f"you say a gap of {1e3 * board.gap_m:g} mm; the tags stand {gap_mm:.1f} mm apart"
    advice = f"say gap_m = {1e-3 * gap_mm:.4f}"
    return AuditFinding(NAME, "contradicted", abs(off), "sides", summary, advice)
