"""The report of a run, as files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ReportFiles:
    """The page, and its figures as JSON."""

    page: Path
    summary: Path
