"""Sizes of paper, by name."""

from __future__ import annotations

import re
from dataclasses import dataclass


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

    >>> from motorcade.replays.printing import paper_named
    >>> paper_named("A4").height_mm, paper_named("300x400mm").width_mm
    (297.0, 300.0)
    """
    if name.lower() in PAPERS:
        return PAPERS[name.lower()]
    if found := re.fullmatch(r"(\d{1,4}(?:\.\d{1,3})?)x(\d{1,4}(?:\.\d{1,3})?)mm", name):
        width, height = (float(one) for one in found.groups())
        if min(width, height) > 0.0 and max(width, height) <= _LARGEST_MM:
            return Paper(name, min(width, height), max(width, height))
    raise ValueError(
        f"paper: expected {', '.join(PAPERS)} or a size of at most {_LARGEST_MM:.0f} mm such as "
        f"300x400mm, got {name[:40]!r}"
    )
