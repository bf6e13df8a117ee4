"""Advice for a name that is not known: the nearest of those that are."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_NAMES_SHOWN = 12


def nearest_name(name: str, allowed: Iterable[str]) -> str:
    """`"; did you mean …?"` to close a message that lists all names; nothing where none is near.

    >>> nearest_name("gausian", ["gaussian", "spline"])
    '; did you mean gaussian?'
    >>> nearest_name("7", ["gaussian", "spline"])
    ''
    """
    near = difflib.get_close_matches(name[:100], list(allowed), n=1, cutoff=0.5)
    return f"; did you mean {near[0]}?" if near else ""


def did_you_mean(name: str, allowed: Iterable[str]) -> str:
    """Give the nearest valid name, or the first dozen of them, as advice for an unknown one."""
    names = list(allowed)
    if near := nearest_name(name, names):
        return near.removeprefix("; ")
    shown = ", ".join(names[:_NAMES_SHOWN]) or "none"
    more = len(names) - _NAMES_SHOWN
    return f"known here: {shown}" + (f" and {more} more" if more > 0 else "")
