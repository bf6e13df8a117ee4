"""Elementary functions of any scalar: plain numbers, NumPy batches, CasADi symbols, torch tensors.

Plain numbers give plain floats, so that they never turn float32 batches into float64. Of symbols
only those functions are used that every target of the code generator has.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from motorcade.ga.algebra.scalars import is_numeric


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
