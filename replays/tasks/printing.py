"""Boards and markers as sheets to print: laid out in millimetres, written as PDF or SVG.

Sheets laid out: boards at true size, rulers that check the printer, and the manifest's lines.

Sizes of paper, by name.

Outlines of a pattern's black: whole areas, since cells side by side show seams when drawn.

Sheets as the pages of one PDF.

Sheets as SVG, in millimetres: one file a sheet.
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.readers.manifest.section import board_toml, markers_toml
from motorcade.tracking.boards import Board, SingleMarker
from motorcade.tracking.boards.corners import Pattern

__all__ = ["PAPERS", "Paper", "Sheet", "lay_out", "paper_named"]


# What printers leave white at the edge of a sheet, and the strips of rulers and words.
_EDGE_MM = 6.0
_LEFT_MM = 9.0
_WORDS_MM, _LINE_MM, _LETTERS_MM = 25.0, 3.4, 2.6
_LABEL_MM = 4.5
_BAR_MM = 100.0
_SHORT_BAR_MM = 50.0


@dataclass(frozen=True)
class Caption:
    """A line of text on a sheet: its left end on the baseline, and the height of its letters."""

    x_mm: float
    y_mm: float
    size_mm: float
    text: str


@dataclass(frozen=True, eq=False)
class Sheet:
    """What stands on a sheet of paper; millimetres from its top left, x right and y down.

    Fields:
        paper: as it lies.
        outlines: closed polygons ``(n, 2)``, filled black by the even-odd rule.
        lines: ``(m, 2, 2)`` ends of thin lines.
        words: texts.
        origins_mm: of each board on the sheet, where its origin stands.
        boards: the boards, in the order of `origins_mm`.
    """

    paper: Paper
    outlines: tuple[FloatArray, ...]
    lines: FloatArray
    words: tuple[Caption, ...]
    origins_mm: FloatArray
    boards: tuple[Board, ...]


@dataclass(frozen=True)
class _Place:
    """A board's print with its quiet zone: where its box begins, and from there its origin."""

    board: Board
    pattern: Pattern
    x_mm: float = 0.0
    y_mm: float = 0.0

    @property
    def inset_mm(self) -> FloatArray:
        """From the box's corner to the board's origin."""
        edges = np.array([self.pattern.x_edges_m[0], self.pattern.y_edges_m[0]])
        return 1e3 * (self.pattern.quiet_m - edges)

    @property
    def size_mm(self) -> tuple[float, float]:
        quiet = 2e3 * self.pattern.quiet_m
        x, y = self.pattern.x_edges_m, self.pattern.y_edges_m
        return 1e3 * float(x[-1] - x[0]) + quiet, 1e3 * float(y[-1] - y[0]) + quiet

    @property
    def label_mm(self) -> float:
        """Room for its name below; that of a board with a sheet of its own stands by the ruler."""
        return _LABEL_MM if isinstance(self.board, SingleMarker) else 0.0


def lay_out(boards: Sequence[Board], paper: Paper) -> tuple[Sheet, ...]:
    """Put boards on sheets: single markers share them, as many as fit; others have one each.

    A sheet lies where its board does not fit on it standing. Each has a ruler across and one down
    beside the print, a label for each board, and the tables of a manifest that describe it.

    Raises:
        ValueError: no boards, or one that does not fit, with the paper on which it would.

    >>> from motorcade.replays.tasks.printing import lay_out, paper_named
    >>> from motorcade.tracking import Checkerboard
    >>> [sheet] = lay_out([Checkerboard(9, 6, square_m=0.022)], paper_named("a4"))
    >>> sheet.paper.width_mm, sheet.origins_mm.shape
    (297.0, (1, 2))
    """
    if not boards:
        raise ValueError("boards: expected at least one to print, got none")
    places = [_Place(board, board.pattern) for board in boards]
    sheets: list[tuple[Paper, list[_Place]]] = []
    for place in places:
        lying = _fitting(place, paper)
        if isinstance(place.board, SingleMarker) and sheets and sheets[-1][0] == lying:
            before = sheets[-1][1]
            following = _beside(before, place, lying)
            if following is not None and isinstance(before[0].board, SingleMarker):
                before.append(following)
                continue
        left, top, _, _ = _room_mm(lying, place)
        sheets.append((lying, [_Place(place.board, place.pattern, left, top)]))
    return tuple(_sheet(lying, placed) for lying, placed in sheets)


def _room_mm(paper: Paper, place: _Place) -> tuple[float, float, float, float]:
    """Left, top, right and bottom of what a board may take; white may lie where none can print."""
    edge = max(0.0, _EDGE_MM - 1e3 * place.pattern.quiet_m)
    return _EDGE_MM + _LEFT_MM, edge, paper.width_mm - edge, _words_top_mm(paper)


def _words_top_mm(paper: Paper) -> float:
    return paper.height_mm - _EDGE_MM - _WORDS_MM


def _fits(place: _Place, paper: Paper) -> bool:
    left, top, right, bottom = _room_mm(paper, place)
    width, height = place.size_mm
    return width <= right - left and height + place.label_mm <= bottom - top


def _fitting(place: _Place, paper: Paper) -> Paper:
    """The paper as it must lie for a board; ValueError where it fits neither way."""
    for lying in (paper, paper.lying()):
        if _fits(place, lying):
            return lying
    width, height = place.size_mm
    larger = [one.name for one in PAPERS.values() if _fits(place, one) or _fits(place, one.lying())]
    advice = f"print it on {larger[0]} or make it smaller" if larger else "make it smaller"
    raise ValueError(
        f"{place.board.name}: needs {width:.0f} mm by {height:.0f} mm with its white edge, beside "
        f"rulers and words, which {paper.name} does not have; {advice}"
    )


def _beside(placed: Sequence[_Place], place: _Place, paper: Paper) -> _Place | None:
    """The place right of the last one, or in a new row under all; None where neither is free."""
    left, _, right, bottom = _room_mm(paper, place)
    width, height = place.size_mm
    last = placed[-1]
    x, y = last.x_mm + last.size_mm[0], last.y_mm
    if x + width > right:
        x, y = left, max(one.y_mm + one.size_mm[1] for one in placed) + _LABEL_MM
    if y + height + _LABEL_MM > bottom:
        return None
    return _Place(place.board, place.pattern, x, y)


def _sheet(paper: Paper, placed: Sequence[_Place]) -> Sheet:
    origins = np.array([[one.x_mm, one.y_mm] for one in placed])
    origins += np.array([one.inset_mm for one in placed])
    shapes = [
        shape + origin
        for place, origin in zip(placed, origins, strict=True)
        for shape in outlines_mm(place.pattern)
    ]
    lines, marks = _scale_bars(paper)
    labels = [
        Caption(
            place.x_mm + 1.0, place.y_mm + place.size_mm[1] + 3.0, _LETTERS_MM, place.board.name
        )
        if place.label_mm
        else Caption(marks[0].x_mm + 25.0, marks[0].y_mm, _LETTERS_MM, place.board.name)
        for place in placed
    ]
    return Sheet(
        paper,
        tuple(shapes),
        np.concatenate([lines, *(_cut_marks(one) for one in placed)]),
        (*labels, *marks, *_captions([one.board for one in placed], paper)),
        origins,
        tuple(one.board for one in placed),
    )


def _cut_marks(place: _Place) -> FloatArray:
    """Short lines at the corners of a marker's white edge, where it may be cut out."""
    if not isinstance(place.board, SingleMarker):
        return np.empty((0, 2, 2))
    corner = np.array([place.x_mm, place.y_mm])
    size = np.array(place.size_mm)
    marks = []
    for side in np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]):
        at = corner + side * size
        marks += [[at, at + inward] for inward in np.diag(2.0 - 4.0 * side)]
    return np.array(marks)


def _scale_bars(paper: Paper) -> tuple[FloatArray, list[Caption]]:
    """A ruler across at the bottom and one down at the left, a tick a millimetre."""
    bottom = _words_top_mm(paper)
    across_mm = _BAR_MM if paper.width_mm >= 150.0 else _SHORT_BAR_MM
    down_mm = _BAR_MM if bottom >= 120.0 else _SHORT_BAR_MM
    corner = np.array([_EDGE_MM + _LEFT_MM - 3.0, bottom + 2.0])
    right, up = np.array([1.0, 0.0]), np.array([0.0, -1.0])
    lines = [*_scale_bar(corner, right, -up, across_mm), *_scale_bar(corner, up, -right, down_mm)]
    end = corner + across_mm * right
    words = [
        Caption(
            float(end[0]) + 1.5, float(end[1]) + 3.0, _LETTERS_MM, f"{across_mm:.0f} mm across"
        ),
        Caption(_EDGE_MM, corner[1] - down_mm - 1.5, _LETTERS_MM, f"{down_mm:.0f} mm"),
    ]
    return np.array(lines), words


def _scale_bar(
    start: FloatArray, along: FloatArray, out: FloatArray, length_mm: float
) -> list[object]:
    lines: list[object] = [[start, start + length_mm * along]]
    for tick in range(round(length_mm) + 1):
        tall = 4.0 if tick % 10 == 0 else 2.6 if tick % 5 == 0 else 1.6
        at = start + tick * along
        lines.append([at, at + tall * out])
    return lines


def _captions(boards: Sequence[Board], paper: Paper) -> list[Caption]:
    """What to do with the sheet, and the manifest's lines for it."""
    x, top = _EDGE_MM + _LEFT_MM - 3.0, _words_top_mm(paper) + 10.5
    tables = (table.replace("\n", "  ").rstrip() for table in manifest_lines(boards))
    lines = (
        "Print at 100 %, not fitted to the page; keep the sheet flat. Where both rulers measure",
        "another length, multiply the lengths below (_m) by it over the ruler's own; where they",
        "differ from each other the printer stretches one way: do not use this sheet.",
        *tables,
    )
    return [Caption(x, top + row * _LINE_MM, _LETTERS_MM, line) for row, line in enumerate(lines)]


def manifest_lines(boards: Sequence[Board]) -> tuple[str, ...]:
    """Tables of a manifest that describe boards, each once.

    Several single markers of a kind are one `[markers]` table.

    >>> from motorcade.replays.tasks.printing import manifest_lines
    >>> from motorcade.tracking import SingleMarker
    >>> print(manifest_lines([SingleMarker("tag36h11", k, 0.05) for k in range(3)])[0].rstrip())
    [markers]
    family = "tag36h11"
    side_m = 0.05
    """
    if len(boards) == 1:
        return (board_toml(boards[0]),)
    return tuple(
        dict.fromkeys(
            markers_toml(board.family, board.side_m)
            if isinstance(board, SingleMarker)
            else board_toml(board)
            for board in boards
        )
    )


@dataclass(frozen=True)
class Paper:
    """A size of paper, upright or lying.

    Fields:
        name: for people.
        width_mm, height_mm: of the sheet.
    """

    name: str
    width_mm: float
    height_mm: float

    def lying(self) -> Paper:
        """The same paper turned by a quarter."""
        return Paper(self.name, self.height_mm, self.width_mm)


# ISO 216, and ANSI Y14.1's in inches of 25.4 mm.
PAPERS = {
    paper.name: paper
    for paper in (
        Paper("a4", 210.0, 297.0),
        Paper("letter", 215.9, 279.4),
        Paper("legal", 215.9, 355.6),
        Paper("a3", 297.0, 420.0),
        Paper("tabloid", 279.4, 431.8),
        Paper("a2", 420.0, 594.0),
        Paper("a1", 594.0, 841.0),
        Paper("a0", 841.0, 1189.0),
    )
}
"""The sizes that have names, from the smallest on."""

_LARGEST_MM = 5000.0


def paper_named(name: str) -> Paper:
    """A paper by its name, in any case, or by its size, such as ``300x400mm``.

    Raises:
        ValueError: neither.

    >>> from motorcade.replays.tasks.printing import paper_named
    >>> paper_named("A4").height_mm, paper_named("300x400mm").width_mm
    (297.0, 300.0)
    """
    if name.lower() in PAPERS:
        return PAPERS[name.lower()]
    if match := re.fullmatch(r"(\d{1,4}(?:\.\d{1,3})?)x(\d{1,4}(?:\.\d{1,3})?)mm", name):
        width, height = (float(one) for one in match.groups())
        if min(width, height) > 0.0 and max(width, height) <= _LARGEST_MM:
            return Paper(name, min(width, height), max(width, height))
    raise ValueError(
        f"paper: expected {', '.join(PAPERS)} or a size of at most {_LARGEST_MM:.0f} mm such as "
        f"300x400mm, got {name[:40]!r}"
    )


_Corner = tuple[int, int]


def outlines_mm(pattern: Pattern) -> tuple[FloatArray, ...]:
    """Closed polygons round a pattern's black areas and round the white holes in them.

    Returns:
        corners ``(n, 2)`` of each, millimetres from the pattern's origin, x right and y down;
        filled by the even-odd rule they are the black, each bit of it once.

    >>> from motorcade.replays.tasks.printing import outlines_mm
    >>> from motorcade.tracking import Checkerboard
    >>> shapes = outlines_mm(Checkerboard(3, 3, square_m=0.01).pattern)
    >>> len(shapes), shapes[0].min(axis=0)  # eight black squares, one corner above the origin
    (8, array([-10., -10.]))
    """
    follow = _edges(~pattern.white)
    edges_mm = 1e3 * pattern.x_edges_m, 1e3 * pattern.y_edges_m
    shapes = []
    while follow:
        loop = _loop(follow)
        shapes.append(np.array([[edges_mm[0][column], edges_mm[1][row]] for row, column in loop]))
    return tuple(shapes)


def _edges(black: NDArray[np.bool_]) -> dict[_Corner, list[_Corner]]:
    """Where an edge between black and white leads from each corner, black to its right."""
    padded = np.pad(black, 1)
    follow: dict[_Corner, list[_Corner]] = {}
    for row, column in np.argwhere(padded):
        top, left = int(row) - 1, int(column) - 1
        bottom, right = top + 1, left + 1
        for white, start, end in (
            (not padded[row - 1, column], (top, left), (top, right)),
            (not padded[row, column + 1], (top, right), (bottom, right)),
            (not padded[row + 1, column], (bottom, right), (bottom, left)),
            (not padded[row, column - 1], (bottom, left), (top, left)),
        ):
            if white:
                follow.setdefault(start, []).append(end)
    return follow


def _loop(follow: dict[_Corner, list[_Corner]]) -> list[_Corner]:
    """Take one closed outline out of `follow`; of its straight runs only the ends are kept.

    Where two black cells touch by a corner it turns right, and so stays with the cell it follows.
    """
    start = min(follow)
    loop: list[_Corner] = [start]
    heading = (0, 0)
    while True:
        here = loop[-1]
        ends = follow[here]
        turned = (heading[1], -heading[0])  # right of (down, right) steps
        right = (here[0] + turned[0], here[1] + turned[1])
        end = right if right in ends else ends[0]
        ends.remove(end)
        if not ends:
            del follow[here]
        step = (end[0] - here[0], end[1] - here[1])
        if step == heading:
            loop.pop()
        heading = step
        if end == start:
            return loop
        loop.append(end)


_POINTS_PER_MM = 72.0 / 25.4
_THIN_MM = 0.15
_EVEN_ODD = 0


def sheets_pdf(sheets: Sequence[Sheet]) -> bytes:
    """Write sheets as a PDF of their true sizes; the same sheets give the same bytes.

    >>> from motorcade.replays.tasks.printing import lay_out, paper_named
    >>> from motorcade.replays.tasks.printing import sheets_pdf
    >>> from motorcade.tracking import SingleMarker
    >>> sheets_pdf(lay_out([SingleMarker("tag36h11", 3, 0.08)], paper_named("a4")))[:5]
    b'%PDF-'
    """
    from reportlab.pdfgen.canvas import Canvas

    file = io.BytesIO()
    canvas = Canvas(file, invariant=1, pageCompression=1)
    canvas.setTitle(", ".join(board.name for sheet in sheets for board in sheet.boards)[:200])
    canvas.setViewerPreference("PrintScaling", "None")
    for sheet in sheets:
        width, height = sheet.paper.width_mm, sheet.paper.height_mm
        canvas.setPageSize((width * _POINTS_PER_MM, height * _POINTS_PER_MM))
        canvas.scale(_POINTS_PER_MM, _POINTS_PER_MM)
        path = canvas.beginPath()
        for shape in sheet.outlines:
            path.moveTo(shape[0, 0], height - shape[0, 1])
            for x, y in shape[1:]:
                path.lineTo(x, height - y)
            path.close()
        canvas.drawPath(path, stroke=0, fill=1, fillMode=_EVEN_ODD)
        canvas.setLineWidth(_THIN_MM)
        canvas.lines([(a[0], height - a[1], b[0], height - b[1]) for a, b in sheet.lines])
        for word in sheet.words:
            canvas.setFont("Helvetica", word.size_mm)
            canvas.drawString(word.x_mm, height - word.y_mm, word.text)
        canvas.showPage()
    canvas.save()
    return file.getvalue()


def sheet_svg(sheet: Sheet) -> bytes:
    """Write a sheet as an SVG of its true size; browsers and Inkscape print it so at 100 %.

    >>> from motorcade.replays.tasks.printing import lay_out, paper_named
    >>> from motorcade.replays.tasks.printing import sheet_svg
    >>> from motorcade.tracking import SingleMarker
    >>> sheet_svg(lay_out([SingleMarker("tag36h11", 3, 0.08)], paper_named("a4"))[0])[:49]
    b'<svg xmlns="http://www.w3.org/2000/svg" width="21'
    """
    width, height = sheet.paper.width_mm, sheet.paper.height_mm
    shapes = " ".join(
        "M" + "L".join(f"{x:.6g},{y:.6g}" for x, y in shape) + "Z" for shape in sheet.outlines
    )
    lines = " ".join(f"M{a[0]:.6g},{a[1]:.6g}L{b[0]:.6g},{b[1]:.6g}" for a, b in sheet.lines)
    words = "\n".join(
        f'<text x="{word.x_mm:.6g}" y="{word.y_mm:.6g}" font-size="{word.size_mm:.6g}">'
        f"{escape(word.text)}</text>"
        for word in sheet.words
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
        f'viewBox="0 0 {width:g} {height:g}">\n'
        f'<path fill="#fff" d="M0,0H{width:g}V{height:g}H0Z"/>\n'
        f'<path fill-rule="evenodd" d="{shapes}"/>\n'
        f'<path fill="none" stroke="#000" stroke-width="{_THIN_MM}" d="{lines}"/>\n'
        f'<g font-family="Helvetica, Arial, sans-serif">\n{words}\n</g>\n</svg>\n'
    ).encode()
