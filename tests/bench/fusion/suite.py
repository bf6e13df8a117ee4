"""`make bench SUITE=fusion`: simulation, filters and smoothers of inertial data, part by part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from tests.bench.fusion.flights import bench_flights, flights_table
from tests.bench.fusion.inertial_slam import bench_inertial_slam, inertial_slam_table
from tests.bench.fusion.offsets import bench_offsets, offsets_table
from tests.bench.fusion.orientation import bench_orientation, orientation_table
from tests.bench.fusion.simulator import bench_simulator, simulator_table
from tests.bench.fusion.speed import bench_speed, speed_table
from tests.bench.fusion.tag_odometry import bench_tag_odometry, tag_odometry_table
from tests.bench.fusion.visual_inertial import (
    bench_visual_inertial,
    visual_inertial_table,
)

__all__ = ["PARTS", "bench_fusion", "fusion_table"]

PARTS: Mapping[str, tuple[Callable[..., Any], Callable[[Any], str]]] = {
    "simulator": (bench_simulator, simulator_table),
    "flights": (bench_flights, flights_table),
    "offsets": (bench_offsets, offsets_table),
    "tags": (bench_tag_odometry, tag_odometry_table),
    "visual inertial": (bench_visual_inertial, visual_inertial_table),
    "inertial slam": (bench_inertial_slam, inertial_slam_table),
    "orientation": (bench_orientation, orientation_table),
    "speed": (bench_speed, speed_table),
}
"""Every part by name: what measures it, and what prints it."""


def bench_fusion(parts: Iterable[str] = PARTS, **sizes: Any) -> dict[str, Any]:
    """Measure these parts; sizes are arguments of what measures them."""
    return {name: PARTS[name][0](**sizes) for name in parts}


def fusion_table(found: Mapping[str, Any]) -> str:
    """The tables of the parts that were measured, one below the other."""
    return "\n\n".join(table(found[name]) for name, (_, table) in PARTS.items() if name in found)
