"""Boards by name: what each board's `name` says, read back."""

from __future__ import annotations

import re

from motorcade.tracking.boards.charuco import CharucoBoard
from motorcade.tracking.boards.checkerboard import Checkerboard
from motorcade.tracking.boards.circles import CircleGrid
from motorcade.tracking.boards.corners import Board
from motorcade.tracking.boards.markers import MarkerGrid, SingleMarker
from motorcade.tracking.markers.families import FAMILIES, KALIBR_FAMILY

BOARD_NAMES = (
    "checkerboard_9x6_40mm (inner corners, square)",
    "charuco_aruco_5x5_100_7x5_40mm_30mm (squares, square, marker)",
    "tag36h11_6x4_30mm_gap_9mm_from_0 (markers, side, gap, first id)",
    "aprilgrid_6x6_88mm_gap_26.4mm (Kalibr's: tags, side, gap)",
    "circles_7x5_30mm_15mm (circles, spacing, diameter)",
    "circles_4x11_20mm_16mm_asymmetric",
    "tag36h11_id_7_65mm (id, side)",
)
"""An example of each kind of board, for people."""

_FAMILY = f"({'|'.join(sorted(FAMILIES, key=len, reverse=True))})"
_GRID, _MM = r"(\d{1,3})x(\d{1,3})", r"(\d+(?:\.\d+)?)mm"
_LENGTH = r"(\d+(?:\.\d+)?)"
_CALIB_IO_EXAMPLE = "calib.io_charuco_200x150_8x11_15_11_DICT_4X4"
_CALIB_IO = (
    rf"(?i:calib\.io)_((?i:checker|charuco|circles))_[\d.]+x[\d.]+_{_GRID}_{_LENGTH}(?:_{_LENGTH})?"
    r"(?:_(?i:dict)_([4-7])[xX]\6)?(?:_\w+)?(?:\.\w+)?"
)
_PRINT = r"(_up)?(?:_turned_(90|180|270))?(_squares)?"


def board_named(name: str) -> Board:
    """The board that has this `name`; lengths are millimetres, "_from_0" may be left out.

    Names of files that calib.io's generator makes are names, too (`_of_calib_io`).

    Raises:
        ValueError: no board's name, or numbers that the board refuses.

    >>> from motorcade.tracking import board_named
    >>> board_named("tag36h11_id_7_65mm")
    SingleMarker(family='tag36h11', marker_id=7, side_m=0.065)
    """
    if match := re.fullmatch(f"checkerboard_{_GRID}_{_MM}", name):
        columns, rows, square = match.groups()
        return Checkerboard(int(columns), int(rows), _metres(square))
    if match := re.fullmatch(f"charuco_{_FAMILY}_{_GRID}_{_MM}_{_MM}(_legacy)?", name):
        family, *counts, square, marker, legacy = match.groups()
        columns, rows = map(int, counts)
        return CharucoBoard(family, columns, rows, _metres(square), _metres(marker), bool(legacy))
    if match := re.fullmatch(
        rf"{_FAMILY}_{_GRID}_{_MM}_gap_{_MM}(?:_from_(\d{{1,4}}))?{_PRINT}", name
    ):
        family, columns, rows, side, gap, first, up, turned, squares = match.groups()
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
    if match := re.fullmatch(rf"aprilgrid_{_GRID}_{_MM}_gap_{_MM}(?:_from_(\d{{1,4}}))?", name):
        columns, rows, side, gap, first = match.groups()
        return kalibr_grid(int(columns), int(rows), _metres(side), _metres(gap), int(first or 0))
    if match := re.fullmatch(f"circles_{_GRID}_{_MM}_{_MM}(_asymmetric)?", name):
        columns, rows, spacing, diameter, shifted = match.groups()
        lengths = _metres(spacing), _metres(diameter)
        return CircleGrid(int(columns), int(rows), *lengths, bool(shifted))
    if match := re.fullmatch(_CALIB_IO, name):
        return _of_calib_io(*match.groups())
    if match := re.fullmatch(rf"{_FAMILY}_id_(\d{{1,4}})_{_MM}", name):
        family, marker, side = match.groups()
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
    if match := re.fullmatch(f"checkerboard_{_GRID}", name):
        return Checkerboard(int(match[1]), int(match[2]), 1.0), None
    board = board_named(name)
    if isinstance(board, SingleMarker):
        raise ValueError(f"board: expected a board of several corners or markers, got {name!r}")
    return board.resized(1.0), board.unit_m


def kalibr_grid(
    columns: int, rows: int, marker_m: float, gap_m: float, first_id: int = 0
) -> MarkerGrid:
    """Kalibr's AprilGrid: ids rise from the bottom row, borders two cells wide, black squares.

    >>> from motorcade.tracking.boards.names import kalibr_grid
    >>> kalibr_grid(6, 6, 0.088, 0.0264).name
    'aprilgrid_6x6_88mm_gap_26.4mm'
    """
    return MarkerGrid(
        KALIBR_FAMILY, columns, rows, marker_m, gap_m, first_id, "up", corner_squares=True
    )


def _of_calib_io(
    kind: str, rows: str, columns: str, unit: str, part: str | None, bits: str | None
) -> Board:
    """The board of a file of calib.io's pattern generator: ``…_WIDTHxHEIGHT`` of the sheet, then
    rows x columns of squares or circles, and lengths in millimetres.
    """
    down, across, unit_m = int(rows), int(columns), _metres(unit)
    if kind.lower() == "checker" and part is None:
        return Checkerboard(across - 1, down - 1, unit_m)
    if part is None or (kind.lower() == "charuco") != (bits is not None):
        raise ValueError(f"board: expected a name of calib.io's whole, such as {_CALIB_IO_EXAMPLE}")
    if bits is None:
        return CircleGrid(across, down, unit_m, _metres(part))
    # the sizes of a dictionary begin with the same words: the smallest that holds the board's
    needed = across * down // 2
    size = next((size for size in (50, 100, 250) if size >= needed), 1000)
    return CharucoBoard(f"aruco_{bits}x{bits}_{size}", across, down, unit_m, _metres(part))


def _metres(millimetres: str) -> float:
    return float(f"{millimetres}e-3")
