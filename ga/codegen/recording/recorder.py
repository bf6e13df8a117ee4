"""Symbols that write themselves down: scalars whose operations become nodes of a tape at once.

They are scalars as the algebra takes them, beside numbers, CasADi's symbols and tensors; nothing
but this package is needed to record a script. What depends on the value of one cannot be asked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder, folded

# What comparisons of a symbol with itself come to; CasADi sees that too.
_OF_EQUALS = {"lt": 0.0, "ne": 0.0, "le": 1.0, "eq": 1.0}
_BRANCH = "the truth value of a symbol is not known while it is recorded"


class Symbol:
    """A node of the tape that is being recorded."""

    __slots__ = ("builder", "node")

    # NumPy's scalars leave their operations with symbols to these.
    __array_ufunc__ = None

    def __init__(self, builder: TapeBuilder, node: int) -> None:
        self.builder = builder
        self.node = node

    def __add__(self, other: Any) -> Any:
        return _operation("add", self, other)

    def __radd__(self, other: Any) -> Any:
        return _operation("add", other, self)

    def __sub__(self, other: Any) -> Any:
        return _operation("sub", self, other)

    def __rsub__(self, other: Any) -> Any:
        return _operation("sub", other, self)

    def __mul__(self, other: Any) -> Any:
        return _operation("mul", self, other)

    def __rmul__(self, other: Any) -> Any:
        return _operation("mul", other, self)

    def __truediv__(self, other: Any) -> Any:
        return _operation("div", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _operation("div", other, self)

    def __neg__(self) -> Any:
        return _operation("neg", self)

    def __abs__(self) -> Any:
        return _operation("abs", self)

    def __lt__(self, other: Any) -> Any:
        return _operation("lt", self, other)

    def __le__(self, other: Any) -> Any:
        return _operation("le", self, other)

    def __gt__(self, other: Any) -> Any:
        return _operation("lt", other, self)

    def __ge__(self, other: Any) -> Any:
        return _operation("le", other, self)

    def __eq__(self, other: object) -> Any:
        return _operation("eq", self, other)

    def __ne__(self, other: object) -> Any:
        return _operation("ne", self, other)

    __hash__ = None  # type: ignore[assignment]

    def __bool__(self) -> bool:
        raise TypeError(_BRANCH)

    def fabs(self) -> Any:
        """The absolute value."""
        return _operation("abs", self)

    def sqrt(self) -> Any:
        """The square root."""
        return _operation("sqrt", self)

    def is_constant(self) -> bool:
        """Whether it is a number, whatever the variables are."""
        return self.builder.nodes[self.node].op == "const"

    def is_zero(self) -> bool:
        """Whether it is the number 0, whatever the variables are."""
        return self.is_constant() and self.builder.nodes[self.node].value == 0.0

    def __float__(self) -> float:
        if not self.is_constant():
            raise TypeError("the value of a symbol is not known while it is recorded")
        return self.builder.nodes[self.node].value

    def __repr__(self) -> str:
        node = self.builder.nodes[self.node]
        if node.op == "const":
            return repr(node.value)
        name, component = node.source
        return f"{name}{component or ''}" if node.op == "input" else f"{node.op} at {self.node}"

    @staticmethod
    def scalar_functions() -> Any:
        """The functions of symbols, by NumPy's names."""
        return _FUNCTIONS


def recorded_symbols(inputs: Sequence[Operand]) -> list[list[Symbol]]:
    """The symbols of each input, one a component, all of one tape.

    >>> from motorcade.ga.codegen.recording.recorder import recorded_symbols, tape_of_symbols
    >>> from motorcade.ga.codegen.tape import Operand
    >>> inputs, outputs = (Operand("x", ("1",)),), (Operand("y", ("1",)),)
    >>> ((x,),) = recorded_symbols(inputs)
    >>> tape_of_symbols(inputs, outputs, [[x * x + 1.0]]).operations()
    {'add': 1, 'mul': 1}
    """
    builder = TapeBuilder()
    return [
        [Symbol(builder, builder.input(operand.name, k)) for k in range(operand.width)]
        for operand in inputs
    ]


def tape_of_symbols(
    inputs: tuple[Operand, ...], outputs: tuple[Operand, ...], rows: Sequence[Sequence[Any]]
) -> Tape:
    """The tape of what was made of symbols, and of numbers: one row for each of `outputs`."""
    made = (value.builder for row in rows for value in row if isinstance(value, Symbol))
    builder = next(made, None) or TapeBuilder()
    return builder.finished(inputs, outputs, [[_node(builder, v) for v in row] for row in rows])


class Scalars:
    """Symbols of one tape, and what is asked of the scalars that are made of them."""

    def __init__(self) -> None:
        self._builder = TapeBuilder()
        self._replaced: dict[int, int] = {}

    def symbol(self, name: str) -> Symbol:
        """The symbol of this name."""
        return Symbol(self._builder, self._builder.input(name, 0))

    def replace(self, name: str, value: Any) -> None:
        """Let a symbol stand for a value from here on, wherever it is `resolved`."""
        self._replaced[self.symbol(name).node] = _node(self._builder, value)

    def resolved(self, value: Any) -> Any:
        """A scalar in terms of the symbols that stand for nothing else."""
        if not isinstance(value, Symbol):
            return value
        nodes, done = self._builder.nodes, self._replaced
        for index in self._below([value], done):
            node = nodes[index]
            args = [done[k] for k in node.args]
            done[index] = _decided_operation(self._builder, node.op, args) if args else index
        return Symbol(self._builder, done[value.node])

    def names_in(self, values: Iterable[Any]) -> list[str]:
        """The names of the symbols that scalars are made of, in the order they were made."""
        nodes = self._builder.nodes
        below = sorted(self._below([v for v in values if isinstance(v, Symbol)], {}))
        return [nodes[k].source[0] for k in below if nodes[k].op == "input"]

    def tape(self, values: Sequence[Any], output: Operand, called: Mapping[str, str]) -> Tape:
        """The tape of scalars as the components of an output; inputs are `called` otherwise."""
        builder = TapeBuilder()
        place: dict[int, int] = {}
        for index in sorted(self._below([v for v in values if isinstance(v, Symbol)], {})):
            node = self._builder.nodes[index]
            if node.op == "input":
                place[index] = builder.input(called[node.source[0]], 0)
            elif node.op == "const":
                place[index] = builder.constant(node.value)
            else:
                place[index] = builder.operation(node.op, *(place[k] for k in node.args))
        row = [place[v.node] if isinstance(v, Symbol) else _node(builder, v) for v in values]
        inputs = tuple(Operand(name, ("1",)) for name in called.values())
        return builder.finished(inputs, (output,), [row])

    def _below(self, values: Iterable[Symbol], done: Mapping[int, int]) -> Iterator[int]:
        """The nodes that values depend on, arguments first, without those that are done."""
        nodes, seen = self._builder.nodes, set[int]()
        waiting = [value.node for value in values]
        while waiting:
            index = waiting[-1]
            below = [k for k in nodes[index].args if k not in seen and k not in done]
            if below and index not in seen:
                waiting += below
                continue
            waiting.pop()
            if index not in seen and index not in done:
                seen.add(index)
                yield index


def _operation(op: str, *operands: Any) -> Any:
    builder = next(x.builder for x in operands if isinstance(x, Symbol))
    if not all(isinstance(x, Symbol) or _is_number(x) for x in operands):
        return NotImplemented
    args = [_node(builder, x) for x in operands]
    if op != "select" and all(builder.nodes[k].op == "const" for k in args):
        value = folded(op, [builder.nodes[k].value for k in args])
        return Symbol(builder, builder.constant(np.nan if value is None else value))
    return Symbol(builder, _decided_operation(builder, op, args))


def _decided_operation(builder: TapeBuilder, op: str, args: Sequence[int]) -> int:
    if op in _OF_EQUALS and args[0] == args[1]:
        return builder.constant(_OF_EQUALS[op])
    return builder.operation(op, *args)


def _is_number(x: Any) -> bool:
    return isinstance(x, float | int | np.number) or (isinstance(x, np.ndarray) and x.ndim == 0)


def _node(builder: TapeBuilder, x: Any) -> int:
    return x.node if isinstance(x, Symbol) else builder.constant(float(x))


def _function(op: str) -> Callable[..., Any]:
    return lambda *operands: _operation(op, *operands)


_FUNCTIONS = SimpleNamespace(
    if_else=_function("select"), arctan2=_function("atan2"), arcsin=_function("asin"),
    arccos=_function("acos"), arctan=_function("atan"), fmax=_function("max"),
    fmin=_function("min"), fabs=_function("abs"),
    **{op: _function(op) for op in ("sqrt", "exp", "log", "sin", "cos", "tan", "floor", "ceil")},
)  # fmt: skip
