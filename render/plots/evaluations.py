"""Errors of several estimates against one ground truth: over time, and along the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.render.plots.style import (
    INK,
    WIDTH_IN,
    as_svg,
    house_style,
    label_over_time,
    numbered_style,
    plane_axes,
    thinned,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
        relative_time_s: when the stretches end that relative errors are of, in order ``(S,)``.
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
        for number, (name, one) in enumerate(errors.items()):
            style = numbered_style(name, number)
            panels[0].plot(*thinned(one.time_s, one.position_m), **style)
            panels[1].plot(*thinned(one.time_s, one.rotation_deg), **style)
            panels[2].plot(*thinned(one.relative_time_s, one.relative_m), **style)
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
        for axes, (name, one) in zip(panels[3:], errors.items(), strict=True):
            _map(axes, name, one, reference_m, (across, up), most_m)
        return as_svg(figure, f"errors of {', '.join(errors)} over time and along the way")


def _map(
    axes: Axes,
    name: str,
    one: ErrorsAlong,
    reference_m: FloatArray,
    sides: tuple[int, int],
    most_m: float,
) -> None:
    """The ground truth as a thin line, the estimate coloured by its error, on one scale for all."""
    from matplotlib.collections import LineCollection

    truth = _strided(reference_m)[:, sides]
    axes.plot(*truth.T, color=INK, linewidth=0.6, label="ground truth")
    ours = _strided(np.column_stack([one.path_m[:, sides], one.position_m]))
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
