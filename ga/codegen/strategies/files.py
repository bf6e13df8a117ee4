"""The files of a script under a strategy: the function that the target ``c`` declares as well."""

from __future__ import annotations

from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.strategies.calls import CallWriter
from motorcade.ga.codegen.strategies.record import record
from motorcade.ga.codegen.targets.c import c_dialect, c_files
from motorcade.ga.codegen.targets.names import C_NAMES, check_names
from motorcade.ga.codegen.targets.shared.c_family import (
    array_parameters,
    array_slots,
    function,
    indented,
)
from motorcade.ga.codegen.targets.shared.text import description
from motorcade.ga.script import Script

__all__ = ["files"]


def files(
    writer: type[CallWriter],
    strategy: str,
    script: Script,
    program: Program,
    precision: Precision | None,
) -> dict[str, str]:
    """Source and header; the function takes and gives what the script's program does."""
    real = precision or DOUBLE
    check_names(program, C_NAMES, array_slots(program))
    variables = [operand.name for operand in program.tape.inputs]
    made = writer(record(script, program.algebra, variables), program.name, real, c_dialect(real))
    parameters = [f"{real.c} {variable}" for variable in variables]
    head = function(program.name, [*parameters, *array_parameters(program, real.c)], "void")
    described = description(program, f"c --strategy {strategy} --precision {real.numpy}")
    steps = _steps(program, made)
    defined = "\n\n".join([*made.definitions(), steps, head])
    return c_files(program.name, described, head, defined, indented([_call(program, made)]))


def _inner(program: Program) -> str:
    """The name of the function with all steps: none of the variables may hide it."""
    taken = {operand.name for operand in program.tape.inputs}
    name = f"{program.name}_steps"
    while name in taken:
        name += "_"
    return name


def _steps(program: Program, made: CallWriter) -> str:
    """All steps, in a function without any name of the script."""
    outputs = [operand for operand in program.tape.outputs if operand.components]
    body = [*made.steps(), *made.stores(outputs)]
    if not any("in[" in line for line in body):
        body.insert(0, "(void)in;")
    parameters = [f"const {made.real} *in", *(f"{made.real} *out{k}" for k in range(len(outputs)))]
    head = f"static {function(_inner(program), parameters, 'void')}"
    return "\n".join([head, "{", *indented(body), "}"])


def _call(program: Program, made: CallWriter) -> str:
    variables = ", ".join(operand.name for operand in program.tape.inputs) or "0"
    outputs = [f"out_{operand.name}" for operand in program.tape.outputs if operand.components]
    arguments = [f"(const {made.real}[]){{{variables}}}", *outputs]
    return f"{_inner(program)}({', '.join(arguments)});"
