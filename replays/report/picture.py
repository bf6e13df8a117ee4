"""One plot of the page."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Picture"]


@dataclass(frozen=True)
class Picture:
    """Heading, caption, the `<svg>` element, and the names of its lines for the legend."""

    title: str
    caption: str
    svg: str
    names: tuple[str, ...]
