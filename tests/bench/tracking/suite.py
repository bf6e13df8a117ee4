"""`make bench SUITE=tracking`: accuracy and milliseconds of tracking, part by part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from tests.bench.tracking.board_smoothing import bench_board, board_table
from tests.bench.tracking.tag_flips import bench_flips, flips_table
from tests.bench.tracking.tag_map import bench_map, map_table
from tests.bench.tracking.tag_markers import bench_markers, markers_table
from tests.bench.tracking.tag_photometric import bench_photometric, photometric_table
from tests.bench.tracking.tag_recall import bench_recall, recall_table

__all__ = ["PARTS", "bench_tracking", "tracking_table"]

PARTS: Mapping[str, tuple[Callable[..., Any], Callable[[Any], str]]] = {
    "markers": (bench_markers, markers_table),
    "recall": (bench_recall, recall_table),
    "flips": (bench_flips, flips_table),
    "map": (bench_map, map_table),
    "board": (bench_board, board_table),
    "photometric": (bench_photometric, photometric_table),
}
"""Every part by name: what measures it, and what prints it."""


def bench_tracking(parts: Iterable[str] = PARTS, **sizes: Any) -> dict[str, Any]:
    """Measure these parts; sizes are arguments of what measures them."""
    return {name: PARTS[name][0](**sizes) for name in parts}


def tracking_table(found: Mapping[str, Any]) -> str:
    """The tables of the parts that were measured, one below the other."""
    return "\n\n".join(table(found[name]) for name, (_, table) in PARTS.items() if name in found)
