"""What the operators of scripts do, and a call of a function."""

from __future__ import annotations

from collections.abc import Callable

from motorcade.ga.algebra import Algebra, Multivector
from motorcade.ga.script.branches import COMPARISONS, compared, truth
from motorcade.ga.script.functions import Function, scalar_of
from motorcade.ga.script.reading.syntax import Binary, Call, Expression, Slice, Unary

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
    if isinstance(node, Call):
        return len(node.arguments)
    return 2 if isinstance(node, Binary) else int(isinstance(node, Unary | Slice))


def operated(algebra: Algebra, node: Expression, operands: list[Multivector]) -> Multivector:
    """The value of an operator between one operand or two.

    Raises:
        ValueError: operands that it has no value for.
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

    Raises:
        ValueError: another number of arguments, or what the function refuses.
    """
    if len(operands) != function.arity:
        wanted = "one argument" if function.arity == 1 else f"{function.arity} arguments"
        raise ValueError(f"expected {wanted}, got {len(operands)}")
    return function.apply(*operands)
