"""How a tape comes about: code that runs over scalars is written down operation by operation.

`trace` runs a definition on CasADi scalars and reads the instructions back. The symbols of
`recorder` write themselves down: they are scalars as the algebra takes them, and nothing but this
package is needed to record a script. What depends on the value of one cannot be asked.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from motorcade.ga.codegen.library_kernels.powers_of_two import power_of_two_node
from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder, folded

Definition = Callable[..., Sequence[Sequence[Any]]]

# CasADi's names of the operations that have one node here.
_SAME = {
    "OP_ADD": "add", "OP_SUB": "sub", "OP_MUL": "mul", "OP_DIV": "div", "OP_NEG": "neg",
    "OP_SQRT": "sqrt", "OP_FABS": "abs", "OP_FLOOR": "floor", "OP_FMIN": "min", "OP_FMAX": "max",
    "OP_LT": "lt", "OP_LE": "le", "OP_EQ": "eq", "OP_NE": "ne", "OP_AND": "and", "OP_OR": "or",
    "OP_NOT": "not", "OP_IF_ELSE_ZERO": "keep", "OP_EXP": "exp", "OP_LOG": "log", "OP_SIN": "sin",
    "OP_COS": "cos", "OP_TAN": "tan", "OP_ASIN": "asin", "OP_ACOS": "acos", "OP_ATAN": "atan",
    "OP_ATAN2": "atan2", "OP_CEIL": "ceil",
}  # fmt: skip
_HIGHEST_POWER = 64


def casadi_function(
    name: str, inputs: Sequence[Operand], outputs: Sequence[Operand], define: Definition
) -> Any:
    """The definition as a CasADi function of one vector an input, shared terms computed once.

    `define` is called with a list of scalars for each input and returns one for each output.

    Raises ValueError: an output has another number of components than was declared.
    """
    import casadi as ca

    symbols = [ca.SX.sym(operand.name, operand.width) for operand in inputs]
    rows = define(*([symbol[i] for i in range(symbol.numel())] for symbol in symbols))
    widths = [len(row) for row in rows]
    if widths != [operand.width for operand in outputs]:
        raise ValueError(
            f"{name}: expected outputs of {[operand.width for operand in outputs]} components, "
            f"got {widths}"
        )
    columns = ca.cse([ca.densify(ca.vertcat(*map(ca.SX, row))) for row in rows])
    return ca.Function(name, symbols, columns)


def trace(
    name: str,
    inputs: Sequence[Operand],
    outputs: Sequence[Operand],
    define: Definition,
    *,
    powers_of_two: bool = False,
) -> Tape:
    """The tape of a definition.

    With `powers_of_two`, ``2^n`` and ``floor(log x / log 2)`` become the operations on bits that
    only the library's own kernels know.

    Raises ValueError: an operation without a counterpart in the emitters, or outputs that do not
    have the declared widths.
    """
    function = casadi_function(name, inputs, outputs, define)
    return _read(name, function, inputs, outputs, powers_of_two=powers_of_two)


def tape_of(
    name: str,
    inputs: Sequence[Operand],
    outputs: Sequence[Operand],
    symbols: Sequence[Any],
    rows: Sequence[Sequence[Any]],
) -> Tape:
    """The tape of values that are there already.

    `symbols` are CasADi SX vectors, one of its width for each of `inputs`; `rows` hold SX scalars
    or numbers, one row for each of `outputs`. `name` is for messages.

    Raises ValueError: an operation without a counterpart in the emitters.
    """
    import casadi as ca

    columns = [ca.densify(ca.vertcat(ca.SX(0, 1), *map(ca.SX, row))) for row in rows]
    # CasADi has reserved names, so the function does not get that of the program.
    return _read(name, ca.Function("traced", list(symbols), columns), inputs, outputs)


def _read(
    name: str,
    function: Any,
    inputs: Sequence[Operand],
    outputs: Sequence[Operand],
    *,
    powers_of_two: bool = False,
) -> Tape:
    import casadi as ca

    builder = TapeBuilder()
    slots: dict[int, int] = {}
    results = [[0] * operand.width for operand in outputs]
    for k in range(function.n_instructions()):
        op, sources, target = (
            function.instruction_id(k),
            function.instruction_input(k),
            function.instruction_output(k),
        )
        if op == ca.OP_OUTPUT:
            results[target[0]][target[1]] = slots[sources[0]]
        elif op == ca.OP_INPUT:
            slots[target[0]] = builder.input(inputs[sources[0]].name, sources[1])
        elif op == ca.OP_CONST:
            slots[target[0]] = builder.constant(float(function.instruction_constant(k)))
        else:
            args = [slots[i] for i in sources]
            exact = (
                power_of_two_node(builder, _names().get(op, ""), args) if powers_of_two else None
            )
            slots[target[0]] = (
                _casadi_operation(builder, name, op, args) if exact is None else exact
            )
    return builder.finished(tuple(inputs), tuple(outputs), results)


def _casadi_operation(builder: TapeBuilder, name: str, code: int, args: list[int]) -> int:
    spelled = _names().get(code, f"operation {code}")
    if spelled == "OP_SQ":
        return builder.operation("mul", args[0], args[0])
    if spelled == "OP_TWICE":
        return builder.operation("mul", builder.constant(2.0), args[0])
    if spelled == "OP_INV":
        return builder.operation("div", builder.constant(1.0), args[0])
    if spelled in ("OP_POW", "OP_CONSTPOW"):
        return _power(builder, *args)
    if spelled not in _SAME:
        raise ValueError(f"{name}: expected operations that the emitters know, got {spelled}")
    return builder.operation(_SAME[spelled], *args)


def _power(builder: TapeBuilder, base: int, exponent: int) -> int:
    """A power by products and a square root where the exponent allows, otherwise by logarithms.

    The latter is NaN for negative bases, as it must be for exponents that are not whole.
    """
    node = builder.nodes[exponent]
    doubled = 2.0 * node.value if node.op == "const" else math.nan
    if not (abs(doubled) <= 2 * _HIGHEST_POWER and doubled.is_integer()):
        logarithm = builder.operation("log", base)
        return builder.operation("exp", builder.operation("mul", exponent, logarithm))
    whole, half = divmod(abs(int(doubled)), 2)
    power = builder.operation("sqrt", base) if half else builder.constant(1.0)
    while whole:
        if whole & 1:
            power = builder.operation("mul", power, base)
        base, whole = builder.operation("mul", base, base), whole >> 1
    return power if doubled >= 0 else builder.operation("div", builder.constant(1.0), power)


@cache
def _names() -> dict[int, str]:
    import casadi as ca

    return {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}


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

    >>> from motorcade.ga.codegen.recording import recorded_symbols, tape_of_symbols
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
    builders = (value.builder for row in rows for value in row if isinstance(value, Symbol))
    builder = next(builders, None) or TapeBuilder()
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
