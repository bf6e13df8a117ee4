"""Tapes as readable statements: what the C and the NumPy emitter have in common.

A node that is used once is written into the expression that uses it, while the line stays short;
the others get a name. Terms are never regrouped, so every language computes the same roundings,
but for products that a compiler fuses with sums.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

from motorcade.ga.codegen.tape import BOOLEANS, Node, Tape

__all__ = ["Dialect", "Statement", "Statements", "component_name", "statements"]

_LONGEST_EXPRESSION = 84
_SUM, _PRODUCT, _SIGN, _ATOM = 1, 2, 3, 4
_INFIX = {"add": ("+", _SUM), "sub": ("-", _SUM), "mul": ("*", _PRODUCT), "div": ("/", _PRODUCT)}


class Dialect(ABC):
    """How one language writes constants and everything that is no sum, product or sign."""

    @abstractmethod
    def constant(self, value: float) -> str:
        """A number in the type that is written for."""

    @abstractmethod
    def call(self, op: str, args: list[str]) -> str:
        """Any other operation, as a call or in brackets; `args` are expressions."""


@dataclass(frozen=True)
class Statement:
    """``name = expression``; `boolean` where the value is true or false."""

    name: str
    expression: str
    boolean: bool


@dataclass(frozen=True)
class Statements:
    """The body of a kernel, and the expression of each component of each output."""

    body: tuple[Statement, ...]
    results: tuple[tuple[str, ...], ...]


def component_name(operand: str, component: int, width: int) -> str:
    """The variable that holds a component of an input: its name, numbered where there are more."""
    return operand if width == 1 else f"{operand}{component}"


def statements(tape: Tape, dialect: Dialect, reserved: frozenset[str] = frozenset()) -> Statements:
    """Write a tape's operations in a language.

    Intermediate values are named t0, t1, …, but for names of operands and for those `reserved`.
    """
    widths = {operand.name: operand.width for operand in tape.inputs}
    names = _free_names(tape, reserved)
    uses = tape.uses()
    written: list[tuple[str, int]] = []
    body: list[Statement] = []
    for index, node in enumerate(tape.nodes):
        text, level = _expression(node, written, widths, dialect)
        inlined = uses[index] <= 1 and len(text) <= _LONGEST_EXPRESSION
        if node.op not in ("input", "const") and not inlined:
            body.append(Statement(next(names), text, node.op in BOOLEANS))
            text, level = body[-1].name, _ATOM
        written.append((text, level))
    return Statements(
        tuple(body), tuple(tuple(written[index][0] for index in row) for row in tape.results)
    )


def _free_names(tape: Tape, reserved: frozenset[str]) -> Iterator[str]:
    taken = reserved | {operand.name for operand in (*tape.inputs, *tape.outputs)}
    for operand in tape.inputs:
        taken |= {component_name(operand.name, i, operand.width) for i in range(operand.width)}
    return (name for k in count() if (name := f"t{k}") not in taken)


def _expression(
    node: Node, written: list[tuple[str, int]], widths: dict[str, int], dialect: Dialect
) -> tuple[str, int]:
    if node.op == "input":
        return component_name(*node.source, widths[node.source[0]]), _ATOM
    if node.op == "const":
        return dialect.constant(node.value), _SIGN if node.value < 0 else _ATOM
    if node.op == "neg":
        return f"-{_bracketed(written[node.args[0]], _ATOM)}", _SIGN
    if node.op in _INFIX:
        sign, level = _INFIX[node.op]
        left, right = (written[index] for index in node.args)
        return f"{_bracketed(left, level)} {sign} {_bracketed(right, level + 1)}", level
    return dialect.call(node.op, [written[index][0] for index in node.args]), _ATOM


def _bracketed(expression: tuple[str, int], least: int) -> str:
    text, level = expression
    return text if level >= least else f"({text})"
