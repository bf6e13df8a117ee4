"""Printed targets that images show, of which nothing was told: families, boards, their sizes."""

from __future__ import annotations

from motorcade.tracking.targets.chessboards import CountedBoard, checkerboard_seen
from motorcade.tracking.targets.families import SeenFamily, families_seen
from motorcade.tracking.targets.finding import (
    FoundTarget,
    find_target,
    seen_board,
    seen_markers,
)
from motorcade.tracking.targets.layouts import (
    SeenMarkers,
    board_of_markers,
    layout_fits,
    regapped,
)
from motorcade.tracking.targets.placing import corners_in_view
from motorcade.tracking.targets.stated import compare_layout

__all__ = [
    "CountedBoard",
    "FoundTarget",
    "SeenFamily",
    "SeenMarkers",
    "board_of_markers",
    "checkerboard_seen",
    "compare_layout",
    "corners_in_view",
    "families_seen",
    "find_target",
    "layout_fits",
    "regapped",
    "seen_board",
    "seen_markers",
]
