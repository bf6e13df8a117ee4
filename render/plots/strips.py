"""Small plots of a sweep: a figure against the values of one thing that varied, as SVG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from statistics import median

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
