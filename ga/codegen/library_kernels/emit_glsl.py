"""GLSL from tapes: kernels as functions for shaders, in single precision.

``void name(float a[n], …, out float out_z[m])`` for GLSL 3.30 or later, or GLSL ES 3.00 or later,
which says ``precision highp float;`` first.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorcade.ga.codegen.expressions import component_name, statements
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import SINGLE
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.names import GLSL_NAMES
from motorcade.ga.codegen.targets.shared.c_family import comment, declarations, function, indented
from motorcade.ga.codegen.targets.shared.templates import C_LOGIC, Templates
from motorcade.ga.codegen.targets.shared.text import WIDTH, wrapped

__all__ = ["glsl_source"]

_NOTE = "Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those."
# Powers of two come from the bits of a number: exact everywhere, as exp2 and log2 are not.
_TEMPLATES = C_LOGIC | {
    "exp2_of_integer": "intBitsToFloat((int({0}) + 127) << 23)",
    "exponent": "float(((floatBitsToInt({0}) >> 23) & 255) - 127)",
}
# Shaders are written in ASCII; comments of other signs stop some compilers.
_SIGNS = str.maketrans({"∞": "inf", "ε": "eps ", "×": "x"})
_FUNCTIONS = {"sqrt": "sqrt", "abs": "abs", "floor": "floor", "min": "min", "max": "max"}


def glsl_source(group: str, kernels: Sequence[Kernel]) -> str:
    """The GLSL file of kernels of one group."""
    listed = ", ".join(kernel.name for kernel in kernels)
    opening = [*wrapped(f"Kernels of the group {group}: {listed}.", WIDTH - 3, ""), _NOTE]
    return "\n".join([comment(opening), *(_function(kernel) for kernel in kernels)]) + "\n"


def _function(kernel: Kernel) -> str:
    tape = kernel.tape(SINGLE)
    slots = frozenset(f"out_{operand.name}" for operand in kernel.outputs)
    dialect = Templates(_TEMPLATES, _FUNCTIONS, SINGLE)
    written = statements(tape, dialect, GLSL_NAMES.words | slots)
    parameters = [f"float {operand.name}[{operand.width}]" for operand in kernel.inputs]
    parameters += [f"out float out_{operand.name}[{operand.width}]" for operand in kernel.outputs]
    told = [f"{kernel.name}: {kernel.summary}"]
    told += [f"{o.name}: {', '.join(o.components)}" for o in (*kernel.inputs, *kernel.outputs)]
    stores = [
        f"out_{operand.name}[{i}] = {value};"
        for operand, row in zip(kernel.outputs, written.results, strict=True)
        for i, value in enumerate(row)
    ]
    lines = [
        "",
        comment([line.translate(_SIGNS) for text in told for line in wrapped(text, WIDTH - 8)]),
        function(kernel.name, parameters, ""),
        "{",
        *indented(_load(operand, tape) for operand in kernel.inputs),
        *indented(declarations(written.body, "float", "bool")),
        *indented(stores),
        "}",
    ]
    return "\n".join(lines)


def _load(operand: Operand, tape: Tape) -> str:
    """The components of an operand as variables, as the statements name them."""
    named = (
        f"{component_name(operand.name, i, operand.width)} = {operand.name}[{i}]"
        for i in tape.components_read(operand.name)
    )
    return f"float {', '.join(named)};"
