"""The functions that every script may call, over any scalars.

``abs`` is ``√|⟨x ~x⟩₀|`` of any multivector, ``invert`` the inverse of any invertible one, and
``exp log sqrt normalize versor`` are those of `algebra.logarithm`; ``scalar`` is ``⟨x⟩₀``, and
``complement uncomplement`` are the duals that need no metric; ``reverse involute conjugate`` change
signs by grade, ``grade`` and ``coefficient`` take parts. The others take scalars: blades that are
zero, or that rounding left beside a scalar, do not stop it from being one.

What operators do stands below. Conditions are scalars that are zero or not; comparisons give 1 and
0. Where one is known, one branch is run; where it differs over a batch, or hangs on symbols, both
are, and coefficients are chosen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from motorcade.ga.algebra import Algebra, Multivector, scalars
from motorcade.ga.algebra.scalars import is_numeric, is_zero_somewhere, magnitude, where
from motorcade.ga.script.syntax import (
    Binary,
    Call,
    Expression,
    ListOf,
    Skipped,
    Slice,
    Unary,
)


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
    return _of_scalars(lambda *values: scalars.apply(numpy_name, *values), arity)


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
    "sign": _of_scalars(scalars.sign),
    "sin": _elementary("sin"),
    "sqrt": _of_multivector("sqrt"),
    "step": _of_scalars(scalars.step),
    "tan": _elementary("tan"),
    "uncomplement": Function(1, lambda x: x.uncomplement()),
    "versor": _of_multivector("versor"),
}


_OPERATIONS: dict[str, Callable[[Multivector, Multivector], Multivector]] = {
    "^": lambda left, right: left ^ right,
    ".": lambda left, right: left | right,
    "&": lambda left, right: left & right,
    "<<": lambda left, right: left.left_contraction(right),
    ">>": lambda left, right: left.right_contraction(right),
    "/": lambda left, right: left / right,
    "*": lambda left, right: left * right,
    "+": lambda left, right: left + right,
    "-": lambda left, right: left - right,
}


def operand_count(node: Expression) -> int:
    """How many values an expression is made of."""
    if isinstance(node, Call | Skipped | ListOf):
        return len(node.items if isinstance(node, ListOf) else node.arguments)
    return 2 if isinstance(node, Binary) else int(isinstance(node, Unary | Slice))


def operated(algebra: Algebra, node: Expression, operands: list[Multivector]) -> Multivector:
    """The value of an operator between one operand or two.

    Raises ValueError: operands that it has no value for.
    """
    if isinstance(node, Unary):
        return _prefixed(algebra, node.operator, operands[0])
    left, right = operands
    operator = node.operator if isinstance(node, Binary) else ""
    if operator in COMPARISONS:
        return algebra.scalar(compared(operator, left, right))
    return _OPERATIONS[operator](left, right)


def _prefixed(algebra: Algebra, operator: str, x: Multivector) -> Multivector:
    if operator == "!!":
        return algebra.scalar(1.0 - truth(scalar_of(x)))
    return ~x if operator == "~" else -x


def computed(function: Function, operands: list[Multivector]) -> Multivector:
    """The value of a call.

    Raises ValueError: another number of arguments, or what the function refuses.
    """
    if len(operands) != function.arity:
        wanted = "one argument" if function.arity == 1 else f"{function.arity} arguments"
        raise ValueError(f"expected {wanted}, got {len(operands)}")
    return function.apply(*operands)


COMPARISONS = frozenset(["==", "!=", "<", "<=", ">", ">=", "&&", "||"])


def compared(operator: str, left: Multivector, right: Multivector) -> Any:
    """1 where a comparison of two scalars holds, otherwise 0.

    Raises ValueError: operands that are no scalars.
    """
    a, b = scalar_of(left), scalar_of(right)
    if operator in ("&&", "||"):
        a, b = truth(a), truth(b)
        return a * b if operator == "&&" else where(a + b != 0, 1.0, 0.0)
    if operator in (">", ">="):
        return compared("<" if operator == ">" else "<=", right, left)
    if operator == "<":
        holds = a < b
    elif operator == "<=":
        holds = a <= b
    else:
        holds = a == b if operator == "==" else a != b
    return where(holds, 1.0, 0.0)


def truth(value: Any) -> Any:
    """1 where a scalar is not zero, otherwise 0."""
    return where(value != 0, 1.0, 0.0)


def decided(value: Any) -> bool | None:
    """Whether a condition holds; None where that is not the same for all, or not known."""
    if hasattr(value, "is_constant"):
        return float(value) != 0 if value.is_constant() else None
    if is_numeric(value):
        holds = np.asarray(value) != 0
        return bool(holds.all()) if holds.all() or not holds.any() else None
    holds = value != 0
    return bool(holds.all()) if bool(holds.all()) or not bool(holds.any()) else None


def rows_of(x: Multivector, conditions: Sequence[Any]) -> Multivector | None:
    """Those rows of a batch for which all conditions hold; None where there are none."""
    held = np.asarray(True)
    for condition in conditions:
        held = held & condition
    shape = np.broadcast_shapes(held.shape, *(np.shape(value) for value in x.values))
    held = np.broadcast_to(held, shape)
    if not held.any():
        return None
    return x._with(np.broadcast_to(value, shape)[held] for value in x.values)


def chosen(algebra: Algebra, condition: Any, then: Multivector, other: Multivector) -> Multivector:
    """The coefficients of `then` where a condition holds, elsewhere those of `other`."""
    first, two = dict(then.items()), dict(other.items())
    holds = condition != 0
    return algebra.multivector(
        {
            blade: where(holds, first.get(blade, 0.0), two.get(blade, 0.0))
            for blade in {**first, **two}
        }
    )
