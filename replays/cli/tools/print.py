"""`motorcade print`: boards and markers as PDF or SVG, at true size."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.replays.cli.arguments import Subparsers, new_command

if TYPE_CHECKING:
    from motorcade.tracking import Board

DESCRIPTION = """\
Write boards and markers as sheets to print, at true size, with rulers that check the printer.
FILE ends in .pdf (a page a sheet) or .svg (a file a sheet); the tables of a manifest that describe
what was printed are written beside it, as FILE with .toml, for `run --manifest` and
`calibrate --board`. Print at 100 %, and measure the rulers.

boards      checkerboard_9x6_22mm (inner corners, square)
            charuco_aruco_5x5_100_7x5_26mm_19mm (squares, square, marker)
            tag36h11_4x5_30mm_gap_9mm_from_0 (markers, side, gap, first id)
            tag36h11_id_7_65mm (id, side); with --count 12: ids 7 to 18, as many a sheet as fit
            or a .toml file with a [board] table"""


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        print_boards,
        name="print",
        summary="write boards and markers to print, at true size",
        example="motorcade print checkerboard_9x6_22mm -o board.pdf",
    )
    parser.description = DESCRIPTION
    parser.add_argument("boards", nargs="+", metavar="BOARD", help="its name, or a .toml file")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE")
    parser.add_argument(
        "--paper", default="a4", metavar="P", help="a4, a3, letter, …, or 300x400mm (a4)"
    )
    parser.add_argument(
        "--count", type=int, default=1, metavar="N", help="of single markers: ids that follow (1)"
    )


def print_boards(arguments: argparse.Namespace) -> None:
    """Lay the boards out, write the sheets and the manifest's tables, and say where."""
    from motorcade.replays.files.atomic import write_bytes
    from motorcade.replays.printing import (
        lay_out,
        manifest_lines,
        paper_named,
        sheet_svg,
        sheets_pdf,
    )
    from motorcade.replays.readers.manifest.section import read_board

    output: Path = arguments.output
    if output.suffix.lower() not in (".pdf", ".svg"):
        raise ValueError(f"-o {output}: expected a name that ends in .pdf or .svg")
    boards = [
        one for name in arguments.boards for one in _following(read_board(name), arguments.count)
    ]
    sheets = lay_out(boards, paper_named(arguments.paper))
    if output.suffix.lower() == ".pdf":
        files = {output: sheets_pdf(sheets)}
    elif len(sheets) == 1:
        files = {output: sheet_svg(sheets[0])}
    else:
        files = {
            output.with_stem(f"{output.stem}_{number}"): sheet_svg(sheet)
            for number, sheet in enumerate(sheets, 1)
        }
    tables = "\n".join(manifest_lines(boards))
    files[output.with_suffix(".toml")] = tables.encode()
    for path, data in files.items():
        write_bytes(path, data)
    print(tables)
    print(
        f"{len(sheets)} sheet{'s' if len(sheets) > 1 else ''} in "
        f"{', '.join(map(str, files))}; print at 100 % and measure the rulers"
    )


def _following(board: Board, count: int) -> list[Board]:
    """A board; of a single marker also those whose ids follow."""
    from motorcade.tracking import SingleMarker

    if count < 1:
        raise ValueError(f"--count: expected 1 or more, got {count}")
    if count == 1:
        return [board]
    if not isinstance(board, SingleMarker):
        raise ValueError(
            f"--count {count}: {board.name} is one board; only single markers, such as "
            "tag36h11_id_0_65mm, are counted on"
        )
    return [replace(board, marker_id=board.marker_id + step) for step in range(count)]
