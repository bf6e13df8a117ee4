"""JavaScript: a module with one function of numbers, for browsers and Node, in double precision.

``name(x, …)`` takes the variables in the order of first use and returns an object with an array
for each output, one number a blade; one without blades is an empty array. Outside a function's
domain the results are NaN or infinite.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import JAVASCRIPT_NAMES, check_names
from motorcade.ga.codegen.targets.shared import text
from motorcade.ga.codegen.targets.shared.c_family import comment, indented
from motorcade.ga.codegen.targets.shared.expressions import statements

_TEMPLATES = text.C_LOGIC | {"eq": "({} === {})", "ne": "({} !== {})"}
_FUNCTIONS = text.SAME_NAMES | {"abs": "abs", "min": "min", "max": "max"}
_CALLING = ("", "Returns an object: an array for each output, one number a blade.")


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The module, in double precision, which is that of JavaScript's numbers.

    Raises ValueError: another precision, names that JavaScript keeps for itself.
    """
    if precision not in (None, DOUBLE):
        raise ValueError(f"target javascript: expected precision float64, got {precision.numpy}")
    check_names(program, JAVASCRIPT_NAMES)
    dialect = text.Templates(_TEMPLATES, _FUNCTIONS, prefix="Math.")
    written = statements(program.tape, dialect, JAVASCRIPT_NAMES.words)
    body = [f"const {s.name} = {s.expression};" for s in written.body]
    body.append("return {")
    for operand, row in zip(program.tape.outputs, written.results, strict=True):
        body += _entry(operand.name, row)
    body.append("};")
    lines = [
        comment([*text.description(program, "javascript"), *_CALLING]),
        *text.call(f"export function {program.name}", text.variables(program), " {"),
        *indented(body),
        "}",
    ]
    return {f"{program.name}.mjs": "\n".join(lines) + "\n"}


def _entry(name: str, row: Sequence[str]) -> list[str]:
    # Without brackets __proto__ would set what the object inherits from.
    key = f'["{name}"]' if name == "__proto__" else name
    if not row:
        return [f"    {key}: [],"]
    return [f"    {key}: [", *(f"        {value}," for value in row), "    ],"]
