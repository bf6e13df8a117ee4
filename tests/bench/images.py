"""Times of the suite `animation` as bars, beside what ozz-animation needs for the same."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from tests.bench.timing_bars import Timing, plot_timings

__all__ = ["OZZ_NS", "animation_image"]

OZZ_NS: Mapping[str, float] = MappingProxyType(
    {
        "two samples, blend": 25.3,
        "two layers": 2.7,
        "skinning, position and normal, linear, one core": 4.4,
    }
)
"""Nanoseconds a joint or vertex, by how jobs of ours begin: 67 joints on one core of a machine of
the same class, `-march=native`; of its two times for skinning the lower."""

_UNITS = ("ns a joint", "ns a vertex")


def animation_image(found: Mapping[str, Any]) -> str:
    """An `<svg>` element of the figures of `bench_animation`: posing, blending and skinning.

    Raises:
        ValueError: figures without any of these.
    """
    timings = [
        Timing(row["job"], float(row["figure"]), _to_beat(row["job"]))
        for row in found["rows"]
        if row["unit"] in _UNITS and "NumPy" not in row["job"]
    ]
    if not timings:
        raise ValueError(f"found.rows: expected jobs in {' or '.join(_UNITS)}, got none")
    return plot_timings(
        timings,
        "ozz-animation",
        "time of posing and blending a joint, and of skinning a vertex",
        "ns a joint, or a vertex skinned",
    )


def _to_beat(job: str) -> float | None:
    return next((ns for start, ns in OZZ_NS.items() if job.startswith(start)), None)
