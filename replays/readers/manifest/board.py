"""The `[board]` table of a manifest, and boards named on the command line."""

from __future__ import annotations

from pathlib import Path

from motorcade.replays.errors import RecordingError
from motorcade.replays.readers.manifest.section import Section, load_toml
from motorcade.tracking.boards import (
    Board,
    CharucoBoard,
    Checkerboard,
    MarkerGrid,
    SingleMarker,
    board_named,
)
from motorcade.tracking.markers import FAMILIES

__all__ = ["BOARD_KEYS", "read_board", "section_board"]

BOARD_KEYS = {
    "checkerboard": ("columns", "rows", "square_m"),
    "marker_grid": ("family", "columns", "rows", "marker_m", "gap_m", "first_id"),
    "marker": ("family", "marker_id", "side_m"),
    "charuco": ("family", "columns", "rows", "square_m", "marker_m"),
}


def read_board(text: str) -> Board:
    """Take a board's name (`boards.board_named`), or the `[board]` table of a TOML file.

    Raises:
        ValueError: neither; or what the table or the board refuses.
    """
    if not text.endswith(".toml"):
        return board_named(text)
    path = Path(text)
    tables = load_toml(path)
    if "board" not in tables:
        raise Section(path, "", {}, ()).fault("board", "the table is missing")
    return section_board(path, tables["board"])


def section_board(path: Path, table: object) -> Board:
    """Make the board of a manifest's table; the board's own refusals are said of the table.

    Raises:
        RecordingError: naming table and key.
    """
    every = ("type", "world_T_board", *{key for keys in BOARD_KEYS.values() for key in keys})
    kind = Section(path, "board", table, every).text("type", tuple(BOARD_KEYS))
    section = Section(path, "board", table, ("type", "world_T_board", *BOARD_KEYS[kind]))
    try:
        return _make_board(kind, section)
    except RecordingError:
        raise
    except ValueError as fault:
        raise section.fault(kind, str(fault)) from fault


def _make_board(kind: str, section: Section) -> Board:
    def count(key: str) -> int:
        return section.whole(key, 0, 1000)

    def length(key: str) -> float:
        return section.number(key, 1e-6, 1e3)

    if kind == "checkerboard":
        return Checkerboard(count("columns"), count("rows"), length("square_m"))
    family = section.text("family", tuple(FAMILIES))
    if kind == "marker":
        return SingleMarker(family, section.whole("marker_id"), length("side_m"))
    columns, rows, marker_m = count("columns"), count("rows"), length("marker_m")
    if kind == "charuco":
        return CharucoBoard(family, columns, rows, length("square_m"), marker_m)
    first_id = section.whole("first_id") if "first_id" in section else 0
    return MarkerGrid(family, columns, rows, marker_m, length("gap_m"), first_id)
