"""Quantities over time, one line a trajectory or representation, and bands about them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.render.plots.style import (
    AXIS_COLOURS,
    COLOURS,
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

Series = tuple[NDArray[Any], NDArray[Any]]
TINT = "#999999"
_BAND_SPANS = 150


@dataclass(frozen=True, eq=False)
class Band:
    """A middle and what lies about it, each ``(N,)``: percentiles over runs, for example.

    >>> import numpy as np
    >>> from motorcade.render.plots import Band
    >>> nees = np.random.default_rng(0).chisquare(6, (100, 50))  # 100 runs, 50 stamps
    >>> band = Band(np.arange(50) / 10.0, *np.percentile(nees, [5, 50, 95], axis=0))
    >>> bool(np.all(band.low < band.middle) and np.all(band.middle < band.high))
    True
    """

    time_s: FloatArray
    low: FloatArray
    middle: FloatArray
    high: FloatArray


def plot_series(
    series: Mapping[str, Series],
    label: str,
    unit: str,
    *,
    log_scale: bool = False,
    shaded_s: tuple[tuple[float, float], ...] = (),
    height_in: float = 2.4,
    width_in: float = WIDTH_IN,
    nested: bool = False,
    limits: tuple[float, float] | None = None,
    over: str = "time",
) -> str:
    """`series` maps a name of `style.COLOURS` to (seconds (N,), values (N,)); an `<svg>` element.

    `label` says what is drawn, `unit` stands at the axis; the legend is left to the page. Spans of
    `shaded_s` (start, end in seconds) are tinted: blackouts, lost frames. `nested` draws each line
    thinner than the one before it and on top, so that lines that coincide are all seen. `limits`
    are the ends of the axis of values, `over` the name of the seconds.

    >>> import numpy as np
    >>> from motorcade.render.plots import plot_series
    >>> time_s = np.linspace(0.0, 1.0, 20)
    >>> plot_series({"motor": (time_s, np.sin(time_s))}, "a sine", "m").startswith("<svg")
    True
    """
    with house_style():
        figure, (axes,) = new_figure(width_in, height_in)
        for start, end in shaded_s:
            axes.axvspan(start, end, color=TINT, alpha=0.25, linewidth=0)
        for i, (name, (time_s, values)) in enumerate(series.items()):
            nest = {}
            if nested and name != "measured":  # noise, which a thick line would spread over all
                nest = {"linewidth": nested_width(i, len(series)), "zorder": 2.0 + i}
            axes.plot(*thinned(time_s, values), **(line_style(name) | nest))
        if log_scale:
            axes.set_yscale("log")
            label_plainly(axes.yaxis)
        if limits is not None:
            axes.set_ylim(*limits)
        label_over_time(axes, unit, over)
        return as_svg(figure, label)


def nested_width(number: int, count: int) -> float:
    """Points across of the n-th of so many lines that are drawn within each other."""
    return 3.8 - 2.9 * number / max(count - 1, 1)


def plot_bands(bands: Mapping[str, Band], label: str, unit: str, *, height_in: float = 2.4) -> str:
    """Middles as lines within tinted bands, values above 0 on a logarithmic axis.

    `bands` maps a name of `style.COLOURS` to its band; the legend is left to the page.
    """
    with house_style():
        figure, (axes,) = new_figure(WIDTH_IN, height_in)
        for i, (name, band) in enumerate(bands.items()):
            tint = axes.fill_between(band.time_s, band.low, band.high, color=COLOURS[name])
            tint.set(alpha=0.22, linewidth=0.0, zorder=2.0 + 0.1 * i)
            line = line_style(name) | {"linewidth": nested_width(i, len(bands)), "zorder": 3.0 + i}
            axes.plot(band.time_s, band.middle, **line)
        axes.set_yscale("log")
        label_plainly(axes.yaxis)
        label_over_time(axes, unit)
        return as_svg(figure, label)


def plot_within_sigma(
    time_s: FloatArray, errors: FloatArray, sigma: FloatArray, label: str, unit: str
) -> str:
    """Errors ``(N, 3)`` of x, y and z, a panel each, over the bands of ±1σ and ±2σ, an `<svg>`.

    `sigma` ``(N, 3)`` are the deviations that the filter states. Where it is right, errors lie in
    the inner band 68 % of the time and in the outer one 95 %.
    """
    with house_style():
        figure, panels = new_figure(WIDTH_IN, 3.9, rows=3)
        for column, (axes, name) in enumerate(zip(panels, "xyz", strict=True)):
            for times, alpha in ((2.0, 0.22), (1.0, 0.3)):
                at_s, reach = thinned(time_s, times * sigma[:, column], _BAND_SPANS)
                axes.fill_between(at_s, -reach, reach, color=TINT, alpha=alpha, linewidth=0)
            line = thinned(time_s, errors[:, column])
            axes.plot(*line, color=AXIS_COLOURS[column])
            axes.set_ylabel(f"{name} ({unit})")
            axes.margins(x=0.01)
        panels[-1].set_xlabel("time (s)")
        return as_svg(figure, label)


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
