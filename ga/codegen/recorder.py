"""Symbols that write themselves down: scalars whose operations become nodes of a tape at once.

They are scalars as the algebra takes them, beside numbers, CasADi's symbols and tensors; nothing
but this package is needed to record a script. What depends on the value of one cannot be asked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder, folded

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

    def is_zero(self) -> bool:
        """Whether it is the number 0, whatever the variables are."""
        node = self.builder.nodes[self.node]
        return node.op == "const" and node.value == 0.0

    @staticmethod
    def scalar_functions() -> Any:
        """The functions of symbols, by NumPy's names."""
        return _FUNCTIONS


def recorded_symbols(variables: Sequence[str]) -> dict[str, Symbol]:
    """A symbol for each variable, all of one tape.

    >>> from motorcade.ga.codegen.recorder import recorded_symbols, tape_of_symbols
    >>> from motorcade.ga.codegen.tape import Operand
    >>> x = recorded_symbols(["x"])["x"]
    >>> operands = (Operand("x", ("1",)),), (Operand("y", ("1",)),)
    >>> tape_of_symbols(*operands, [x], [[x * x + 1.0]]).operations()
    {'add': 1, 'mul': 1}
    """
    builder = TapeBuilder()
    return {name: Symbol(builder, builder.input(name, 0)) for name in variables}


def tape_of_symbols(
    inputs: tuple[Operand, ...],
    outputs: tuple[Operand, ...],
    symbols: Sequence[Symbol],
    rows: Sequence[Sequence[Any]],
) -> Tape:
    """The tape of what was made of symbols, and of numbers: one row for each of `outputs`."""
    builder = symbols[0].builder if symbols else TapeBuilder()
    return builder.finished(inputs, outputs, [[_node(builder, v) for v in row] for row in rows])


def _operation(op: str, *operands: Any) -> Any:
    builder = next(x.builder for x in operands if isinstance(x, Symbol))
    if not all(isinstance(x, Symbol) or _is_number(x) for x in operands):
        return NotImplemented
    args = [_node(builder, x) for x in operands]
    if op != "select" and all(builder.nodes[k].op == "const" for k in args):
        value = folded(op, [builder.nodes[k].value for k in args])
        return Symbol(builder, builder.constant(np.nan if value is None else value))
    return Symbol(builder, builder.operation(op, *args))


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
