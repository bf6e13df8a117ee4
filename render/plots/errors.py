"""Quantities over time, one line a trajectory or representation, and bands about them.

Errors of several estimates against one ground truth: over time, along the way, and over the values
of what a sweep varies.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from statistics import median
from typing import TYPE_CHECKING, Any

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
    numbered_style,
    plane_axes,
    thinned,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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


def plot_bands(bands: Mapping[str, Band], label: str, unit: str) -> str:
    """Middles as lines within tinted bands, values above 0 on a logarithmic axis.

    `bands` maps a name of `style.COLOURS` to its band; the legend is left to the page.
    """
    with house_style():
        figure, (axes,) = new_figure(WIDTH_IN, 2.4)
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


# A path is drawn as at most so many strokes: more than its width on a page has pixels.
_STROKES = 1500
_PANEL_IN = 2.0
_MAP_IN = 3.2


@dataclass(frozen=True, eq=False)
class ErrorsAlong:
    """Errors of one estimate, in the world of its ground truth.

    Fields:
        time_s: of the P paired poses ``(P,)``.
        path_m: their positions ``(P, 3)``.
        position_m, rotation_deg: absolute errors ``(P,)``.
        relative_time_s: when the segments end that relative errors are of, in order ``(S,)``.
        relative_m: relative errors of the positions ``(S,)``.

    >>> import numpy as np
    >>> from motorcade.render.plots import ErrorsAlong
    >>> time_s, path_m = np.arange(3.0), np.zeros((3, 3))
    >>> ErrorsAlong(time_s, path_m, time_s, time_s, time_s[1:], time_s[1:]).relative_m
    array([1., 2.])
    """

    time_s: FloatArray
    path_m: FloatArray
    position_m: FloatArray
    rotation_deg: FloatArray
    relative_time_s: FloatArray
    relative_m: FloatArray


def plot_errors_along(
    errors: Mapping[str, ErrorsAlong], reference_m: FloatArray, relative: str, plane: str = ""
) -> str:
    """Errors over time, and a map of each estimate coloured by its position error: an `<svg>`.

    Args:
        errors: by the names of the estimates, which the legend shows.
        reference_m: positions of the ground truth ``(N, 3)``, one or more.
        relative: what the relative errors are over, such as "1 frames".
        plane: of the maps, "xy", "xz" or "yz"; where it is empty, the one in which the ground
            truth goes farthest.

    >>> import numpy as np
    >>> from motorcade.render.plots import ErrorsAlong, plot_errors_along
    >>> time_s = np.linspace(0.0, 1.0, 20)
    >>> path_m = np.stack([time_s, np.sin(time_s), 0.0 * time_s], axis=-1)
    >>> one = ErrorsAlong(time_s, path_m, time_s, time_s, time_s[1:], time_s[1:])
    >>> plot_errors_along({"slam": one}, path_m, "1 frames").startswith("<svg")
    True
    """
    from matplotlib.figure import Figure

    across, up = plane_axes(plane, reference_m)
    rows = 3 + len(errors)
    heights = [_PANEL_IN] * 3 + [_MAP_IN] * len(errors)
    with house_style():
        figure = Figure(figsize=(WIDTH_IN, sum(heights)))
        panels = figure.subplots(rows, 1, squeeze=False, height_ratios=heights)[:, 0]
        for number, (name, error) in enumerate(errors.items()):
            style = numbered_style(name, number)
            panels[0].plot(*thinned(error.time_s, error.position_m), **style)
            panels[1].plot(*thinned(error.time_s, error.rotation_deg), **style)
            panels[2].plot(*thinned(error.relative_time_s, error.relative_m), **style)
        for axes, title, unit in zip(
            panels,
            ("position error", "rotation error", f"relative position error over {relative}"),
            ("m", "°", "m"),
            strict=False,
        ):
            axes.set_title(title)
            label_over_time(axes, f"error ({unit})")
            axes.set_ylim(bottom=0.0)
        panels[0].legend(loc="upper left", fontsize=9)
        most_m = max(float(one.position_m.max()) for one in errors.values())
        for axes, (name, error) in zip(panels[3:], errors.items(), strict=True):
            _map(axes, name, error, reference_m, (across, up), most_m)
        return as_svg(figure, f"errors of {', '.join(errors)} over time and along the way")


def _map(
    axes: Axes,
    name: str,
    errors_along: ErrorsAlong,
    reference_m: FloatArray,
    sides: tuple[int, int],
    most_m: float,
) -> None:
    """The ground truth as a thin line, the estimate coloured by its error, on one scale for all."""
    from matplotlib.collections import LineCollection

    truth = _strided(reference_m)[:, sides]
    axes.plot(*truth.T, color=INK, linewidth=0.6, label="ground truth")
    ours = _strided(np.column_stack([errors_along.path_m[:, sides], errors_along.position_m]))
    strokes = np.stack([ours[:-1, :2], ours[1:, :2]], axis=1)
    lines = LineCollection(list(strokes), cmap="viridis", linewidths=1.8)
    lines.set_array(ours[1:, 2])
    lines.set_clim(0.0, most_m or 1.0)
    axes.add_collection(lines)
    axes.set_aspect("equal", adjustable="datalim")
    axes.autoscale_view()
    axes.set_title(name)
    axes.set_xlabel(f"{'xyz'[sides[0]]} (m)")
    axes.set_ylabel(f"{'xyz'[sides[1]]} (m)")
    axes.locator_params(nbins=5)
    axes.figure.colorbar(lines, ax=axes, label="position error (m)")


def _strided(rows: FloatArray) -> FloatArray:
    """At most `_STROKES` rows, evenly chosen, with both ends."""
    if len(rows) <= _STROKES:
        return rows
    chosen: FloatArray = rows[np.linspace(0, len(rows) - 1, _STROKES).round().astype(int)]
    return chosen


_WIDTH, _HEIGHT = 300, 170
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 8, 10, 34
_LONGEST = 14


def strip(
    values: Mapping[str, Mapping[str, Sequence[float]]], colours: Mapping[str, str], label: str
) -> str:
    """Draw medians and ranges, logarithmic where all figures are above 0.

    Args:
        values: what varied -> path -> the figures of its runs, in the shown unit; none are empty.
        colours: path -> CSS colour.
        label: what the plot shows, for those who cannot see it.
    """
    every = [one for paths in values.values() for figures in paths.values() for one in figures]
    logarithmic = min(every) > 0.0
    low, high = _limits(every, logarithmic)
    place = _Axis(low, high, logarithmic)
    parts = [
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{escape(label)}" '
        'font-size="10" font-family="system-ui, sans-serif" fill="currentColor">'
    ]
    for tick in dict.fromkeys((low, place.middle(), high)):
        y = place.y(tick)
        parts.append(
            f'<path d="M{_LEFT} {y:.1f}H{_WIDTH - _RIGHT}" stroke="currentColor" opacity=".15"/>'
            f'<text x="{_LEFT - 5}" y="{y + 3:.1f}" text-anchor="end">{tick:.3g}</text>'
        )
    step = (_WIDTH - _LEFT - _RIGHT) / len(values)
    for number, (value, paths) in enumerate(values.items()):
        middle = _LEFT + step * (number + 0.5)
        shown = value if len(value) <= _LONGEST else "…" + value[1 - _LONGEST :]
        parts.append(
            f'<text x="{middle:.1f}" y="{_HEIGHT - 14}" text-anchor="middle">'
            f"<title>{escape(value)}</title>{escape(shown)}</text>"
        )
        for order, (path, figures) in enumerate(paths.items()):
            x = middle + min(9.0, step / (len(paths) + 1)) * (order - (len(paths) - 1) / 2)
            top, bottom = place.y(max(figures)), place.y(min(figures))
            colour = escape(colours[path])
            parts.append(
                f'<path d="M{x:.1f} {top:.1f}V{bottom:.1f}" stroke="{colour}" stroke-width="2"/>'
                f'<circle cx="{x:.1f}" cy="{place.y(median(figures)):.1f}" r="3.2" '
                f'fill="{colour}"><title>{escape(path)}: {median(figures):.4g}</title></circle>'
            )
    return "".join([*parts, "</svg>"])


class _Axis:
    """Figures to heights on the plot."""

    def __init__(self, low: float, high: float, logarithmic: bool) -> None:
        self._log = logarithmic
        self._low, self._high = self._scaled(low), self._scaled(high)

    def _scaled(self, value: float) -> float:
        return math.log10(value) if self._log else value

    def y(self, value: float) -> float:
        """Pixels from the top."""
        share = (self._scaled(value) - self._low) / (self._high - self._low)
        return _HEIGHT - _BOTTOM - share * (_HEIGHT - _TOP - _BOTTOM)

    def middle(self) -> float:
        """The figure half-way up."""
        half = (self._low + self._high) / 2
        return float(10.0**half) if self._log else half


def _limits(every: Sequence[float], logarithmic: bool) -> tuple[float, float]:
    low, high = min(every), max(every)
    if low < high:
        return low, high
    return (low / 1.1, high * 1.1) if logarithmic else (low - 1.0, high + 1.0)
