"""Tracing: runs a definition on CasADi scalars and reads the instructions back as a tape."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from motorcade.ga.codegen.library_kernels.powers_of_two import power_of_two_node
from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder

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

    Raises:
        ValueError: an output has another number of components than was declared.
    """
    import casadi as ca

    symbols = [ca.SX.sym(operand.name, operand.width) for operand in inputs]
    made = define(*([symbol[i] for i in range(symbol.numel())] for symbol in symbols))
    widths = [len(row) for row in made]
    if widths != [operand.width for operand in outputs]:
        raise ValueError(
            f"{name}: expected outputs of {[operand.width for operand in outputs]} components, "
            f"got {widths}"
        )
    columns = ca.cse([ca.densify(ca.vertcat(*map(ca.SX, row))) for row in made])
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

    Raises:
        ValueError: an operation without a counterpart in the emitters, or outputs that do not
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

    Raises:
        ValueError: an operation without a counterpart in the emitters.
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
        op, given, target = (
            function.instruction_id(k),
            function.instruction_input(k),
            function.instruction_output(k),
        )
        if op == ca.OP_OUTPUT:
            results[target[0]][target[1]] = slots[given[0]]
        elif op == ca.OP_INPUT:
            slots[target[0]] = builder.input(inputs[given[0]].name, given[1])
        elif op == ca.OP_CONST:
            slots[target[0]] = builder.constant(float(function.instruction_constant(k)))
        else:
            args = [slots[i] for i in given]
            made = power_of_two_node(builder, _names().get(op, ""), args) if powers_of_two else None
            slots[target[0]] = _operation(builder, name, op, args) if made is None else made
    return builder.finished(tuple(inputs), tuple(outputs), results)


def _operation(builder: TapeBuilder, name: str, code: int, args: list[int]) -> int:
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
    made = builder.operation("sqrt", base) if half else builder.constant(1.0)
    while whole:
        if whole & 1:
            made = builder.operation("mul", made, base)
        base, whole = builder.operation("mul", base, base), whole >> 1
    return made if doubled >= 0 else builder.operation("div", builder.constant(1.0), made)


@cache
def _names() -> dict[int, str]:
    import casadi as ca

    return {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}
