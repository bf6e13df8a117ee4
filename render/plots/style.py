"""The house style of plots: quiet axes, colour-blind safe lines, readable on light and dark pages.

Figures are drawn once, with marker colours for ink, grid and page; `as_svg` turns these into CSS
variables (`--ink`, `--grid`, `--page`), so that the page decides. Line colours are those of
Okabe and Ito, "Color Universal Design" (2008), which keep apart on both grounds.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

INK, GRID, PAGE = "#123456", "#abcdef", "#fedcba"
COLOURS = {
    "truth": INK,
    "measured": "#999999",
    "fused": "#56b4e9",
    "motor": "#009e73",
    "similarity": "#8c8c00",
    "rotor": "#56b4e9",
    "dual_quaternion": "#0072b2",
    "quaternion": "#e69f00",
    "euler_unwrapped": "#cc79a7",
    "euler": "#d55e00",
    "euler_exact": "#cc79a7",
}
"""One colour a name, the same in every report; no plot has both of two that share one."""

_VARIABLES = {INK: "var(--ink)", GRID: "var(--grid)", PAGE: "var(--page)"}


@contextmanager
def house_style() -> Iterator[None]:
    """Matplotlib settings that hold inside the block; nothing global changes."""
    import matplotlib as mpl

    settings: Any = {
        "font.family": "sans-serif",
        "font.size": 9.0,
        "axes.titlesize": 10.0,
        "axes.titlelocation": "left",
        "axes.edgecolor": GRID,
        "axes.facecolor": PAGE,
        "axes.labelcolor": INK,
        "axes.titlecolor": INK,
        "axes.grid": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "figure.facecolor": PAGE,
        "figure.constrained_layout.use": True,
        "grid.color": GRID,
        "grid.linewidth": 0.6,
        "legend.frameon": False,
        "legend.labelcolor": INK,
        "lines.linewidth": 1.2,
        "lines.solid_joinstyle": "round",
        "text.color": INK,
        "xtick.color": INK,
        "ytick.color": INK,
        "xtick.major.size": 0.0,
        "ytick.major.size": 0.0,
        "svg.fonttype": "none",
        "svg.hashsalt": "motorcade",
    }
    with mpl.rc_context(settings):
        yield


def new_figure(width_in: float, height_in: float, columns: int = 1) -> tuple[Figure, list[Axes]]:
    """A figure that belongs to no window system, with its axes side by side."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in))
    axes = figure.subplots(1, columns, squeeze=False)
    return figure, list(axes[0])


def line_style(name: str) -> dict[str, Any]:
    """Colour and weight of the line called `name`; the truth lies thin on top of the others."""
    emphasis = {"truth": 0.9, "measured": 0.7, "motor": 1.7}
    return {
        "label": name,
        "color": COLOURS[name],
        "linewidth": emphasis.get(name, 1.1),
        "zorder": 5.0 if name == "truth" else 3.0 if name == "motor" else 2.0,
    }


def label_plainly(axis: Axis) -> None:
    """Label a logarithmic axis with 0.1 and 10 rather than with powers."""
    from matplotlib.ticker import LogFormatter

    class Plain(LogFormatter):
        def __call__(self, x: float, pos: int | None = None) -> str:
            return f"{x:g}" if super().__call__(x, pos) else ""

    axis.set_major_formatter(Plain())
    axis.set_minor_formatter(Plain())


def as_svg(figure: Figure) -> str:
    """The figure as an `<svg>` element that takes its ink from the page around it."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r'width="[\d.]+pt" height="[\d.]+pt"', 'width="100%"', svg, count=1)
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    for colour, variable in _VARIABLES.items():
        svg = svg.replace(colour, variable)
    return svg


def with_own_ids(svg: str, mark: str) -> str:
    """The same picture with ids that no other picture on the page has, given marks that differ."""
    svg = re.sub(r'\bid="([^"]+)"', rf'id="{mark}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#{mark}-\1)", svg)
    return re.sub(r'xlink:href="#([^"]+)"', rf'xlink:href="#{mark}-\1"', svg)


def standing_alone(svg: str) -> str:
    """An `<svg>` element of `as_svg` as a file of its own, dark on white."""
    return svg.replace("<svg ", '<svg style="--ink:#222222;--grid:#dddddd;--page:#ffffff" ', 1)
