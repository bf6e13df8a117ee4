"""The report of a run, as files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ReportFiles:
    """The page, its figures as JSON, and what lies beside it where it would be too large inside.

    Fields:
        page, summary: the page and its figures.
        footage: a copy of the footage that the viewer plays; None where it is inside.
        viewer: the viewer; None where it is inside.
    """

    page: Path
    summary: Path
    footage: Path | None = None
    viewer: Path | None = None
