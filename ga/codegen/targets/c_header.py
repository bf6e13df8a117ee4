"""C: functions of one row each, on arrays of doubles, for a header of C99 that C++ can read too.

``MODIFIER void name(const double a[n], …, double out[m])`` reads all that it is given before it
writes, so that a result may replace an argument.
"""

from __future__ import annotations

from dataclasses import replace

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.targets.names import C_FUNCTIONS
from motorcade.ga.codegen.targets.shared.c_family import (
    branching_declarations,
    comment,
    indented,
    loads,
)
from motorcade.ga.codegen.targets.shared.expressions import branching_statements
from motorcade.ga.codegen.targets.shared.text import C_LOGIC, Templates, call, wrapped

_FUNCTIONS = {**C_FUNCTIONS, "exp2_of_integer": "exp2", "exponent": "logb"}


def c_function(name: str, kernel: Kernel, modifier: str) -> str:
    """A kernel of one output as such a function, under the name that it is called by."""
    tape = kernel.tape(replace(DOUBLE, branches=True))
    written, (results,) = branching_statements(tape, Templates(C_LOGIC, _FUNCTIONS, DOUBLE))
    (output,) = kernel.outputs
    body = [
        *(line for operand in kernel.inputs for line in loads(operand, tape, "const double")),
        *branching_declarations(written, "double", "int"),
        *(f"{output.name}[{i}] = {value};" for i, value in enumerate(results)),
    ]
    parameters = [f"const double {o.name}[{o.width}]" for o in kernel.inputs]
    described = [kernel.summary, *(f"{o.name}: {' '.join(o.components)}" for o in kernel.inputs)]
    described.append(f"{output.name}: {' '.join(output.components)}")
    lines = [
        comment([line for text in described for line in wrapped(text, 96)]),
        *call(
            f"{modifier} void {name}", [*parameters, f"double {output.name}[{output.width}]"], ""
        ),
        "{",
        *indented(body),
        "}",
    ]
    return "\n".join(lines)
