"""Times of jobs as bars, each beside the figure that it has to beat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from motorcade.render.plots.style import (
    HUES,
    INK,
    WIDTH_IN,
    as_svg,
    house_style,
    new_figure,
)

__all__ = ["Timing", "plot_timings"]

_BAR_IN = 0.42


@dataclass(frozen=True)
class Timing:
    """A job, its figure, and another program's for the same job where one is known."""

    job: str
    figure: float
    to_beat: float | None = None


def plot_timings(timings: Sequence[Timing], rival: str, label: str, unit: str) -> str:
    """Bars from zero, the job above each, and a mark where the rival stands.

    Args:
        timings: one or more, figures above 0, in `unit`.
        rival: whose figures `to_beat` are; it stands below the axis where there are any.
        label: what is drawn.
        unit: stands at the axis.

    Returns:
        An `<svg>` element.
    """
    figures = [one.figure for one in timings]
    marks = [one.to_beat for one in timings if one.to_beat is not None]
    with house_style():
        figure, (axes,) = new_figure(WIDTH_IN, 0.7 + _BAR_IN * len(timings))
        for row, one in enumerate(timings):
            axes.barh(-row, one.figure, height=0.3, color=HUES["green"][0])
            axes.text(0.0, 0.22 - row, one.job, va="bottom", fontsize=9)
            end = max(one.figure, one.to_beat or 0.0)
            axes.text(end, -row, f"  {one.figure:.3g}", va="center", fontsize=9)
            if one.to_beat is not None:
                at = [one.to_beat] * 2
                axes.plot(at, [-row - 0.2, -row + 0.2], color=INK, linewidth=2.0, zorder=3.0)
        axes.set_ylim(0.5 - len(timings), 0.75)
        axes.set_xlim(0.0, 1.15 * max(figures + marks))
        axes.set_yticks([])
        axes.grid(visible=False, axis="y")
        axes.set_xlabel(f"{unit}; upright marks: {rival}" if marks else unit)
        return as_svg(figure, label)
