"""Printed targets that images show, of which nothing was told: families, boards, their sizes."""

from __future__ import annotations

from motorcade.tracking.targets.finding import (
    FoundTarget,
    find_target,
    seen_board,
    seen_markers,
)
from motorcade.tracking.targets.grids import corners_in_view
from motorcade.tracking.targets.layouts import SeenMarkers, regapped

__all__ = [
    "FoundTarget",
    "SeenMarkers",
    "corners_in_view",
    "find_target",
    "regapped",
    "seen_board",
    "seen_markers",
]
