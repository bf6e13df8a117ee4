"""What a coefficient may be, and the few functions of it that the algebra itself needs.

Numbers and NumPy arrays are checked when they come in. Anything else that adds, multiplies and has
a sign is taken as it is: CasADi SX, torch tensors, fractions.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from motorcade.ga.arrays import sealed


def checked_scalar(value: Any, name: str) -> Any:
    """Refuse what is no real, finite scalar; arrays become read-only copies of floats.

    Raises ValueError: no scalar, complex, NaN or infinity.
    """
    if isinstance(value, np.ndarray):
        return _checked_array(value, name)
    if isinstance(value, float | int | np.integer | np.floating) and not isinstance(value, bool):
        if not math.isfinite(value):
            raise ValueError(f"{name}: expected a finite number, got {value}")
        return value
    needed = ("__add__", "__mul__", "__sub__", "__neg__")
    if isinstance(value, bool | complex | np.generic) or not all(hasattr(value, n) for n in needed):
        raise ValueError(f"{name}: expected a real scalar, got {type(value).__name__} {value!r}")
    return value


def _checked_array(value: np.ndarray[Any, Any], name: str) -> np.ndarray[Any, Any]:
    if value.dtype.kind not in "fiu":
        raise ValueError(f"{name}: expected real numbers, got dtype {value.dtype}")
    kept = value.dtype if value.dtype.kind == "f" else np.dtype(np.float64)
    array = np.array(value, dtype=kept, copy=True)
    if not np.isfinite(array).all():
        bad = int(array.size - np.count_nonzero(np.isfinite(array)))
        raise ValueError(
            f"{name}: expected finite numbers, got {bad} NaN or infinite of {array.size}"
        )
    return sealed(array)


def is_numeric(value: Any) -> bool:
    """Whether NumPy can look at the number itself."""
    return isinstance(value, float | int | np.number | np.ndarray)


def is_zero_somewhere(value: Any) -> bool:
    """Whether a scalar is zero, or one of a batch; symbols count as not zero."""
    if hasattr(value, "is_zero"):
        return bool(value.is_zero())
    return bool(np.any(value == 0)) if is_numeric(value) else _any(value == 0)


def _any(value: Any) -> bool:
    return bool(value.any()) if hasattr(value, "any") else bool(value)


def scaled(factor: float | Fraction, value: Any) -> Any:
    """A scalar times a constant that is a whole number or a fraction; fractions stay such."""
    if factor == 1:
        return value
    if factor == -1:
        return -value
    if factor % 1 == 0:
        return value * int(factor)
    return value * (Fraction(factor) if isinstance(value, Fraction) else float(factor))


def square_root(value: Any) -> Any:
    """Square root of any scalar."""
    if is_numeric(value) or not hasattr(value, "sqrt"):
        return np.sqrt(value)
    return value.sqrt()


def magnitude(value: Any) -> Any:
    """Absolute value of any scalar."""
    return value.fabs() if hasattr(value, "fabs") else abs(value)
