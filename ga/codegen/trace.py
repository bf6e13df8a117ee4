"""Tracing: runs a definition on CasADi scalars and reads the instructions back as a tape."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from motorcade.ga.codegen.powers_of_two import power_of_two_node
from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder

__all__ = ["casadi_function", "trace"]

Definition = Callable[..., Sequence[Sequence[Any]]]

# CasADi's names of the operations that have one node here.
_SAME = {
    "OP_ADD": "add", "OP_SUB": "sub", "OP_MUL": "mul", "OP_DIV": "div", "OP_NEG": "neg",
    "OP_SQRT": "sqrt", "OP_FABS": "abs", "OP_FLOOR": "floor", "OP_FMIN": "min", "OP_FMAX": "max",
    "OP_LT": "lt", "OP_LE": "le", "OP_EQ": "eq", "OP_NE": "ne", "OP_AND": "and", "OP_OR": "or",
    "OP_NOT": "not", "OP_IF_ELSE_ZERO": "keep", "OP_LOG": "log",
}  # fmt: skip


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
    import casadi as ca

    function = casadi_function(name, inputs, outputs, define)
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
    if spelled not in _SAME:
        raise ValueError(f"{name}: expected operations that the emitters know, got {spelled}")
    return builder.operation(_SAME[spelled], *args)


@cache
def _names() -> dict[int, str]:
    import casadi as ca

    return {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}
