"""`motorcade bench fusion`: simulation, filters and smoothers of inertial data, part by part."""

from __future__ import annotations

from motorcade.replays.bench.fusion.suite import bench_fusion, fusion_table

__all__ = ["bench_fusion", "fusion_table"]
