"""GLSL: one function for shaders of GLSL 3.30 or later, or GLSL ES 3.00 or later.

``void name(float x, …, out float out_A[nA], …)`` takes the variables in the order of first use and
fills one array for each output that has components. ES shaders say ``precision highp float;``
first. How exact sin, exp and the like are, GLSL leaves to the driver.
"""

from __future__ import annotations

from motorcade.ga.codegen.expressions import statements
from motorcade.ga.codegen.precision import SINGLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import GLSL_NAMES, check_names
from motorcade.ga.codegen.targets.shared.c_family import (
    array_parameters,
    array_slots,
    array_stores,
    comment,
    declarations,
    function,
    indented,
)
from motorcade.ga.codegen.targets.shared.templates import C_LOGIC, SAME_NAMES, Templates
from motorcade.ga.codegen.targets.shared.text import description, variables

__all__ = ["write"]

# Drivers make rough asin and acos (Mesa errs by 2e-4); atan and sqrt are good everywhere.
_TEMPLATES = C_LOGIC | {
    "asin": "atan({0}, sqrt((1.0 - ({0})) * (1.0 + ({0}))))",
    "acos": "atan(sqrt((1.0 - ({0})) * (1.0 + ({0}))), {0})",
}
_FUNCTIONS = SAME_NAMES | {"abs": "abs", "min": "min", "max": "max", "atan2": "atan"}
_TOLD = ("", "Output A fills out_A, one number a blade; one without blades has no parameter.")


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The function, in single precision.

    Raises:
        ValueError: another precision, names that GLSL keeps for itself, numbers too large.
    """
    if precision not in (None, SINGLE):
        raise ValueError(f"target glsl: expected precision float32, got {precision.numpy}")
    slots = array_slots(program)
    check_names(program, GLSL_NAMES, slots)
    parameters = [f"float {name}" for name in variables(program)]
    parameters += array_parameters(program, "out float")
    dialect = Templates(_TEMPLATES, _FUNCTIONS, SINGLE)
    written = statements(program.tape, dialect, GLSL_NAMES.words | {slot for _, slot in slots})
    lines = [
        comment([*description(program, "glsl"), *_TOLD]),
        function(program.name, parameters, ""),
        "{",
        *indented(declarations(written.body, "float", "bool")),
        *indented(array_stores(program, written.results)),
        "}",
    ]
    return {f"{program.name}.glsl": "\n".join(lines) + "\n"}
