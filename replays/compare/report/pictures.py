"""The report's plots: errors over time, one line a representation."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from motorcade.ga import FloatArray
from motorcade.render.plots import plot_series
from motorcade.replays.compare.report.replayed import Replayed

__all__ = ["Panel", "large_panels", "small_panel"]


@dataclass(frozen=True)
class Panel:
    """A plot with its heading and caption; `names` are the lines in it."""

    title: str
    caption: str
    svg: str
    names: tuple[str, ...]


def small_panel(drawn: Replayed) -> Panel:
    """Rotation error over time, small enough to stand beside others."""
    errors = _nested(drawn.rotation_errors_deg())
    series = {name: (drawn.time_s, values) for name, values in errors.items()}
    svg = plot_series(
        series, "", "rotation error (°)", log_scale=True, width_in=3.6, height_in=1.9, nested=True
    )
    return Panel(drawn.motion, "", _apart(svg, f"small-{drawn.motion}"), tuple(errors))


def large_panels(drawn: Replayed) -> list[Panel]:
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
        svg = plot_series(series, "", unit, log_scale=True, height_in=2.6, nested=True)
        caption = (
            f"`{drawn.method}`, {drawn.degradation}, seed {drawn.seed}; logarithmic. Lines that "
            "coincide lie within each other."
        )
        mark = f"{drawn.degradation}-{drawn.method}-{title.split()[0]}"
        panels.append(Panel(title, caption, _apart(svg, mark), tuple(ordered)))
    return panels


def _nested(values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """The truth on top, then what is drawn widest at the bottom first."""
    return {n: v for n, v in values.items() if n != "truth"} | {
        n: v for n, v in values.items() if n == "truth"
    }


def _apart(svg: str, mark: str) -> str:
    """The same picture with names that no other picture on the page has."""
    svg = re.sub(r'\bid="([^"]+)"', rf'id="{mark}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#{mark}-\1)", svg)
    return re.sub(r'xlink:href="#([^"]+)"', rf'xlink:href="#{mark}-\1"', svg)
