"""`motorcade bench memory`: what long recordings take at most, each run in a process of its own."""

from __future__ import annotations

from motorcade.replays.bench.memory.suite import bench_memory, memory_table

__all__ = ["bench_memory", "memory_table"]
