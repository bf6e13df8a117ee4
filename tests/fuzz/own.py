"""Which errors are ours: raised by a `raise` of the product, of a type meant for users."""

from __future__ import annotations

import linecache
import re
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import motorcade.ga

__all__ = ["RefusedError", "ended", "is_own", "refusals"]

PRODUCT = Path(motorcade.ga.__file__).parents[1]  # the repository, or where a wheel was installed
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
OURS = (ValueError, TypeError, OSError, RuntimeError)
LONGEST = 2000
_COMPILED = re.compile(r"[\w.()\[\]]+: expected ")
"""How errors of our compiled code begin, which no line of Python raises."""


class RefusedError(Exception):
    """An input was refused by an error of ours."""


def is_own(fault: BaseException) -> bool:
    """Whether the product raised this itself, as a `ValueError` or a type of its own.

    An error of another library, or of the interpreter, that passes through is not.
    """
    kind = type(fault)
    named = kind.__module__.startswith("motorcade.") or kind in OURS
    last = traceback.extract_tb(fault.__traceback__)[-1]
    place = Path(last.filename)
    inside = any(place.is_relative_to(PRODUCT / room) for room in ROOMS)
    line = linecache.getline(last.filename, last.lineno or 0).strip()
    said = line.startswith("raise") or _COMPILED.match(str(fault)) is not None
    return named and inside and said


@contextmanager
def refusals() -> Iterator[None]:
    """Errors of ours as `RefusedError`; all others pass."""
    try:
        yield
    except Exception as fault:
        if not is_own(fault):
            raise
        told = str(fault)
        if not told or "\n" in told or len(told) > LONGEST:
            raise AssertionError(f"told in {told[:300]!r}") from fault
        raise RefusedError(told) from fault


def ended(act: Callable[[], object]) -> str:
    """How something ended: "valid" or "refused"; faults pass."""
    try:
        with refusals():
            act()
    except RefusedError:
        return "refused"
    return "valid"
