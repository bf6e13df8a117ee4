"""Printed boards: values that can be drawn, found in images and refined to sub-pixels."""

from __future__ import annotations

from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.boards.circles import CircleGrid
from motorcade.tracking.boards.corners import Board, BoardCorners
from motorcade.tracking.boards.markers import MarkerGrid, SingleMarker
from motorcade.tracking.boards.names import board_named
from motorcade.tracking.checks import GrayImage

__all__ = [
    "Board",
    "BoardCorners",
    "CharucoBoard",
    "Checkerboard",
    "CircleGrid",
    "GrayImage",
    "MarkerGrid",
    "SingleMarker",
    "board_named",
]
