"""The house style of pages: one frame, style and script for every report, each page one file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.render.plots.style import ON_PAGES, page_colours

if TYPE_CHECKING:
    from jinja2 import Environment


_TEMPLATES = Path(__file__).with_name("templates")


def page_environment(folder: Path) -> Environment:
    """Templates of a folder, which may extend `base.html` and take macros from `parts.html`.

    `base.html` brings the style, light and dark, and a script that sorts tables of the class
    `sortable` by their headings: by the numbers in `<data>` elements where there are any, else by
    text. `COLOURS` maps names of `render.plots.style` to CSS.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader([folder, _TEMPLATES]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(known=_known)
    environment.globals.update(COLOURS=ON_PAGES, page_colours=page_colours())
    return environment


def _known(value: float | None) -> bool:
    """Whether a cell's number is one."""
    return value is not None and math.isfinite(value)


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
