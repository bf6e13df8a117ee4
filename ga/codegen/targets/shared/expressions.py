"""Tapes as readable statements: what the C and the NumPy emitter have in common.

A node that is used once is written into the expression that uses it, while the line stays short;
the others get a name. Terms are never regrouped, so every language computes the same roundings,
but for products that a compiler fuses with sums, and rows of C and C++ (`with_unlike_rows`).

What only one side of a choice needs is computed on that side, as a branch, in code for one row.
Code for many rows computes both sides, as SIMD code must.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count

from motorcade.ga.codegen.tape import BOOLEANS, Node, Tape

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
    body = tuple(statement for index in range(len(tape.nodes)) if (statement := writer.node(index)))
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
        statements: list[Statement | BranchStatement] = []
        for item in plan:
            statement = self._choice(item) if isinstance(item, Branch) else self.node(item)
            if statement is not None:
                statements.append(statement)
        return tuple(statements)

    def results(self) -> tuple[tuple[str, ...], ...]:
        """The expression of each component of each output, once all is written."""
        return tuple(tuple(self._written[index][0] for index in row) for row in self._tape.results)

    def _choice(self, branch: Branch) -> BranchStatement:
        condition, _ = self._written[branch.condition]
        sides = []
        for place, plan in ((1, branch.chosen), (2, branch.otherwise)):
            branch_body = self.body(plan)
            values = [
                self._written[self._tape.nodes[choice].args[place]][0] for choice in branch.choices
            ]
            sides.append((branch_body, values))
        names = tuple(self._named(choice, "").name for choice in branch.choices)
        ends = [
            (
                *branch,
                *(Statement(name, value, False) for name, value in zip(names, values, strict=True)),
            )
            for branch, values in sides
        ]
        return BranchStatement(condition, names, ends[0], ends[1])

    def _named(self, index: int, text: str) -> Statement:
        named = Statement(next(self._names), text, self._tape.nodes[index].op in BOOLEANS)
        self._written[index] = named.name, _ATOM
        return named


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


# Sides with fewer operations than this are computed and chosen from, without a jump.
_WORTH_A_JUMP = 4

# A group of choices: their condition, and how many groups by it one after the other they end.
_Group = tuple[int, int]
_Path = tuple[tuple[_Group, bool], ...]


@dataclass(frozen=True)
class Branch:
    """``if (condition) … else …``; each choice gets its value at the end of either side."""

    condition: int
    choices: tuple[int, ...]
    chosen: Plan
    otherwise: Plan


Plan = tuple[int | Branch, ...]
"""Nodes in the order in which they are computed, some of them inside branches."""


def branched(tape: Tape) -> Plan:
    """The nodes with branches wherever a side of choices by one condition is worth a jump."""
    groups = _groups(tape)
    paths = _paths(tape, groups)
    members: dict[tuple[_Group, _Path], list[int]] = {}
    for index, group in groups.items():
        members.setdefault((group, paths[index]), []).append(index)
    sizes = _sizes(tape, paths)
    jumps = {
        (group, path): tuple(choices)
        for (group, path), choices in members.items()
        if max(sizes.get((*path, (group, side)), 0) for side in (True, False)) >= _WORTH_A_JUMP
    }
    return _Planner(tape, groups, [_kept(path, jumps) for path in paths], jumps).plan(
        (), _all(tape)
    )


def _groups(tape: Tape) -> dict[int, _Group]:
    """The group of each choice: no choice of a group depends on another of it."""
    groups: dict[int, _Group] = {}
    depths: list[dict[int, int]] = []
    for index, node in enumerate(tape.nodes):
        below: dict[int, int] = {}
        for argument in node.args:
            for condition, depth in depths[argument].items():
                below[condition] = max(depth, below.get(condition, 0))
        if node.op == "select":
            groups[index] = node.args[0], below.get(node.args[0], 0)
            below[node.args[0]] = groups[index][1] + 1
        depths.append(below)
    return groups


def _all(tape: Tape) -> list[int]:
    return [index for row in tape.results for index in row]


def _paths(tape: Tape, groups: dict[int, _Group]) -> list[_Path]:
    """For each node the sides of choices on which alone it is needed, outermost first."""
    paths: list[_Path | None] = [None] * len(tape.nodes)

    def need(index: int, path: _Path) -> None:
        known = paths[index]
        paths[index] = path if known is None else _common(known, path)

    for index in _all(tape):
        need(index, ())
    for index in reversed(range(len(tape.nodes))):
        node, path = tape.nodes[index], paths[index] or ()
        for place, argument in enumerate(node.args):
            inner = index in groups and place > 0
            need(argument, (*path, (groups[index], place == 1)) if inner else path)
    return [path or () for path in paths]


def _common(value: _Path, other: _Path) -> _Path:
    length = 0
    while length < min(len(value), len(other)) and value[length] == other[length]:
        length += 1
    return value[:length]


def _kept(path: _Path, jumps: dict[tuple[_Group, _Path], tuple[int, ...]]) -> _Path:
    """The part of a path on which all choices are branches."""
    for length, (group, _) in enumerate(path):
        if (group, path[:length]) not in jumps:
            return path[:length]
    return path


def _sizes(tape: Tape, paths: list[_Path]) -> dict[_Path, int]:
    """How many operations each side has for itself, those of its own branches included."""
    sizes: dict[_Path, int] = {}
    for node, path in zip(tape.nodes, paths, strict=True):
        if _computed(node):
            for length in range(1, len(path) + 1):
                sizes[path[:length]] = sizes.get(path[:length], 0) + 1
    return sizes


def _computed(node: Node) -> bool:
    return node.op not in ("input", "const")


class _Planner:
    """Puts nodes in order from the results backwards, so that a branch finds what it needs."""

    def __init__(
        self,
        tape: Tape,
        groups: dict[int, _Group],
        paths: list[_Path],
        jumps: dict[tuple[_Group, _Path], tuple[int, ...]],
    ) -> None:
        self._nodes = tape.nodes
        self._groups = groups
        self._paths = paths
        self._jumps = jumps
        self._placed: set[int] = set()

    def plan(self, path: _Path, wanted: list[int]) -> Plan:
        """The nodes on a side of a choice that the wanted ones need."""
        planned: list[int | Branch] = []
        for index in wanted:
            self._place(index, path, planned)
        return tuple(planned)

    def _place(self, index: int, path: _Path, planned: list[int | Branch]) -> None:
        if index in self._placed or self._paths[index] != path:
            return
        node = self._nodes[index]
        group = self._groups.get(index)
        choices = self._jumps.get((group, path)) if group else None
        if group is None or choices is None:
            for argument in node.args:
                self._place(argument, path, planned)
            self._placed.add(index)
            planned.append(index)
            return
        for needed in self._outside(choices, path):
            self._place(needed, path, planned)
        self._placed.update(choices)
        sides = [
            self.plan((*path, (group, side)), [self._nodes[k].args[place] for k in choices])
            for side, place in ((True, 1), (False, 2))
        ]
        planned.append(Branch(node.args[0], choices, *sides))

    def _outside(self, choices: tuple[int, ...], path: _Path) -> list[int]:
        """What branches need of the side that they stand on, their condition included."""
        outside: set[int] = set()
        seen: set[int] = set()
        waiting = [argument for k in choices for argument in self._nodes[k].args]
        while waiting:
            index = waiting.pop()
            if index in seen:
                continue
            seen.add(index)
            if self._paths[index] == path:
                outside.add(index)
            elif len(self._paths[index]) > len(path):
                waiting.extend(self._nodes[index].args)
        return sorted(outside)
