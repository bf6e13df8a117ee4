"""Derivatives of programs by their parameters: CasADi differentiates the tape itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from motorcade.ga.codegen.passes.optimize import optimized
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.recording import tape_of
from motorcade.ga.codegen.runtime.evaluator import Evaluator
from motorcade.ga.codegen.tape import Node, Operand, Tape, TapeBuilder

# What CasADi calls the operations that Python has no sign for.
_CALLED = {
    "abs": "fabs", "min": "fmin", "max": "fmax", "and": "logic_and", "or": "logic_or",
    "not": "logic_not", "select": "if_else", "lt": "lt", "le": "le",
    "eq": "eq", "ne": "ne", "add": "plus", "sub": "minus", "mul": "times", "div": "rdivide",
}  # fmt: skip


class Jacobian:
    """The derivatives of a program's results by one parameter; see `CompiledFunction.jacobian`.

    >>> import numpy as np
    >>> from motorcade.ga.algebra import EGA3
    >>> from motorcade.ga.codegen.functions import compile_function
    >>> def turned(v, angle):
    ...     return (-angle / 2 * EGA3.blade("e1^e2")).exp().sandwich(v)
    >>> by_angle = compile_function(turned, algebra=EGA3, v="e1 e2 e3").jacobian("angle")
    >>> by_angle(np.array([1.0, 0.0, 5.0]), 0.0).tolist()
    [[0.0], [1.0], [0.0]]
    """

    def __init__(self, program: Program, parameter: str, single: bool) -> None:
        width = next((o.width for o in program.tape.inputs if o.name == parameter), None)
        if width is None:
            names = ", ".join(operand.name for operand in program.tape.inputs)
            raise ValueError(f"{program.name}: parameter: expected one of {names}, got {parameter}")
        self._width = width
        self._single = single
        self._outputs = program.tape.outputs
        tape = jacobian_tape(program.name, program.tape, parameter)
        count = sum(operand.width for operand in tape.inputs)
        self._runs = Evaluator(f"{program.name}_by_{parameter}", tape, single, [False] * count)

    def __call__(self, *args: Any) -> Any:
        """Arrays ``(*, n, m)`` of the derivatives of `n` components by `m`, or a dict of them.

        Arguments and errors are those of `CompiledFunction.arrays`.
        """
        arrays = self._runs.arrays(*args)
        if self._single:
            return self._matrices(arrays, self._outputs[0])
        return {
            operand.name: self._matrices(array, operand)
            for operand, array in zip(self._outputs, arrays, strict=True)
        }

    def backend(self, precision: str = "float64") -> str:
        """How calls in a precision run now: see `CompiledFunction.backend`."""
        return self._runs.backend(precision)

    def wait(self, precision: str = "float64") -> bool:
        """Have the C of a precision compiled; whether it is there."""
        return self._runs.wait(precision)

    def _matrices(self, rows: Any, operand: Operand) -> Any:
        return rows.reshape(*rows.shape[:-1], operand.width, self._width)


def jacobian_tape(name: str, tape: Tape, parameter: str) -> Tape:
    """The tape whose outputs are the derivatives of each output by a parameter, in rows."""
    import casadi as ca

    symbols = {operand.name: ca.SX.sym(operand.name, operand.width) for operand in tape.inputs}
    values = _values(tape, lambda node: symbols[node.source[0]][node.source[1]])
    operands, rows = [], []
    for operand, row in zip(tape.outputs, tape.results, strict=True):
        column = ca.vertcat(ca.SX(0, 1), *(ca.SX(values[k]) for k in row))
        matrix = ca.densify(ca.jacobian(column, symbols[parameter]))
        places = [(i, j) for i in range(matrix.shape[0]) for j in range(matrix.shape[1])]
        operands.append(Operand(operand.name, tuple(f"{i} {j}" for i, j in places)))
        rows.append([matrix[i, j] for i, j in places])
    whole = tape_of(name, tape.inputs, operands, list(symbols.values()), rows)
    return _with_zeros(optimized(whole)[0], operands)


def _values(tape: Tape, value: Callable[[Node], Any]) -> list[Any]:
    """Each node's value in CasADi's symbols."""
    import casadi as ca

    values: list[Any] = []
    for node in tape.nodes:
        args = [values[k] for k in node.args]
        if node.op == "const":
            values.append(ca.SX(node.value))
        elif node.op == "input":
            values.append(value(node))
        elif node.op == "neg":
            values.append(-args[0])
        elif node.op == "keep":
            values.append(ca.if_else(args[0], args[1], 0.0))
        else:
            values.append(getattr(ca, _CALLED.get(node.op, node.op))(*args))
    return values


def _with_zeros(tape: Tape, wanted: Sequence[Operand]) -> Tape:
    """The tape with the components that the optimiser left out as zero."""
    builder = TapeBuilder()
    builder.nodes.extend(tape.nodes)
    zero = builder.constant(0.0)
    results = []
    for operand, output, row in zip(wanted, tape.outputs, tape.results, strict=True):
        own = dict(zip(output.components, row, strict=True))
        results.append([own.get(component, zero) for component in operand.components])
    return builder.finished(tape.inputs, tuple(wanted), results)
