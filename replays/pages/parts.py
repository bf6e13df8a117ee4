"""What pages are made of: cells of tables, and plots with their captions."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["PageCell", "PagePlot"]


@dataclass(frozen=True)
class PageCell:
    """A cell of a table.

    Fields:
        text: what is shown.
        value: what it is sorted by, where it is a number.
        tint: a class of the style sheet.
        best: whether it is the best of its column.
        note: shown beside it, or when it is pointed at.
    """

    text: str
    value: float | None = None
    tint: str = ""
    best: bool = False
    note: str = ""


@dataclass(frozen=True)
class PagePlot:
    """Heading, caption, the `<svg>` element, and the names of its lines for the legend."""

    title: str
    caption: str
    svg: str
    names: tuple[str, ...] = ()
