"""Boards by name: what each board's `name` says, read back."""

from __future__ import annotations

import re
from dataclasses import replace

from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.boards.corners import Board
from motorcade.tracking.boards.markers import MarkerGrid, SingleMarker
from motorcade.tracking.markers.families import FAMILIES

BOARD_NAMES = (
    "checkerboard_9x6_40mm (inner corners, square)",
    "charuco_aruco_5x5_100_7x5_40mm_30mm (squares, square, marker)",
    "tag36h11_6x4_30mm_gap_9mm_from_0 (markers, side, gap, first id)",
    "tag36h11_id_7_65mm (id, side)",
)
"""An example of each kind of board, for people."""

_FAMILY = f"({'|'.join(sorted(FAMILIES, key=len, reverse=True))})"
_GRID, _MM = r"(\d{1,3})x(\d{1,3})", r"(\d+(?:\.\d+)?)mm"
_PRINT = r"(_up)?(?:_turned_(90|180|270))?(_squares)?"


def board_named(name: str) -> Board:
    """The board that has this `name`; lengths are millimetres, "_from_0" may be left out.

    Raises:
        ValueError: no board's name, or numbers that the board refuses.

    >>> from motorcade.tracking import board_named
    >>> board_named("tag36h11_id_7_65mm")
    SingleMarker(family='tag36h11', marker_id=7, side_m=0.065)
    """
    if found := re.fullmatch(f"checkerboard_{_GRID}_{_MM}", name):
        columns, rows, square = found.groups()
        return Checkerboard(int(columns), int(rows), _metres(square))
    if found := re.fullmatch(f"charuco_{_FAMILY}_{_GRID}_{_MM}_{_MM}(_legacy)?", name):
        family, *counts, square, marker, legacy = found.groups()
        columns, rows = map(int, counts)
        return CharucoBoard(family, columns, rows, _metres(square), _metres(marker), bool(legacy))
    if found := re.fullmatch(
        rf"{_FAMILY}_{_GRID}_{_MM}_gap_{_MM}(?:_from_(\d{{1,4}}))?{_PRINT}", name
    ):
        family, columns, rows, side, gap, first, up, turned, squares = found.groups()
        return MarkerGrid(
            family,
            int(columns),
            int(rows),
            _metres(side),
            _metres(gap),
            int(first or 0),
            "up" if up else "down",
            int(turned or 0),
            bool(squares),
        )
    if found := re.fullmatch(rf"{_FAMILY}_id_(\d{{1,4}})_{_MM}", name):
        family, marker, side = found.groups()
        return SingleMarker(family, int(marker), _metres(side))
    raise ValueError(f"board: expected a name such as {', '.join(BOARD_NAMES)}, got {name!r}")


def board_in_units(name: str) -> tuple[Board, float | None]:
    """The board that a name says in units of its square or marker, and how many metres these are.

    A checkerboard's name may say nothing of lengths: ``checkerboard_8x6``.

    Raises:
        ValueError: as `board_named`; or a single marker, which is no board to look for.

    >>> from motorcade.tracking.boards.names import board_in_units
    >>> board_in_units("checkerboard_8x6")
    (Checkerboard(columns=8, rows=6, square_m=1.0), None)
    >>> board_in_units("tag36h11_6x4_30mm_gap_9mm")[1]
    0.03
    """
    if found := re.fullmatch(f"checkerboard_{_GRID}", name):
        return Checkerboard(int(found[1]), int(found[2]), 1.0), None
    board = board_named(name)
    if isinstance(board, Checkerboard):
        return replace(board, square_m=1.0), board.square_m
    if isinstance(board, CharucoBoard):
        unit_m = board.square_m
        return replace(board, square_m=1.0, marker_m=board.marker_m / unit_m), unit_m
    if isinstance(board, MarkerGrid):
        unit_m = board.marker_m
        return replace(board, marker_m=1.0, gap_m=board.gap_m / unit_m), unit_m
    raise ValueError(f"board: expected a checkerboard, a ChArUco board or a grid, got {name!r}")


def _metres(millimetres: str) -> float:
    return float(f"{millimetres}e-3")
