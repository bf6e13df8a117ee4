"""What the operators of scripts do, and a call of a function.

Conditions of scripts, and values that depend on them.

A condition is a scalar that is zero or not; comparisons give 1 and 0. Where it is known, one branch
is run. Where it differs over a batch, or hangs on symbols, both are, and coefficients are chosen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from motorcade.ga.algebra import Algebra, Multivector
from motorcade.ga.algebra.functions.elementary import where
from motorcade.ga.algebra.scalars import is_numeric
from motorcade.ga.script.functions import Function, scalar_of
from motorcade.ga.script.reading.syntax import (
    Binary,
    Call,
    Expression,
    ListOf,
    Skipped,
    Slice,
    Unary,
)

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
