"""Sums of blades in plain text, as CLUScript writes them: ``1.5 + 2*e1^e2 - einf``.

Numbers have eight digits, as NumPy prints them; ``x.values`` has them whole. Zeros are left out. A
batch is shown by its first and last numbers and its shape, a symbol by its own text.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga.notation.terms import Items, is_number, rounded, sum_of

_DIGITS = 8
_DIGITS_OF_BATCHES = 4
_MOST_OF_A_BATCH = 4
_LONGEST_SYMBOL = 60


def sum_text(items: Items) -> str:
    """A sum of blades on one line.

    >>> import numpy as np
    >>> from motorcade.ga.notation.plain import sum_text
    >>> sum_text([("1", 1.5), ("e1", 0.0), ("e1^e2", 2.0), ("einf", -1.0)])
    '1.5 + 2*e1^e2 - einf'
    >>> sum_text([("e1", np.linspace(0.0, 1.0, 11)), ("e2", 1 / 3)])
    '[0, 0.1, …, 0.9, 1](11)*e1 + 0.33333333*e2'
    """
    return sum_of(items, _term)


def _term(blade: str, value: Any) -> str:
    text = _coefficient(value)
    if blade == "1":
        return text
    return blade if text == "1" and is_number(value) else f"{text}*{blade}"


def _coefficient(value: Any) -> str:
    if is_number(value):
        return rounded(value, _DIGITS)
    if isinstance(value, np.ndarray):
        return _batch(value)
    text = " ".join(str(value).split())
    if len(text) > _LONGEST_SYMBOL:
        text = f"{text[:_LONGEST_SYMBOL]}…"
    return text if text.isidentifier() else f"({text})"


def _batch(value: np.ndarray[Any, Any]) -> str:
    """A few of the numbers, and the shape where they are not all there."""
    flat = value.ravel()
    shown = [f"{float(number):.{_DIGITS_OF_BATCHES}g}" for number in _ends(flat)]
    if flat.size > _MOST_OF_A_BATCH:
        shown.insert(_MOST_OF_A_BATCH // 2, "…")
    whole = value.ndim == 1 and flat.size <= _MOST_OF_A_BATCH
    shape = "" if whole else f"({', '.join(map(str, value.shape))})"
    return f"[{', '.join(shown)}]{shape}"


def _ends(flat: np.ndarray[Any, Any]) -> list[Any]:
    if flat.size <= _MOST_OF_A_BATCH:
        return list(flat)
    half = _MOST_OF_A_BATCH // 2
    return [*flat[:half], *flat[-half:]]
