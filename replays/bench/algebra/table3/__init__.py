"""The paper's Table 3 again: blending the poses of three characters, method by method."""

from __future__ import annotations

from motorcade.replays.bench.algebra.table3.measure import bench_table3
from motorcade.replays.bench.algebra.table3.report import table3_table

__all__ = ["bench_table3", "table3_table"]
