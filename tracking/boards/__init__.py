"""Printed boards: values that can be drawn, found in pictures and sharpened to sub-pixels."""

from __future__ import annotations

from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.boards.checks import GrayImage
from motorcade.tracking.boards.corners import Board, BoardCorners
from motorcade.tracking.boards.families import FAMILIES
from motorcade.tracking.boards.markers import MarkerGrid, SingleMarker, detect_markers
from motorcade.tracking.boards.picture import Pattern

__all__ = [
    "FAMILIES",
    "Board",
    "BoardCorners",
    "CharucoBoard",
    "Checkerboard",
    "GrayImage",
    "MarkerGrid",
    "Pattern",
    "SingleMarker",
    "detect_markers",
]
