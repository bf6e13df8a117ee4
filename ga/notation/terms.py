"""What all notations of a sum share: which terms are shown, and their signs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import islice
from typing import Any

import numpy as np

Items = Iterable[tuple[str, Any]]
# More terms than anybody reads; a full multivector of five dimensions is shown whole.
MAX_TERMS = 64


def is_number(value: Any) -> bool:
    """Whether a coefficient is one number, and no batch or symbol.

    >>> import numpy as np
    >>> from motorcade.ga.notation.terms import is_number
    >>> is_number(2), is_number(np.float32(0.5)), is_number(np.zeros(3))
    (True, True, False)
    """
    return isinstance(value, float | int | np.number | np.ndarray) and np.ndim(value) == 0


def all_numbers(items: Items) -> bool:
    """Whether every coefficient is one number."""
    return all(is_number(value) for _, value in items)


def rounded(value: Any, digits: int) -> str:
    """The size of a number to so many digits."""
    return f"{abs(float(value)):.{digits}g}"


def sum_of(
    items: Items, term: Callable[[str, Any], str], *, minus: str = "-", left_out: str = "…"
) -> str:
    """Terms joined by signs, zeros left out, the first `MAX_TERMS` of them; `0` without any.

    `term` writes the size of a number beside a blade; what is no number writes itself whole.

    >>> from motorcade.ga.notation.terms import sum_of
    >>> sum_of([("e1", -2), ("e2", 0.0), ("e3", 1)], lambda blade, value: f"{abs(value)}{blade}")
    '-2e1 + 1e3'
    """
    made = ""
    shown = ((blade, value) for blade, value in items if not _is_nothing(value))
    for count, (blade, value) in enumerate(islice(shown, MAX_TERMS + 1)):
        negative = is_number(value) and value < 0
        text = left_out if count == MAX_TERMS else term(blade, value)
        if not made:
            made = f"{minus}{text}" if negative else text
        else:
            made += f" {minus if negative and count < MAX_TERMS else '+'} {text}"
    return made or "0"


def _is_nothing(value: Any) -> bool:
    return is_number(value) and bool(value == 0)
