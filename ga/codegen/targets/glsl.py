"""GLSL: one function for shaders of GLSL 3.30 or later, or GLSL ES 3.00 or later.

``void name(float x, …, out float out_A[nA], …)`` takes the variables in the order of first use and
fills one array for each output that has components. ES shaders say ``precision highp float;``
first. How exact sin, exp and the like are, GLSL leaves to the driver.

The library's own kernels become ``void name(float a[n], …, out float out_z[m])``.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorcade.ga.codegen.library_kernels.kernel import NOTE, Kernel
from motorcade.ga.codegen.precision import SINGLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import GLSL_NAMES, check_names
from motorcade.ga.codegen.targets.shared import c_family, text
from motorcade.ga.codegen.targets.shared.expressions import statements

# Drivers make rough asin and acos (Mesa errs by 2e-4); atan and sqrt are good everywhere.
_TEMPLATES = text.C_LOGIC | {
    "asin": "atan({0}, sqrt((1.0 - ({0})) * (1.0 + ({0}))))",
    "acos": "atan(sqrt((1.0 - ({0})) * (1.0 + ({0}))), {0})",
    # From the bits of a number: exact everywhere, as exp2 and log2 are not.
    "exp2_of_integer": "intBitsToFloat((int({0}) + 127) << 23)",
    "exponent": "float(((floatBitsToInt({0}) >> 23) & 255) - 127)",
}
# Shaders are written in ASCII; comments of other signs stop some compilers.
_SIGNS = str.maketrans({"∞": "inf", "ε": "eps ", "×": "x"})
_FUNCTIONS = text.SAME_NAMES | {"abs": "abs", "min": "min", "max": "max", "atan2": "atan"}
_CALLING = ("", "Output A fills out_A, one number a blade; one without blades has no parameter.")


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The function, in single precision.

    Raises ValueError: another precision, names that GLSL keeps for itself, numbers too large.
    """
    if precision not in (None, SINGLE):
        raise ValueError(f"target glsl: expected precision float32, got {precision.numpy}")
    slots = c_family.array_slots(program)
    check_names(program, GLSL_NAMES, slots)
    parameters = [f"float {name}" for name in text.variables(program)]
    parameters += c_family.array_parameters(program, "out float")
    dialect = text.Templates(_TEMPLATES, _FUNCTIONS, SINGLE)
    written = statements(program.tape, dialect, GLSL_NAMES.words | {slot for _, slot in slots})
    lines = [
        c_family.comment([*text.description(program, "glsl"), *_CALLING]),
        c_family.function(program.name, parameters, ""),
        "{",
        *c_family.indented(c_family.declarations(written.body, "float", "bool")),
        *c_family.indented(c_family.array_stores(program.tape.outputs, written.results)),
        "}",
    ]
    return {f"{program.name}.glsl": "\n".join(lines) + "\n"}


def library_source(group: str, kernels: Sequence[Kernel]) -> str:
    """The GLSL file of kernels of one group."""
    listed = ", ".join(kernel.name for kernel in kernels)
    opening = [*text.wrapped(f"Kernels of the group {group}: {listed}.", text.WIDTH - 3, ""), NOTE]
    return "\n".join([c_family.comment(opening), *(_kernel(kernel) for kernel in kernels)]) + "\n"


def _kernel(kernel: Kernel) -> str:
    tape = kernel.tape(SINGLE)
    slots = frozenset(f"out_{operand.name}" for operand in kernel.outputs)
    written = statements(
        tape, text.Templates(_TEMPLATES, _FUNCTIONS, SINGLE), GLSL_NAMES.words | slots
    )
    parameters = [f"float {operand.name}[{operand.width}]" for operand in kernel.inputs]
    parameters += [f"out float out_{operand.name}[{operand.width}]" for operand in kernel.outputs]
    described = [f"{kernel.name}: {kernel.summary}"]
    described += [f"{o.name}: {', '.join(o.components)}" for o in (*kernel.inputs, *kernel.outputs)]
    lines = [
        "",
        c_family.comment(
            [
                part.translate(_SIGNS)
                for line in described
                for part in text.wrapped(line, text.WIDTH - 8)
            ]
        ),
        c_family.function(kernel.name, parameters, ""),
        "{",
        *c_family.indented(
            line
            for o in kernel.inputs
            for line in c_family.loads(o, tape, "float", together=o.width)
        ),
        *c_family.indented(c_family.declarations(written.body, "float", "bool")),
        *c_family.indented(c_family.array_stores(kernel.outputs, written.results)),
        "}",
    ]
    return "\n".join(lines)
