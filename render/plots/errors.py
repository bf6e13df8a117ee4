"""Quantities over time, one line a trajectory or representation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from motorcade.render.plots.style import as_svg, house_style, line_style, new_figure

Series = tuple[NDArray[Any], NDArray[Any]]


def plot_series(
    series: Mapping[str, Series],
    title: str,
    unit: str,
    *,
    log_scale: bool = False,
    shaded_s: tuple[tuple[float, float], ...] = (),
    height_in: float = 2.3,
) -> str:
    """`series` maps a name of `style.COLOURS` to (seconds (N,), values (N,)); an `<svg>` element.

    Spans of `shaded_s` (start, end in seconds) are tinted: blackouts, lost frames.
    """
    with house_style():
        figure, (axes,) = new_figure(9.0, height_in)
        for start, end in shaded_s:
            axes.axvspan(start, end, color="#999999", alpha=0.25, linewidth=0)
        for name, (time_s, values) in series.items():
            axes.plot(time_s, values, **line_style(name))
        if log_scale:
            axes.set_yscale("log")
        axes.set_title(title)
        axes.set_xlabel("time (s)")
        axes.set_ylabel(unit)
        axes.margins(x=0.01)
        # Above the axes, beside the title, where it hides no line.
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(series), fontsize=8)
        return as_svg(figure)
