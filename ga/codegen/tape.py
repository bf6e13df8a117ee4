"""A tape: the straight line of scalar operations that a kernel's definition comes down to.

Nodes name their arguments by position and come in an order in which they can be computed. Equal
nodes are one, terms and factors stand in a fixed order, signs are moved out of products, so that
a negated term becomes a subtraction, and operations on numbers are worked out. Constants are Python
floats; the emitters print them in the type that they write for; `run_tape` runs one as it is.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

_FUNCTIONS: dict[str, Callable[..., float]] = {
    "add": lambda x, y: x + y, "sub": lambda x, y: x - y, "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y, "neg": lambda x: -x, "abs": abs, "min": min, "max": max,
    "floor": math.floor, "ceil": math.ceil, "sqrt": math.sqrt, "exp": math.exp, "log": math.log,
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "asin": math.asin, "acos": math.acos,
    "atan": math.atan, "atan2": math.atan2,
}  # fmt: skip
_COMPARISONS: dict[str, Callable[..., bool]] = {
    "lt": lambda x, y: x < y, "le": lambda x, y: x <= y,
    "eq": lambda x, y: x == y, "ne": lambda x, y: x != y, "not": lambda x: x == 0.0,
    "and": lambda x, y: x != 0.0 and y != 0.0, "or": lambda x, y: x != 0.0 or y != 0.0,
}  # fmt: skip
_COMMUTATIVE = frozenset({"add", "mul", "min", "max", "and", "or", "eq", "ne"})
# Operations whose result is true or false.
BOOLEANS = frozenset({"lt", "le", "eq", "ne", "and", "or", "not"})


def folded(op: str, values: Sequence[float]) -> float | None:
    """The value, None for other operations and where it is not finite: that is left to run.

    True and false are 1 and 0.
    """
    if op in _COMPARISONS:
        return float(_COMPARISONS[op](*values))
    try:
        value = float(_FUNCTIONS[op](*values)) if op in _FUNCTIONS else math.nan
    except (ArithmeticError, ValueError):
        return None
    return value if math.isfinite(value) else None


@dataclass(frozen=True)
class Operand:
    """A named array argument: one number a row and component, components named by their blades."""

    name: str
    components: tuple[str, ...]

    @property
    def width(self) -> int:
        """How many components it has."""
        return len(self.components)


class Node(NamedTuple):
    """One operation; ``input`` nodes carry operand and component, ``const`` nodes a value."""

    op: str
    args: tuple[int, ...] = ()
    value: float = 0.0
    source: tuple[str, int] = ("", 0)


@dataclass(frozen=True)
class Tape:
    """The operations of one kernel; `results` gives the node of each component of each output."""

    inputs: tuple[Operand, ...]
    outputs: tuple[Operand, ...]
    nodes: tuple[Node, ...]
    results: tuple[tuple[int, ...], ...]

    def components_read(self, operand: str) -> list[int]:
        """Which components of an input the operations use."""
        sources = (node.source for node in self.nodes if node.op == "input")
        return sorted(component for name, component in sources if name == operand)

    def uses(self) -> list[int]:
        """How often each node is an argument or a result."""
        counts = [0] * len(self.nodes)
        for node in self.nodes:
            for argument in node.args:
                counts[argument] += 1
        for row in self.results:
            for index in row:
                counts[index] += 1
        return counts

    def operations(self) -> dict[str, int]:
        """How many nodes there are of each operation, inputs and constants left out."""
        counts: dict[str, int] = {}
        for node in self.nodes:
            if node.op not in ("input", "const"):
                counts[node.op] = counts.get(node.op, 0) + 1
        return dict(sorted(counts.items()))


class TapeBuilder:
    """Adds nodes to a tape, each in its simplest form and only once."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._known: dict[Node, int] = {}

    def constant(self, value: float) -> int:
        """The node of a number."""
        return self._node(Node("const", value=value))

    def input(self, operand: str, component: int) -> int:
        """The node of one component of an input."""
        return self._node(Node("input", source=(operand, component)))

    def operation(self, op: str, *args: int) -> int:
        """The node of an operation on earlier nodes, simplified."""
        simplified = self._simplified(op, args)
        if simplified is not None:
            return simplified
        ordered = tuple(sorted(args)) if op in _COMMUTATIVE else args
        return self._node(Node(op, ordered))

    def negative(self, index: int) -> int:
        """The node of ``-x`` that stays one, whatever is simpler where it stands alone."""
        return self._node(Node("neg", (index,)))

    def finished(
        self,
        inputs: tuple[Operand, ...],
        outputs: tuple[Operand, ...],
        results: Sequence[Sequence[int]],
    ) -> Tape:
        """The tape of what the results need; everything else is left out."""
        results = self._quotients_once(results)
        kept = self._needed(results)
        if len(kept) == len(self.nodes):
            return Tape(inputs, outputs, tuple(self.nodes), tuple(tuple(row) for row in results))
        place = {old: new for new, old in enumerate(kept)}
        nodes = tuple(self._moved(self.nodes[old], place) for old in kept)
        return Tape(inputs, outputs, nodes, tuple(tuple(place[i] for i in row) for row in results))

    def _quotients_once(self, results: Sequence[Sequence[int]]) -> list[list[int]]:
        """Several quotients by one number become products with its reciprocal."""
        divisors = Counter(node.args[1] for node in self.nodes if node.op == "div")
        if divisors and max(divisors.values()) > 1:
            needed = (self.nodes[index] for index in self._needed(results))
            divisors = Counter(node.args[1] for node in needed if node.op == "div")
        shared = {index for index, count in divisors.items() if count > 1}
        if not shared:
            return [list(row) for row in results]
        known = tuple(self.nodes)
        self.nodes, self._known = [], {}
        place: dict[int, int] = {}
        for old, node in enumerate(known):
            moved = self._moved(node, place)
            if node.op == "div" and node.args[1] in shared:
                reciprocal = self.operation("div", self.constant(1.0), moved.args[1])
                place[old] = self.operation("mul", moved.args[0], reciprocal)
            elif node.args:
                place[old] = self.operation(node.op, *moved.args)
            else:
                place[old] = self._node(moved)
        return [[place[index] for index in row] for row in results]

    def _needed(self, results: Sequence[Sequence[int]]) -> list[int]:
        """The nodes that results depend on, ascending."""
        needed = [False] * len(self.nodes)
        for row in results:
            for index in row:
                needed[index] = True
        for index in reversed(range(len(needed))):  # arguments come before what needs them
            if needed[index]:
                for k in self.nodes[index].args:
                    needed[k] = True
        return [index for index, wanted in enumerate(needed) if wanted]

    @staticmethod
    def _moved(node: Node, place: dict[int, int]) -> Node:
        if not node.args:
            return node
        return Node(node.op, tuple([place[i] for i in node.args]), node.value, node.source)

    def _node(self, node: Node) -> int:
        index = self._known.get(node)
        if index is None:
            index = self._known[node] = len(self.nodes)
            self.nodes.append(node)
        return index

    def _simplified(self, op: str, args: tuple[int, ...]) -> int | None:
        nodes = self.nodes
        if nodes[args[0]].op == "const" and all(nodes[index].op == "const" for index in args):
            value = folded(op, [self.nodes[index].value for index in args])
            if value is not None:
                return self.constant(value)
        if op in ("mul", "div"):
            return self._scaled(op, *args)
        if op == "add":
            return self._sum(*args)
        if op == "sub":
            return self._difference(*args)
        if op == "neg":
            return self._negated(args[0])
        if op in ("select", "keep"):
            return self._decided(*args)
        if op == "abs" and self.nodes[args[0]].op in ("neg", "abs"):
            return self.operation("abs", self._inside(args[0]))
        if op in ("min", "max", "and", "or") and args[0] == args[1]:
            return args[0]
        return self._inside(args[0]) if op == self.nodes[args[0]].op == "not" else None

    def _inside(self, index: int) -> int:
        return self.nodes[index].args[0]

    def _is(self, index: int, value: float) -> bool:
        node = self.nodes[index]
        return node.op == "const" and node.value == value

    def _negated(self, index: int) -> int | None:
        node = self.nodes[index]
        if node.op == "neg":
            return node.args[0]
        if node.op == "const":
            return self.constant(-node.value)
        if node.op == "sub":
            return self.operation("sub", node.args[1], node.args[0])
        return None

    def _difference(self, first: int, second: int) -> int | None:
        if first == second:
            return self.constant(0.0)
        if self._is(second, 0.0):
            return first
        if self._is(first, 0.0):
            return self.operation("neg", second)
        if self.nodes[second].op == "neg":
            return self.operation("add", first, self._inside(second))
        return None

    def _decided(self, condition: int, chosen: int, otherwise: int | None = None) -> int | None:
        """A choice of which the condition is a number, or both branches are one."""
        node = self.nodes[condition]
        if node.op == "const":
            rest = self.constant(0.0) if otherwise is None else otherwise
            return chosen if node.value else rest
        if chosen == otherwise or (otherwise is None and self._is(chosen, 0.0)):
            return chosen
        return None

    def _sum(self, first: int, second: int) -> int | None:
        for kept, other in ((first, second), (second, first)):
            if self._is(other, 0.0):
                return kept
        chosen = self._chosen(first, second) or self._chosen(second, first)
        if chosen is not None:
            return chosen
        if self.nodes[second].op == "neg":
            return self.operation("sub", first, self._inside(second))
        if self.nodes[first].op == "neg":
            return self.operation("sub", second, self._inside(first))
        return None

    def _chosen(self, kept: int, otherwise: int) -> int | None:
        """CasADi writes a choice as the sum of two terms of which one is zero."""
        node, other = self.nodes[kept], self.nodes[otherwise]
        if node.op != "keep" or other.op != "keep":
            return None
        negation = self.nodes[other.args[0]]
        if negation.op != "not" or negation.args[0] != node.args[0]:
            return None
        return self.operation("select", node.args[0], node.args[1], other.args[1])

    def _scaled(self, op: str, first: int, second: int) -> int | None:
        left, right = self.nodes[first], self.nodes[second]
        if left.op == "const":
            if left.value == 0.0:
                return self.constant(0.0)
            if op == "mul" and left.value in (1.0, -1.0):
                return second if left.value > 0.0 else self.operation("neg", second)
        if right.op == "const":
            if op == "mul" and right.value == 0.0:
                return self.constant(0.0)
            if right.value in (1.0, -1.0):
                return first if right.value > 0.0 else self.operation("neg", first)
        if left.op == "neg":
            return self.operation("neg", self.operation(op, left.args[0], second))
        if right.op == "neg":
            return self.operation("neg", self.operation(op, first, right.args[0]))
        return None


NUMPY_OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "neg": np.negative,
    "sqrt": np.sqrt, "abs": np.abs, "floor": np.floor, "ceil": np.ceil, "min": np.minimum,
    "max": np.maximum, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2,
    "lt": np.less, "le": np.less_equal, "eq": np.equal, "ne": np.not_equal,
    "and": np.logical_and, "or": np.logical_or, "not": np.logical_not,
    "select": lambda condition, x, y: np.where(np.asarray(condition) != 0.0, x, y),
    "keep": lambda condition, x: np.where(np.asarray(condition) != 0.0, x, 0.0),
}  # fmt: skip


def run_tape(tape: Tape, inputs: Mapping[tuple[str, int], Any]) -> list[list[Any]]:
    """The components of each output.

    `inputs` gives a number or an array for each name and component of an input; arrays broadcast.
    Where a value is no real number the result is NaN or infinite.
    """
    values: list[Any] = []
    left = tape.uses()  # a value that nothing else needs is let go: its memory is the next one's
    with np.errstate(all="ignore"):
        for node in tape.nodes:
            if node.op == "const":
                values.append(np.float64(node.value))
            elif node.op == "input":
                values.append(np.asarray(inputs[node.source], dtype=np.float64))
            else:
                value = NUMPY_OPERATIONS[node.op](*[values[k] for k in node.args])
                values.append(np.asarray(value, dtype=np.float64))
                for k in node.args:
                    left[k] -= 1
                    if left[k] == 0:
                        values[k] = None
    return [[values[k] for k in row] for row in tape.results]
