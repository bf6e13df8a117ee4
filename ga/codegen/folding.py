"""What an operation on numbers comes to, worked out while code is generated."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

__all__ = ["folded"]

_FUNCTIONS: dict[str, Callable[..., float]] = {
    "add": lambda x, y: x + y, "sub": lambda x, y: x - y, "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y, "neg": lambda x: -x, "abs": abs, "min": min, "max": max,
    "floor": math.floor, "ceil": math.ceil, "sqrt": math.sqrt, "exp": math.exp, "log": math.log,
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "asin": math.asin, "acos": math.acos,
    "atan": math.atan, "atan2": math.atan2,
}  # fmt: skip
_COMPARISONS: dict[str, Callable[..., bool]] = {
    "lt": lambda x, y: x < y, "le": lambda x, y: x <= y,
    "eq": lambda x, y: x == y, "ne": lambda x, y: x != y, "not": lambda x: x == 0.0,
    "and": lambda x, y: x != 0.0 and y != 0.0, "or": lambda x, y: x != 0.0 or y != 0.0,
}  # fmt: skip


def folded(op: str, values: Sequence[float]) -> float | None:
    """The value, None for other operations and where it is not finite: that is left to run.

    True and false are 1 and 0.
    """
    if op in _COMPARISONS:
        return float(_COMPARISONS[op](*values))
    try:
        value = float(_FUNCTIONS[op](*values)) if op in _FUNCTIONS else math.nan
    except (ArithmeticError, ValueError):
        return None
    return value if math.isfinite(value) else None
