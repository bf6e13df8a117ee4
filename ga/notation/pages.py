"""Sums of blades as HTML, which notebooks show with nothing from anywhere, exported ones too."""

from __future__ import annotations

import re
from html import escape
from typing import Any

from motorcade.ga.notation.terms import Items, all_numbers, rounded, sum_of

_DIGITS = 6


def sum_page(items: Items) -> str | None:
    """A sum of blades with numbers alone; None for batches and symbols, which are text.

    >>> from motorcade.ga.notation.pages import sum_page
    >>> print(sum_page([("1", 0.5), ("e1^einf", -2.0)]))
    <span>0.5 − 2 <b>e</b><sub>1</sub>∧<b>e</b><sub>∞</sub></span>
    """
    items = list(items)
    return f"<span>{sum_of(items, _term, minus='−')}</span>" if all_numbers(items) else None


def _term(blade: str, value: Any) -> str:
    mantissa, _, exponent = rounded(value, _DIGITS).partition("e")
    size = f"{mantissa}·10<sup>{_power(exponent)}</sup>" if exponent else mantissa
    if blade == "1":
        return size
    vectors = "∧".join(map(_vector, blade.split("^")))
    return vectors if size == "1" else f"{size} {vectors}"


def _power(exponent: str) -> str:
    return str(int(exponent)).replace("-", "−")


def _vector(name: str) -> str:
    found = re.fullmatch(r"e(\w+)", name)
    if found is None:
        return f"<i>{escape(name)}</i>"
    return f"<b>e</b><sub>{'∞' if found[1] == 'inf' else escape(found[1])}</sub>"
