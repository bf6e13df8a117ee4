"""Quantities over time, one line a trajectory or representation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from motorcade.render.plots.style import (
    as_svg,
    house_style,
    label_plainly,
    line_style,
    new_figure,
)

Series = tuple[NDArray[Any], NDArray[Any]]


def plot_series(
    series: Mapping[str, Series],
    title: str,
    unit: str,
    *,
    log_scale: bool = False,
    shaded_s: tuple[tuple[float, float], ...] = (),
    height_in: float = 2.3,
    width_in: float = 9.0,
    nested: bool = False,
    limits: tuple[float, float] | None = None,
    band: tuple[float, float] | None = None,
) -> str:
    """`series` maps a name of `style.COLOURS` to (seconds (N,), values (N,)); an `<svg>` element.

    Spans of `shaded_s` (start, end in seconds) are tinted: blackouts, lost frames. `nested` draws
    each line thinner than the one before it and on top, so that lines that coincide are all seen,
    and leaves the legend to the page. `limits` are the ends of the axis of values;
    values between those of `band` are tinted.
    """
    with house_style():
        figure, (axes,) = new_figure(width_in, height_in)
        for start, end in shaded_s:
            axes.axvspan(start, end, color="#999999", alpha=0.25, linewidth=0)
        if band is not None:
            axes.axhspan(*band, color="#999999", alpha=0.4, linewidth=0)
        for i, (name, (time_s, values)) in enumerate(series.items()):
            nest = {"linewidth": max(3.4 - 0.5 * i, 0.7), "zorder": 2.0 + i} if nested else {}
            axes.plot(time_s, values, **(line_style(name) | nest))
        if log_scale:
            axes.set_yscale("log")
            label_plainly(axes.yaxis)
        if limits is not None:
            axes.set_ylim(*limits)
        axes.set_title(title)
        axes.set_xlabel("time (s)")
        axes.set_ylabel(unit)
        axes.margins(x=0.01)
        if not nested:
            # Above the axes, beside the title, where it hides no line.
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(series), fontsize=8)
        return as_svg(figure)
