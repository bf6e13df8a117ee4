"""Colours by name, on light and on dark paper: those of CLUScript, and of the paper itself.

Colours of objects are chosen to be told apart on both; black and white are the ink, and a grey.
"""

from __future__ import annotations

OBJECT_COLORS = {
    "blue": "#3a7fd5",
    "orange": "#e07a1f",
    "green": "#2f9e57",
    "magenta": "#c2459f",
    "cyan": "#1798a8",
    "red": "#d8453e",
    "yellow": "#b8930f",
    "white": "#8d98a5",
}
# On light paper, and on dark.
PAPER_COLORS = {
    "paper": ("#ffffff", "#161b22"),
    "black": ("#1f2933", "#e6edf3"),
    "axis": ("#6b7785", "#8b98a6"),
    "grid": ("#e3e7ec", "#2a323c"),
}
CYCLE = tuple(OBJECT_COLORS)[:7]


def checked_color(name: str) -> str:
    """The name of a colour in small letters. Raises ValueError: no colour of ours."""
    small = name.lower() if isinstance(name, str) else ""
    if small not in OBJECT_COLORS and small != "black":
        known = ", ".join([*OBJECT_COLORS, "black"])
        raise ValueError(f"color: expected {known}, got {name!r}")
    return small


def nearest_color(red: float, green: float, blue: float) -> str:
    """The colour of ours that is nearest to one with parts from 0 to 1."""
    pure = {
        "blue": (0, 0, 1), "orange": (1, 0.5, 0), "green": (0, 1, 0), "magenta": (1, 0, 1),
        "cyan": (0, 1, 1), "red": (1, 0, 0), "yellow": (1, 1, 0), "white": (1, 1, 1),
        "black": (0, 0, 0),
    }  # fmt: skip
    return min(
        pure,
        key=lambda name: sum(
            (a - b) ** 2 for a, b in zip(pure[name], (red, green, blue), strict=True)
        ),
    )
