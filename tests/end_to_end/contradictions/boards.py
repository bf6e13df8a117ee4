"""Eight kinds of boards and more, each stated wrongly in eight ways: is it read, or named?

    python -m tests.end_to_end.contradictions.boards [--only WORD] [--seed N]

A drawn recording of each board is run with ``--strict`` under each wrong statement. It is `named`
where the closing line says keys and values of the board that was printed, and none of another;
`read` where the statement describes the same print turned, and the run ends well. A line each; ends
with 1 where one is neither.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from motorcade.replays.io.readers.manifest.section import BOARD_KEYS, board_toml
from motorcade.tracking import Board, CharucoBoard, Checkerboard, MarkerGrid
from motorcade.tracking.boards import CircleGrid
from motorcade.tracking.boards.names import kalibr_grid
from motorcade.tracking.targets.families import words_of
from tests.end_to_end.contradictions.drawing import PINHOLE, Drawn, sheet_of, write_sheet
from tests.end_to_end.contradictions.running import run, said

PRINTED: dict[str, Board] = {
    "checkerboard": Checkerboard(7, 6, 0.03),
    "charuco": CharucoBoard("aruco_5x5_100", 7, 6, 0.04, 0.03),
    "charuco legacy": CharucoBoard("aruco_4x4_50", 6, 4, 0.04, 0.03, legacy=True),
    "aruco grid": MarkerGrid("aruco_5x5_100", 5, 4, 0.05, 0.012, 3),
    "tags downwards": MarkerGrid("tag36h11", 5, 4, 0.05, 0.015, 4),
    "tags upwards": MarkerGrid("tag36h11", 5, 4, 0.05, 0.015, 4, "up"),
    "aprilgrid": kalibr_grid(5, 4, 0.05, 0.015),
    "circles": CircleGrid(7, 6, 0.03, 0.016),
    "circles shifted": CircleGrid(4, 7, 0.03, 0.022, asymmetric=True),
}
SQUARES = Checkerboard(8, 5, 0.03)
TAGS = MarkerGrid("tag25h9", 4, 3, 0.06, 0.018)
MIXED = CharucoBoard("aruco_6x6_250", 5, 7, 0.04, 0.03)
ROUND = CircleGrid(6, 5, 0.03, 0.016)


def statements(board: Board) -> Iterator[tuple[str, Board]]:
    """Eight wrong statements of a board."""
    columns, rows = board.columns, board.rows  # type: ignore[attr-defined]

    def stated(**changes: object) -> Board:
        return replace(board, **changes)  # type: ignore[type-var]

    yield "rows by columns", stated(columns=rows, rows=columns)
    yield "a column too many", stated(columns=columns + 1)
    yield "a column too few", stated(columns=columns - 1)
    if isinstance(board, MarkerGrid):
        yield "another family", stated(family="tag36h10")
        yield "another order", stated(order="up" if board.order == "down" else "down")
        yield "ids from 1 higher", stated(first_id=board.first_id + 1)
        yield "gap 1.5 times", stated(gap_m=1.5 * board.gap_m)
        yield "a checkerboard", SQUARES
    elif isinstance(board, CharucoBoard):
        yield "another family", stated(family="aruco_6x6_250")
        yield "another pattern", stated(legacy=not board.legacy)
        yield "markers 0.8 times", stated(marker_m=0.8 * board.marker_m)
        yield "a checkerboard", SQUARES
        yield "a grid of tags", TAGS
    else:
        yield "a row too many", stated(rows=rows + 1)
        yield "a row too few", stated(rows=rows - 1)
        yield "a grid of tags", TAGS
        yield "a charuco board", MIXED
        if isinstance(board, CircleGrid):
            yield "another shift", stated(asymmetric=not board.asymmetric)
        else:
            yield "circles", ROUND


def names(closing: str, printed: Board) -> bool:
    """Whether a closing line says keys of the printed board, and no wrong value of one."""
    keys = {key for keys in BOARD_KEYS.values() for key in keys if not key.endswith("_m")}
    right, wrong = 0, 0
    for key, value in said(closing).items():
        if key == "gap_m" or key == "marker_m":
            right += abs(float(value) / getattr(printed, key) - 1.0) < 0.1
        elif key in keys and hasattr(printed, key):
            own, shown = getattr(printed, key), value.strip('"')
            if key == "family":
                own, shown = words_of(own), words_of(shown)
            right, wrong = right + (shown == str(own).lower()), wrong + (shown != str(own).lower())
    return right > 0 and wrong == 0


def same_print(stated: Board, printed: Board) -> bool:
    """Whether a statement describes the same print, turned."""
    if type(stated) is not type(printed) or not isinstance(printed, Checkerboard | CircleGrid):
        return False
    turned = (printed.rows, printed.columns)
    shifted = isinstance(printed, CircleGrid) and printed.asymmetric
    return (stated.columns, stated.rows) == turned and not shifted  # type: ignore[attr-defined]


def judged(drawn: Drawn, printed: Board, stated: Board) -> tuple[str, str]:
    """`named`, `read`, or what is missing; and the closing line."""
    answer = run(drawn.stated((board_toml(printed), board_toml(stated))))
    if answer.code == 0:
        return ("read" if same_print(stated, printed) else "BELIEVED"), answer.closing
    return ("named" if names(answer.closing, printed) else "UNNAMED"), answer.closing


def main() -> int:
    """Print a line each; 1 where one is neither read nor named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        for kind, printed in PRINTED.items():
            rng = np.random.default_rng(asked.seed)
            place = Path(name, kind.replace(" ", "_"))
            wrong = [one for one in statements(printed) if asked.only in f"{kind}: {one[0]}"]
            if not wrong:
                continue
            drawn = write_sheet(place, sheet_of(printed), PINHOLE, rng)
            clean = run(drawn)
            print(f"{'clean' if clean.code == 0 else 'DOUBTED':9} {kind}: {clean.closing}")
            counts["clean" if clean.code == 0 else "DOUBTED"] += 1
            for what, stated in wrong:
                verdict, closing = judged(drawn, printed, stated)
                counts[verdict] += 1
                print(f"{verdict:9} {kind}: {what}: {closing}", flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
    return 1 if any(verdict.isupper() for verdict in counts) else 0


if __name__ == "__main__":
    sys.exit(main())
