"""The report's plots: errors over time, one line a representation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.render.plots import plot_series
from motorcade.render.plots.style import with_own_ids
from motorcade.replays.compare.report.names import LABELS
from motorcade.replays.compare.report.replayed import Replayed
from motorcade.replays.pages.parts import PagePlot

__all__ = ["large_panels", "small_panels"]

_LOWEST_DEG = 1e-3


def small_panels(drawn: Sequence[Replayed]) -> list[PagePlot]:
    """Rotation errors over time, small enough to stand beside others, on one scale."""
    errors = [one.rotation_errors_deg() for one in drawn]
    ends = [end for one in errors for values in one.values() for end in _ends(values)]
    limits = (max(min(ends), _LOWEST_DEG), 1.2 * max(ends)) if ends else None
    panels = []
    for one, values in zip(drawn, errors, strict=True):
        series = {name: (one.time_s, value) for name, value in values.items()}
        svg = plot_series(
            series,
            f"rotation error, {one.motion}",
            "rotation error (°)",
            log_scale=True,
            width_in=3.6,
            height_in=1.9,
            nested=True,
            limits=limits,
        )
        svg = with_own_ids(svg, f"small-{one.motion}")
        panels.append(PagePlot(one.motion, "", svg, tuple(values)))
    return panels


def _ends(values: FloatArray) -> tuple[float, float]:
    """Nearly the least, as logarithms fall without end where errors pass zero; and the largest."""
    return float(np.percentile(values, 2.0)), float(np.max(values))


def large_panels(drawn: Replayed) -> list[PagePlot]:
    """Rotation error, angular rate and position error over time."""
    lines = {
        "rotation error": (drawn.time_s, drawn.rotation_errors_deg(), "degrees"),
        "angular rate": (drawn.time_s[1:], drawn.turning_deg_s(), "degrees/s"),
        "position error": (drawn.time_s, drawn.position_errors_mm(), "mm"),
    }
    panels = []
    for title, (time_s, values, unit) in lines.items():
        ordered = _nested(values)
        series = {name: (time_s, one) for name, one in ordered.items()}
        svg = plot_series(series, title, unit, log_scale=True, nested=True)
        caption = f"`{drawn.method}` with {LABELS[drawn.degradation]}"
        mark = f"{drawn.degradation}-{drawn.method}-{title.split()[0]}"
        panels.append(PagePlot(title, caption, with_own_ids(svg, mark), tuple(ordered)))
    return panels


def _nested(values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """The truth on top, then what is drawn widest at the bottom first."""
    return {n: v for n, v in values.items() if n != "truth"} | {
        n: v for n, v in values.items() if n == "truth"
    }
