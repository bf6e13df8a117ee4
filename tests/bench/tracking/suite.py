"""`make bench SUITE=tracking`: accuracy and milliseconds of tracking, part by part."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from tests.bench.tracking.board_smoothing import bench_board, board_table
from tests.bench.tracking.tag_flips import bench_flips, flips_table
from tests.bench.tracking.tag_map import bench_map, map_table
from tests.bench.tracking.tag_markers import bench_markers, markers_table
from tests.bench.tracking.tag_photometric import bench_photometric, photometric_table
from tests.bench.tracking.tag_recall import bench_recall, recall_table

__all__ = ["PARTS", "bench_tracking", "tracking_table"]

PARTS: Mapping[str, tuple[Callable[[], Any], Callable[[Any], str]]] = {
    "markers": (bench_markers, markers_table),
    "recall": (bench_recall, recall_table),
    "flips": (bench_flips, flips_table),
    "map": (bench_map, map_table),
    "board": (bench_board, board_table),
    "photometric": (bench_photometric, photometric_table),
}
"""Every part by name: what measures it, and what prints it."""


def bench_tracking() -> dict[str, Any]:
    """Measure every part."""
    return {name: measure() for name, (measure, _) in PARTS.items()}


def tracking_table(found: Mapping[str, Any]) -> str:
    """The parts' tables, one below the other."""
    return "\n\n".join(table(found[name]) for name, (_, table) in PARTS.items())
