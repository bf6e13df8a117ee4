"""Advice for a name that is not known: the nearest of those that are."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_NAMES_SHOWN = 12


def did_you_mean(name: str, allowed: Iterable[str]) -> str:
    """Give the nearest valid name, or the first dozen of them, as advice for an unknown one."""
    names = list(allowed)
    near = difflib.get_close_matches(name[:100], names, n=1, cutoff=0.5)
    if near:
        return f"did you mean {near[0]}?"
    shown = ", ".join(names[:_NAMES_SHOWN]) or "none"
    more = len(names) - _NAMES_SHOWN
    return f"known here: {shown}" + (f" and {more} more" if more > 0 else "")
