"""The functions that every script may call, over any scalars.

``abs`` is ``√|⟨x ~x⟩₀|`` of any multivector, ``invert`` the inverse of any invertible one, and
``exp log sqrt normalize versor`` are those of `algebra.functions`; ``scalar`` is ``⟨x⟩₀``, and
``complement uncomplement`` are the duals that need no metric; ``reverse involute conjugate`` change
signs by grade, ``grade`` and ``coefficient`` take parts. The others take scalars: blades that are
zero, or that rounding left beside a scalar, do not stop it from being one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from motorcade.ga.algebra import Multivector
from motorcade.ga.algebra.functions import elementary
from motorcade.ga.algebra.scalars import is_numeric, is_zero_somewhere, magnitude


class Function(NamedTuple):
    """A function of scripts and how many arguments it takes."""

    arity: int
    apply: Callable[..., Multivector]


# How large, beside the scalar, what rounding leaves of cancelled blades may be.
_ROUNDING = 1e-12
_LARGEST_FACTORIAL = 170

# Functions of Gaalop's, which are called in any case of letters.
_GAALOP = "abs acos asin atan ceil coefficient cos exp fact floor invert log sin sqrt tan"
ANY_CASE = frozenset(_GAALOP.split(" "))


def is_finite(value: Any) -> bool:
    """Whether a number, or all of a batch, is finite; symbols count as finite."""
    return bool(np.isfinite(value).all()) if is_numeric(value) else True


def _scalar(x: Multivector) -> Any:
    value = x.scalar_part()
    beside = [name for name, part in x.items() if name != "1" and not _vanishes(part, value)]
    if beside:
        shown = " ".join(beside[:4]) + (" …" if len(beside) > 4 else "")
        raise ValueError(f"expected a scalar, got a multivector with {shown}")
    return value


def _vanishes(part: Any, beside: Any) -> bool:
    """Whether a coefficient is zero, exactly or to rounding beside the largest scalar of a batch.

    A row whose own scalar cancels has kept the rounding of the terms that did.
    """
    if is_numeric(part):
        size = np.max(np.abs(beside), initial=0.0) if is_numeric(beside) else 0.0
        return bool(np.all(np.abs(part) <= _ROUNDING * size))
    return is_zero_somewhere(part)


def _elementary(numpy_name: str, arity: int = 1) -> Function:
    """A function of scalars that NumPy has, and symbols by the same name."""
    return _of_scalars(lambda *values: elementary.apply(numpy_name, *values), arity)


def _of_scalars(function: Callable[..., Any], arity: int = 1) -> Function:
    def applied(*operands: Multivector) -> Multivector:
        return _scalar_like(operands[0], _finite(function(*map(_scalar, operands))))

    return Function(arity, applied)


def _scalar_like(x: Multivector, value: Any) -> Multivector:
    """A scalar of the algebra of another multivector."""
    algebra: Any = x.algebra
    scalar: Multivector = algebra.scalar(value)
    return scalar


def _like(value: Any, result: Any) -> Any:
    """A plain float where one was given: NumPy's would turn float32 batches into float64."""
    return float(result) if type(value) in (int, float) else result


def _finite(value: Any) -> Any:
    if not is_finite(value):
        raise ValueError("has no finite real value here")
    return value


def _absolute(x: Multivector) -> Multivector:
    if all(name == "1" for name in x.blades):
        return _scalar_like(x, magnitude(x.scalar_part()))
    plain = all(type(value) in (int, float) for value in x.values)
    return _scalar_like(x, _like(0.0, x.norm()) if plain else x.norm())


def _factorial(x: Multivector) -> Multivector:
    value = _scalar(x)
    if not is_numeric(value):
        raise ValueError(f"expected a number, got {type(value).__name__}")
    values = np.asarray(value, dtype=np.float64)
    if np.any((values != np.floor(values)) | (values < 0) | (values > _LARGEST_FACTORIAL)):
        raise ValueError(f"expected whole numbers from 0 to {_LARGEST_FACTORIAL}")
    factorials = np.array([float(math.factorial(int(n))) for n in values.ravel()])
    return _scalar_like(
        x, factorials.reshape(values.shape) if values.ndim else float(factorials[0])
    )


def _coefficient(x: Multivector, blade: Multivector) -> Multivector:
    """The coefficient of a basis blade, which may be written with its vectors in any order."""
    named = _without_zeros(blade)
    parts = [(m, v) for m, v in zip(named.masks, named.values, strict=True) if _not_zero(v)]
    if len(parts) != 1 or type(parts[0][1]) not in (int, float) or abs(parts[0][1]) != 1.0:
        raise ValueError(
            f"expected one basis blade as the second argument, got blades {' '.join(named.blades)}"
        )
    mask, sign = parts[0]
    value = dict(zip(x.masks, x.values, strict=True)).get(mask, 0.0)
    return _scalar_like(x, value if sign > 0 else -value)


def _not_zero(value: Any) -> bool:
    return not (is_numeric(value) and bool(np.all(value == 0)))


def _grade(x: Multivector, number: Multivector) -> Multivector:
    value = _scalar(number)
    highest = x.algebra.dimension
    if type(value) not in (int, float) or value != int(value) or not 0 <= value <= highest:
        raise ValueError(f"expected a grade from 0 to {highest} as the second argument")
    return x.grade(int(value))


def scalar_of(x: Multivector) -> Any:
    """The value of a multivector that is a scalar.

    Raises ValueError: other blades that are not zero.
    """
    return _scalar(x)


def _of_multivector(name: str) -> Function:
    """A method of multivectors; blades that are zero wherever they could be seen are left out."""

    def applied(x: Multivector) -> Multivector:
        multivector: Multivector = getattr(_without_zeros(x), name)()
        return multivector

    return Function(1, applied)


def _without_zeros(x: Multivector) -> Multivector:
    left = [bool(np.all(v == 0)) if is_numeric(v) else is_zero_somewhere(v) for v in x.values]
    gone = {mask for mask, zero in zip(x.masks, left, strict=True) if zero and mask}
    return x._selected(lambda mask: mask not in gone) if gone else x


FUNCTIONS: dict[str, Function] = {
    "Dual": Function(1, lambda x: x.dual()),
    "abs": Function(1, _absolute),
    "acos": _elementary("arccos"),
    "asin": _elementary("arcsin"),
    "atan": _elementary("arctan"),
    "atan2": _elementary("arctan2", 2),
    "ceil": _elementary("ceil"),
    "coefficient": Function(2, _coefficient),
    "complement": Function(1, lambda x: x.complement()),
    "conjugate": Function(1, lambda x: x.conjugate()),
    "cos": _elementary("cos"),
    "exp": _of_multivector("exp"),
    "fact": Function(1, _factorial),
    "floor": _elementary("floor"),
    "grade": Function(2, _grade),
    "involute": Function(1, lambda x: x.involute()),
    "invert": Function(1, lambda x: x.inverse()),
    "log": _of_multivector("log"),
    "max": _elementary("fmax", 2),
    "min": _elementary("fmin", 2),
    "normalize": _of_multivector("normalize"),
    "reverse": Function(1, lambda x: ~x),
    "scalar": Function(1, lambda x: x.grade(0)),
    "sign": _of_scalars(elementary.sign),
    "sin": _elementary("sin"),
    "sqrt": _of_multivector("sqrt"),
    "step": _of_scalars(elementary.step),
    "tan": _elementary("tan"),
    "uncomplement": Function(1, lambda x: x.uncomplement()),
    "versor": _of_multivector("versor"),
}
