"""What a coefficient may be, and the elementary functions of it.

Numbers and NumPy arrays are checked when they come in. Anything else that adds, multiplies and has
a sign is taken as it is: CasADi SX, torch tensors, fractions.
"""

from __future__ import annotations

import math
import sys
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


def apply(name: str, *values: Any) -> Any:
    """The function that NumPy calls `name`, of scalars of any kind.

    Raises ValueError: scalars that no such function is known for.
    """
    if all(map(is_numeric, values)):
        results = getattr(np, name)(*values)
        plain = all(type(value) in (int, float) for value in values)
        return float(results) if plain else results
    library, operands = _library(values)
    function = getattr(library, name, None)
    if function is None:
        kinds = ", ".join(sorted({type(value).__name__ for value in values}))
        raise ValueError(f"expected scalars that have {name}, got {kinds}")
    return function(*operands)


def where(condition: Any, chosen: Any, otherwise: Any) -> Any:
    """`chosen` where a comparison holds, else `otherwise`; both are computed."""
    if isinstance(condition, bool | np.bool_):
        return chosen if condition else otherwise
    if isinstance(condition, np.ndarray) and is_numeric(chosen) and is_numeric(otherwise):
        return np.where(condition, chosen, otherwise)
    library, operands = _library((condition, chosen, otherwise))
    function = getattr(library, "if_else", None) or library.where
    return function(*operands)


def arctangent(y: Any, x: Any) -> Any:
    """The angle of the point ``(x, y)``, from -π to π."""
    return apply("arctan2", y, x)


def larger(a: Any, b: Any) -> Any:
    """The larger of two."""
    return apply("fmax", a, b)


def smaller(a: Any, b: Any) -> Any:
    """The smaller of two."""
    return apply("fmin", a, b)


def step(x: Any) -> Any:
    """1 where ``x >= 0``, otherwise 0."""
    return where(x >= 0, 1.0, 0.0)


def sign(x: Any) -> Any:
    """1, 0 or -1."""
    return where(x > 0, 1.0, where(x < 0, -1.0, 0.0))


def signed(value: Any, like: Any, sign: int) -> Any:
    """A number with the sign of another one, which is `sign` where that is not 0."""
    if sign == 0:
        return where(like < 0, -value, value)
    return value if sign > 0 else -value


def power_series(x: Any, coefficients: tuple[float, ...]) -> Any:
    """``c₀ + c₁ x + c₂ x² + …`` by Horner's rule."""
    total: Any = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        total = total * x + coefficient
    return total


def _library(values: tuple[Any, ...]) -> tuple[Any, tuple[Any, ...]]:
    """The module that made the first scalar that is no number, and all of them as it takes them."""
    symbolic = next(value for value in values if not is_numeric(value))
    if hasattr(symbolic, "scalar_functions"):
        return symbolic.scalar_functions(), values
    library = sys.modules[type(symbolic).__module__.partition(".")[0]]
    if not hasattr(library, "as_tensor"):
        return library, values
    kinds = [value.dtype for value in values if not is_numeric(value)]
    kind = next((kind for kind in kinds if kind.is_floating_point), None)
    return library, tuple(
        library.as_tensor(value, dtype=kind) if is_numeric(value) else value for value in values
    )
