"""Normalised squares of errors over time, NEES and NIS, with the bounds that χ² gives them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.render.plots.errors import TINT, Series, nested_width
from motorcade.render.plots.style import (
    GRID,
    INK,
    WIDTH_IN,
    as_svg,
    house_style,
    label_over_time,
    label_plainly,
    line_style,
    new_figure,
    thinned,
)

__all__ = ["plot_squares"]


def plot_squares(
    series: Mapping[str, Series],
    expected: float,
    bounds: tuple[float, float],
    label: str,
    unit: str,
    *,
    dots: bool = False,
) -> str:
    """Squares over time, what is expected of them as a dashed line, and their bounds as a tint.

    Args:
        series: a name of `style.COLOURS` to (seconds (N,), squares (N,) above 0). Lines are drawn
            within each other.
        expected: degrees of freedom.
        bounds: low and high, of one square or of an average over runs, as the series is.
        label: what is drawn.
        unit: stands at the axis.
        dots: squares of one run, each by itself, in place of lines.

    Returns:
        An `<svg>` element; the axis is logarithmic and the legend left to the page.
    """
    highest = max(float(values.max()) for _, values in series.values())
    lowest = min(float(values.min()) for _, values in series.values())
    with house_style():
        figure, (axes,) = new_figure(WIDTH_IN, 2.4)
        axes.axhspan(*bounds, color=TINT, alpha=0.3, linewidth=0)
        axes.axhline(expected, color=INK, linewidth=0.9, linestyle=(0, (5, 3)), zorder=8.0)
        for i, (name, (time_s, values)) in enumerate(series.items()):
            style = line_style(name) | {"zorder": 2.0 + i}
            if dots:
                _dots(axes, time_s, values, style)
            else:
                style |= {"linewidth": nested_width(i, len(series))}
                axes.plot(*thinned(time_s, values), **style)
        axes.set_yscale("log")
        label_plainly(axes.yaxis)
        bottom = min(bounds[0], max(lowest, 0.01 * bounds[0]))
        axes.set_ylim(0.7 * bottom, 1.4 * max(highest, bounds[1]))
        axes.grid(visible=True, color=GRID)
        label_over_time(axes, unit)
        return as_svg(figure, label)


def _dots(axes: Any, time_s: FloatArray, values: FloatArray, style: dict[str, Any]) -> None:
    """Dots as strokes of no length in one path: a fifth of what single marks take in a file."""
    gap = np.full(len(values), np.nan)
    across = np.stack([time_s, time_s, gap], axis=-1).ravel()
    up = np.stack([values, values, gap], axis=-1).ravel()
    (line,) = axes.plot(across, up, **(style | {"linewidth": 2.6}), solid_capstyle="round")
    line.get_path().should_simplify = False
