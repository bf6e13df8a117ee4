"""Typed access to JSON that came from outside: what is not as it must be is refused by name."""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.animation.formats.errors import expected
from motorcade.ga.arrays import FloatArray


def table(value: object, field: str) -> dict[str, Any]:
    """A JSON object."""
    if not isinstance(value, dict):
        raise expected(field, "an object", value)
    return value


def listed(value: object, field: str) -> list[Any]:
    """A JSON array."""
    if not isinstance(value, list):
        raise expected(field, "an array", value)
    return value


def text(value: object, field: str) -> str:
    """A string."""
    if not isinstance(value, str):
        raise expected(field, "a string", value)
    return value


def integer(value: object, field: str, low: int, high: int) -> int:
    """A whole number in a range."""
    if type(value) is int and low <= value <= high:
        return value
    if isinstance(value, float) and value.is_integer() and low <= value <= high:
        return int(value)
    raise expected(field, f"a whole number from {low} to {high}", value)


def floats(value: object, field: str, count: int) -> FloatArray:
    """An array of `count` finite numbers."""
    given = listed(value, field)
    if len(given) != count or not all(type(part) in (int, float) for part in given):
        raise expected(field, f"{count} numbers", given)
    try:
        made = np.array(given, dtype=np.float64)
    except OverflowError as fault:
        raise expected(field, f"{count} numbers", "one that is too large") from fault
    if not np.isfinite(made).all() or np.abs(made).max(initial=0.0) > 1e9:
        raise expected(field, "finite numbers up to 1e9", given)
    return made
