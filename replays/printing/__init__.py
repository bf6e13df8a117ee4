"""Boards and markers as sheets to print: laid out in millimetres, written as PDF or SVG."""

from __future__ import annotations

from motorcade.replays.printing.paper import PAPERS, Paper, paper_named
from motorcade.replays.printing.sheets import Sheet, lay_out

__all__ = ["PAPERS", "Paper", "Sheet", "lay_out", "paper_named"]
