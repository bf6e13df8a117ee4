"""The suites of `make bench`: what measures each, and what prints its figures."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

__all__ = ["SUITES", "run_suite"]

SUITES: Mapping[str, tuple[str, str, str]] = {
    "demo": ("demo", "bench_demo", "demo_table"),
    "stages": ("stages", "bench_stages", "stages_table"),
    "blend": ("algebra.blend", "bench_blend", "blend_table"),
    "accuracy": ("algebra.accuracy", "bench_accuracy", "accuracy_table"),
    "conversions": ("algebra.conversions", "bench_conversions", "conversions_table"),
    "compiler": ("algebra.compiler", "bench_compiler", "compiler_table"),
    "table3": ("algebra.table3.measure", "bench_table3", "table3_table"),
    "programs": ("algebra.programs", "bench_programs", "programs_table"),
    "smooth": ("smoothing.smooth", "bench_smooth", "smooth_table"),
    "smoothers": ("smoothing.smoothers", "bench_smoothers", "smoothers_table"),
    "smoother_speed": ("smoothing.long", "bench_long", "long_table"),
    "orders": ("smoothing.orders", "bench_orders", "orders_table"),
    "lag": ("smoothing.lag", "bench_lag", "lag_table"),
    "live": ("smoothing.live", "bench_live", "live_table"),
    "slam": ("tracking.slam", "bench_slam", "slam_table"),
    "fusion": ("fusion.suite", "bench_fusion", "fusion_table"),
    "tracking": ("tracking.suite", "bench_tracking", "tracking_table"),
    "animation": ("animation", "bench_animation", "animation_table"),
    "render": ("render", "bench_render", "render_table"),
    "memory": ("memory.suite", "bench_memory", "memory_table"),
    "view": ("view.suite", "bench_view", "view_table"),
}
"""By name: a module of this package, its function that measures, and the one that prints."""


def run_suite(name: str) -> tuple[Any, str]:
    """Figures that JSON can hold, and their table; imports no other suite, nor what it needs."""
    module, measure, table = SUITES[name]
    suite = import_module(f"tests.bench.{module}")
    found = getattr(suite, measure)()
    return found, getattr(suite, table)(found)
