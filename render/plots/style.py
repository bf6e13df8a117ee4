"""The house style of plots: quiet axes, colour-blind safe lines, readable on light and dark pages.

Figures are drawn once, with marker colours for ink, grid and page and the light shade of each line;
`as_svg` turns all of these into CSS variables, so that the page decides. `page_colours` is the CSS
that a page needs for its lines. The hues are near those of Okabe and Ito, "Color Universal Design"
(2008), moved until each has a contrast of 3 or more to its page, and any two that share a plot
differ by 12 or more in CIEDE2000, also as protanopes, deuteranopes and tritanopes see them.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from html import escape
from itertools import cycle, pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.versors.euler_angles import SEQUENCES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

INK, GRID, PAGE = "#123456", "#abcdef", "#fedcba"
PRINTED = ("#222222", "#dddddd", "#ffffff")
"""Ink, grid and page of figures that are files of their own."""

HUES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "grey": ("#929292", "#b2b2b2"),
        "sky": ("#0196fd", "#63c8ff"),
        "green": ("#1a9a65", "#00ae7f"),
        "olive": ("#676347", "#9a9905"),
        "blue": ("#276698", "#0479c5"),
        "orange": ("#dd7800", "#ffb925"),
        "pink": ("#b379af", "#be8ab8"),
        "vermilion": ("#b6540f", "#b14e00"),
        "brown": ("#401a03", "#7f6173"),
    }
)
"""Shades of lines on a light and on a dark page."""

_HUE_OF = {
    "measured": "grey",
    "fused": "sky",
    "motor": "green",
    "similarity": "olive",
    "rotor": "sky",
    "dual_quaternion": "blue",
    "quaternion": "orange",
    "euler_best": "brown",
    "euler_unwrapped": "pink",
    "euler": "vermilion",
    "euler_exact": "pink",
} | dict(zip((f"euler_{order}" for order in SEQUENCES), cycle(("brown", "pink", "vermilion"))))

COLOURS = {"truth": INK} | {name: HUES[hue][0] for name, hue in _HUE_OF.items()}
"""One colour a name, the same in every report; no plot has both of two that share one, but those
of Euler angles in more than three orders."""

ON_PAGES = {"truth": "var(--ink)"} | {name: f"var(--line-{hue})" for name, hue in _HUE_OF.items()}
ON_PAGES |= {"x": "var(--line-vermilion)", "y": "var(--line-green)", "z": "var(--line-blue)"}
"""The same and the axes as CSS, for pages that hold `page_colours`."""

AXIS_COLOURS = tuple(HUES[hue][0] for hue in ("vermilion", "green", "blue"))
"""Of x, y and z."""

_NUMBERED = tuple(HUES[hue][0] for hue in ("blue", "orange", "green", "pink", "vermilion", "sky"))
_DASHES = ("-", "--", ":", "-.")

WIDTH_IN = 5.0
"""Half of a wide page, and all of a phone, where text is then as large as it is here."""

_VARIABLES = {INK: "var(--ink)", GRID: "var(--grid)", PAGE: "var(--page)"} | {
    light: f"var(--line-{hue})" for hue, (light, _) in HUES.items()
}


def page_colours() -> str:
    """CSS that names the lines' colours, by the page's ground."""
    light, dark = (
        ";".join(f"--line-{hue}:{shades[ground]}" for hue, shades in HUES.items())
        for ground in (0, 1)
    )
    return f":root{{{light}}}@media (prefers-color-scheme:dark){{:root{{{dark}}}}}"


@contextmanager
def house_style(ink: str = INK, grid: str = GRID, page: str = PAGE) -> Iterator[None]:
    """Matplotlib settings that hold inside the block; nothing global changes."""
    import matplotlib as mpl

    settings: Any = {
        "font.family": "sans-serif",
        "font.size": 10.0,
        "axes.titlesize": 10.0,
        "axes.titlelocation": "left",
        "axes.edgecolor": grid,
        "axes.facecolor": page,
        "axes.labelcolor": ink,
        "axes.titlecolor": ink,
        "axes.grid": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "figure.facecolor": page,
        "figure.constrained_layout.use": True,
        "grid.color": grid,
        "grid.linewidth": 0.6,
        "legend.frameon": False,
        "legend.labelcolor": ink,
        "lines.linewidth": 1.2,
        "lines.solid_joinstyle": "round",
        "path.simplify_threshold": 0.3,  # points, a third of a thin line
        "text.color": ink,
        "xtick.color": ink,
        "ytick.color": ink,
        "xtick.major.size": 0.0,
        "ytick.major.size": 0.0,
        "svg.fonttype": "none",
        "svg.hashsalt": "motorcade",
    }
    with mpl.rc_context(settings):
        yield


def new_figure(
    width_in: float, height_in: float, columns: int = 1, rows: int = 1
) -> tuple[Figure, list[Axes]]:
    """A figure that belongs to no window system, with its axes side by side or stacked.

    Stacked axes share what runs across.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in))
    axes = figure.subplots(rows, columns, squeeze=False, sharex=rows > 1)
    return figure, list(axes.ravel())


def line_style(name: str) -> dict[str, Any]:
    """Colour and weight of the line called `name`; the ground truth is thin and on top."""
    emphasis = {"truth": 0.9, "measured": 0.7, "motor": 1.7}
    return {
        "label": name,
        "color": COLOURS[name],
        "linewidth": emphasis.get(name, 1.1),
        "zorder": 5.0 if name == "truth" else 3.0 if name == "motor" else 2.0,
    }


def numbered_style(name: str, number: int) -> dict[str, Any]:
    """Colour and dashes of the line called `name`, of any number of lines."""
    return {
        "label": name,
        "color": _NUMBERED[number % len(_NUMBERED)],
        "linestyle": _DASHES[number // len(_NUMBERED) % len(_DASHES)],
    }


def plane_axes(plane: str, points_m: FloatArray) -> tuple[int, int]:
    """The two axes of "xy", "xz" or "yz"; of "", those in which points ``(N, 3)`` go farthest."""
    if plane:
        return "xyz".index(plane[0]), "xyz".index(plane[1])
    flattest = int(np.argmin(np.ptp(points_m, axis=0)[::-1]))  # z where two are alike
    across, up = (axis for axis in range(3) if axis != 2 - flattest)
    return across, up


def thinned(
    time_s: FloatArray, values: FloatArray, spans: int = 600
) -> tuple[FloatArray, FloatArray]:
    """A long line as the least and the largest value of each of its spans; a short one as it is.

    At the width of plots the two look the same with 600.
    """
    if len(values) <= 2 * spans:
        return time_s, values
    edges = np.linspace(0, len(values), spans + 1).round().astype(int)
    kept = {0, len(values) - 1}
    for start, end in pairwise(edges.tolist()):
        kept |= {
            start + int(np.argmin(values[start:end])),
            start + int(np.argmax(values[start:end])),
        }
    rows = np.array(sorted(kept))
    return time_s[rows], values[rows]


def label_over_time(axes: Axes, unit: str, over: str = "time") -> None:
    """Axes of values in a unit over seconds."""
    axes.set_xlabel(f"{over} (s)")
    axes.set_ylabel(unit)
    axes.margins(x=0.01)


def label_plainly(axis: Axis) -> None:
    """Label a logarithmic axis with 0.1 and 10 rather than with powers."""
    from matplotlib.ticker import LogFormatter

    class Plain(LogFormatter):
        def __call__(self, x: float, pos: int | None = None) -> str:
            return f"{x:g}" if super().__call__(x, pos) else ""

    axis.set_major_formatter(Plain())
    axis.set_minor_formatter(Plain())


def as_svg(figure: Figure, label: str) -> str:
    """The figure as an `<svg>` element that takes its ink and type from the page around it.

    `label` says what it shows to those who cannot see it.
    """
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    size = rf'width="100%" role="img" aria-label="{escape(label)}"'
    svg = re.sub(r'width="[\d.]+pt" height="[\d.]+pt"', lambda _: size, svg, count=1)
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"font-family: [^;\"]+", "font-family: system-ui, sans-serif", svg)
    svg = re.sub(r' transform="rotate\(-?0 [^"]*"', "", svg)
    svg = re.sub(r'(?<= )(?:d|x|y)="[^"]*"', _rounded, svg)
    svg = re.sub(r'(?<= )d="[ML\s\d.e-]*"', _shortened, svg)
    for colour, variable in _VARIABLES.items():
        svg = svg.replace(colour, variable)
    return svg


def _rounded(attribute: re.Match[str]) -> str:
    """Coordinates to a hundredth of a point, less than any screen shows."""
    return re.sub(r"-?\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}", attribute[0])


def _shortened(drawn: re.Match[str]) -> str:
    """Strokes without a letter each: what follows the beginning of a line are its other ends."""
    return re.sub(r"\s*\bL (?=-?[\d.])", " ", drawn[0]).replace(" \n", "\n")


def with_own_ids(svg: str, mark: str) -> str:
    """The same image with ids that no other image on the page has, given marks that differ."""
    svg = re.sub(r'\bid="([^"]+)"', rf'id="{mark}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#{mark}-\1)", svg)
    return re.sub(r'xlink:href="#([^"]+)"', rf'xlink:href="#{mark}-\1"', svg)


def standing_alone(svg: str) -> str:
    """An `<svg>` element of `as_svg` as a file of its own, light or dark as viewers prefer."""
    style = (
        ":root{--ink:#222222;--grid:#dddddd;--page:#ffffff}@media (prefers-color-scheme:dark)"
        "{:root{--ink:#e4e9f0;--grid:#323a46;--page:#14181e}}" + page_colours()
    )
    return re.sub(r"(<svg [^>]*>)", lambda head: f"{head[1]}<style>{style}</style>", svg, count=1)
