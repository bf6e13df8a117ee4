"""Tapes as readable statements: what the C and the NumPy emitter have in common.

A node that is used once is written into the expression that uses it, while the line stays short;
the others get a name. Terms are never regrouped, so every language computes the same roundings,
but for products that a compiler fuses with sums.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count

from motorcade.ga.codegen.tape import BOOLEANS, Node, Tape
from motorcade.ga.codegen.targets.shared.branches import Branch, Plan, branched

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
class BranchStatement:
    """``if (condition) … else …``; either side ends by giving each of the names its value."""

    condition: str
    names: tuple[str, ...]
    chosen: Body
    otherwise: Body


Body = tuple[Statement | BranchStatement, ...]


@dataclass(frozen=True)
class Statements:
    """The body of a kernel, and the expression of each component of each output."""

    body: tuple[Statement, ...]
    results: tuple[tuple[str, ...], ...]


def component_name(operand: str, component: int, width: int) -> str:
    """The variable that holds a component of an input: its name, numbered where there are more."""
    return operand if width == 1 else f"{operand}{component}"


def statements(tape: Tape, dialect: Dialect, reserved: frozenset[str] = frozenset()) -> Statements:
    """Write a tape's operations in a language, one after the other.

    Intermediate values are named t0, t1, …, but for names of operands and for those `reserved`.
    """
    writer = _Writer(tape, dialect, reserved)
    body = tuple(made for index in range(len(tape.nodes)) if (made := writer.node(index)))
    return Statements(body, writer.results())


def branching_statements(
    tape: Tape, dialect: Dialect, reserved: frozenset[str] = frozenset()
) -> tuple[Body, tuple[tuple[str, ...], ...]]:
    """The same with branches where only one side of a choice needs operations; and the results."""
    writer = _Writer(tape, dialect, reserved)
    return writer.body(branched(tape)), writer.results()


class _Writer:
    """Gives every node of a tape its expression, and a name where that is worth one."""

    def __init__(self, tape: Tape, dialect: Dialect, reserved: frozenset[str]) -> None:
        self._tape = tape
        self._dialect = dialect
        self._widths = {operand.name: operand.width for operand in tape.inputs}
        self._names = _free_names(tape, reserved)
        self._uses = tape.uses()
        self._written: dict[int, tuple[str, int]] = {}

    def node(self, index: int) -> Statement | None:
        """The statement of a node; None where users have its expression in theirs."""
        node = self._tape.nodes[index]
        text, level = _expression(node, self._written, self._widths, self._dialect)
        inlined = self._uses[index] <= 1 and len(text) <= _LONGEST_EXPRESSION
        if node.op in ("input", "const") or inlined:
            self._written[index] = text, level
            return None
        return self._named(index, text)

    def body(self, plan: Plan) -> Body:
        """What a plan says, in order."""
        made: list[Statement | BranchStatement] = []
        for item in plan:
            one = self._choice(item) if isinstance(item, Branch) else self.node(item)
            if one is not None:
                made.append(one)
        return tuple(made)

    def results(self) -> tuple[tuple[str, ...], ...]:
        """The expression of each component of each output, once all is written."""
        return tuple(tuple(self._written[index][0] for index in row) for row in self._tape.results)

    def _choice(self, branch: Branch) -> BranchStatement:
        condition, _ = self._written[branch.condition]
        sides = []
        for place, plan in ((1, branch.chosen), (2, branch.otherwise)):
            made = self.body(plan)
            values = [
                self._written[self._tape.nodes[choice].args[place]][0] for choice in branch.choices
            ]
            sides.append((made, values))
        names = tuple(self._named(choice, "").name for choice in branch.choices)
        ends = [
            (
                *made,
                *(Statement(name, value, False) for name, value in zip(names, values, strict=True)),
            )
            for made, values in sides
        ]
        return BranchStatement(condition, names, ends[0], ends[1])

    def _named(self, index: int, text: str) -> Statement:
        made = Statement(next(self._names), text, self._tape.nodes[index].op in BOOLEANS)
        self._written[index] = made.name, _ATOM
        return made


def _free_names(tape: Tape, reserved: frozenset[str]) -> Iterator[str]:
    taken = reserved | {operand.name for operand in (*tape.inputs, *tape.outputs)}
    for operand in tape.inputs:
        taken |= {component_name(operand.name, i, operand.width) for i in range(operand.width)}
    return (name for k in count() if (name := f"t{k}") not in taken)


def _expression(
    node: Node, written: Mapping[int, tuple[str, int]], widths: dict[str, int], dialect: Dialect
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
