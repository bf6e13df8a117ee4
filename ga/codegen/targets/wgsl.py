"""WGSL: one function for the shaders of WebGPU, in single precision.

``fn name(x: f32, …, out_A: ptr<function, array<f32, nA>>, …)`` takes the variables in the order of
first use and fills one array for each output that has components; a caller declares ``var A:
array<f32, nA>;`` and passes ``&A``. How exact sin, exp and the like are, WGSL leaves to the driver,
and so what they give outside their domains.
"""

from __future__ import annotations

from motorcade.ga.codegen.precision import SINGLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import Tape
from motorcade.ga.codegen.targets.names import WGSL_NAMES, check_names, typed
from motorcade.ga.codegen.targets.shared import text
from motorcade.ga.codegen.targets.shared.c_family import array_slots, indented
from motorcade.ga.codegen.targets.shared.expressions import statements

_TEMPLATES = text.C_LOGIC | {"select": "select({2}, {1}, {0})"}
_FUNCTIONS = text.SAME_NAMES | {"abs": "abs", "min": "min", "max": "max"}
_CALLING = ("", "Output A fills out_A, one number a blade; one without blades has no parameter.")


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The function, in single precision.

    Raises ValueError: another precision, names that WGSL keeps for itself, numbers too large,
    values that are not finite whatever the variables are, which no shader may hold.
    """
    if precision not in (None, SINGLE):
        raise ValueError(f"target wgsl: expected precision float32, got {precision.numpy}")
    slots = array_slots(program)
    check_names(program, WGSL_NAMES, slots)
    tape = typed(program.tape)
    _check_finite(tape)
    # A number without a suffix is as exact as its text until it meets a variable.
    dialect = text.Templates(_TEMPLATES, _FUNCTIONS, SINGLE)
    reserved = WGSL_NAMES.words | {slot for _, slot in slots}
    written = statements(tape, dialect, reserved)
    parameters = [f"{name}: f32" for name in text.variables(program)]
    outputs = [(o, row) for o, row in zip(tape.outputs, written.results, strict=True) if row]
    parameters += [f"out_{o.name}: ptr<function, array<f32, {o.width}>>" for o, _ in outputs]
    body = [
        *(
            f"let {s.name}: {'bool' if s.boolean else 'f32'} = {s.expression};"
            for s in written.body
        ),
        *(f"(*out_{o.name})[{i}] = {v};" for o, row in outputs for i, v in enumerate(row)),
    ]
    lines = [
        *(f"// {line}".rstrip() for line in [*text.description(program, "wgsl"), *_CALLING]),
        *text.call(f"fn {program.name}", parameters, " {"),
        *indented(body),
        "}",
    ]
    return {f"{program.name}.wgsl": "\n".join(lines) + "\n"}


def _check_finite(tape: Tape) -> None:
    """What is left of operations on numbers alone is not finite: all others are worked out."""
    for node in tape.nodes:
        if node.args and all(tape.nodes[k].op == "const" for k in node.args):
            values = ", ".join(f"{tape.nodes[k].value:g}" for k in node.args)
            raise ValueError(f"target wgsl: expected finite values, got {node.op}({values})")
