"""Grids of circles are counted; a wrong statement of one is named with the keys that mend it."""

import pytest

from motorcade.tracking import Board, Checkerboard
from motorcade.tracking.boards import CircleGrid
from motorcade.tracking.targets.stated import circles_seen, compare_layout

EVEN = CircleGrid(7, 5, 0.03, 0.016)
SHIFTED = CircleGrid(4, 9, 0.02, 0.015, asymmetric=True)


@pytest.mark.parametrize("board", [EVEN, SHIFTED], ids=lambda board: board.name)
def test_circles_are_counted(board: CircleGrid) -> None:
    seen = circles_seen([board.draw(pixels_per_m=1500.0)[0]])
    assert seen is not None
    assert (seen.columns, seen.rows, seen.asymmetric) == (
        board.columns,
        board.rows,
        board.asymmetric,
    )


@pytest.mark.parametrize(
    ("printed", "stated", "says"),
    [
        (EVEN, CircleGrid(5, 7, 0.03, 0.016), "as stated"),
        (EVEN, CircleGrid(6, 5, 0.03, 0.016), "say columns = 7, rows = 5"),
        (EVEN, CircleGrid(7, 5, 0.03, 0.016, asymmetric=True), "asymmetric = false"),
        (SHIFTED, CircleGrid(4, 8, 0.02, 0.015, asymmetric=True), "say columns = 4, rows = 9"),
        (Checkerboard(7, 6, 0.03), EVEN, 'say type = "checkerboard", columns = 7, rows = 6'),
    ],
)
def test_circles_that_are_stated_wrongly_are_named(
    printed: Board, stated: CircleGrid, says: str
) -> None:
    finding = compare_layout(stated, [printed.draw(pixels_per_m=1500.0)[0]])
    assert finding is not None
    assert says in finding.sentence
