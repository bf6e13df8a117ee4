"""C: one function of a row of scalars, C99, in double or single precision.

``void name(double x, …, double out_A[nA], …)`` takes the variables in the order of first use and
fills one array for each output that has components. The source needs no header; the header is for
callers in C and C++. Outside a function's domain the results are NaN or infinite. Inverse tangents
and the like are the polynomials of `c_elementary`, which take two thirds of the time of a call of
``math.h`` for a motor's logarithm; its sines are kept, which are exact at any angle.

C: functions of one row each, on arrays of doubles, for a header of C99 that C++ can read too.

``MODIFIER void name(const double a[n], …, double out[m])`` reads all that it is given before it
writes, so that a result may replace an argument.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.passes.rebuild import with_unlike_rows
from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.c_elementary import FUNCTION_NAMES, PREFIX, functions_called
from motorcade.ga.codegen.targets.names import C_FUNCTIONS, C_NAMES, check_names
from motorcade.ga.codegen.targets.shared import c_family
from motorcade.ga.codegen.targets.shared.expressions import branching_statements, statements
from motorcade.ga.codegen.targets.shared.text import (
    C_LOGIC,
    Templates,
    call,
    description,
    unread,
    variables,
    wrapped,
)

_OWN = {name: f"{PREFIX}{name}" for name in ("asin", "acos", "atan", "atan2", "min", "max")}
_CALLING = (
    "",
    "Variables are parameters of their own name; output A fills out_A, one number a blade, and",
    "one without blades has no parameter.",
)


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """Source and header, in double precision unless another is given.

    Raises ValueError: names that C or C++ keeps for itself, numbers too large for the precision.
    """
    real = precision or DOUBLE
    slots = c_family.array_slots(program)
    check_names(program, C_NAMES, slots)
    parameters = [f"{real.c} {name}" for name in variables(program)]
    parameters += c_family.array_parameters(program, real.c)
    reserved = C_NAMES.words | FUNCTION_NAMES | {slot for _, slot in slots}
    tape = with_unlike_rows(program.tape)
    written = statements(tape, c_dialect(real, _OWN), reserved)
    body = [
        *(f"(void){name};" for name in unread(program)),
        *c_family.declarations(written.body, f"const {real.c}", "const _Bool"),
        *c_family.array_stores(tape.outputs, written.results),
    ]
    described = [*description(program, f"c --precision {real.numpy}"), *_CALLING]
    head = c_family.function(program.name, parameters, "void")
    defined = f"{functions_called(body)}\n{head}".lstrip()
    return c_files(program.name, described, head, defined, c_family.indented(body))


def c_dialect(precision: Precision, others: Mapping[str, str] | None = None) -> Templates:
    """C's operations, with the functions of ``math.h`` for the precision, but for some others."""
    suffix = "f" if precision.c == "float" else ""
    return Templates(C_LOGIC, {**C_FUNCTIONS, **(others or {})}, precision, suffix=suffix)


def c_files(
    name: str, described: Sequence[str], declared: str, defined: str, body: Sequence[str]
) -> dict[str, str]:
    """Source and header of one function; the source declares it too and needs no header."""
    guard = f"MOTORCADE_{name}_H"
    include = ["#include <stddef.h>", ""] if "size_t " in declared else []
    source = [
        c_family.comment(described),
        "#include <math.h>",
        *(include or [""]),
        f"{declared};",
        "",
        defined,
        "{",
    ]
    header = [
        *[c_family.comment(described), f"#ifndef {guard}", f"#define {guard}", "", *include],
        *["#ifdef __cplusplus", 'extern "C" {', "#endif", ""],
        *[f"{declared};", ""],
        *["#ifdef __cplusplus", "}", "#endif", "", f"#endif /* {guard} */"],
    ]
    return {
        f"{name}.c": "\n".join([*source, *body, "}"]) + "\n",
        f"{name}.h": "\n".join(header) + "\n",
    }


_FUNCTIONS = {**C_FUNCTIONS, "exp2_of_integer": "exp2", "exponent": "logb"}


def c_function(name: str, kernel: Kernel, modifier: str) -> str:
    """A kernel of one output as such a function, under the name that it is called by."""
    tape = kernel.tape(replace(DOUBLE, branches=True))
    written, (results,) = branching_statements(tape, Templates(C_LOGIC, _FUNCTIONS, DOUBLE))
    (output,) = kernel.outputs
    body = [
        *(
            line
            for operand in kernel.inputs
            for line in c_family.loads(operand, tape, "const double")
        ),
        *c_family.branching_declarations(written, "double", "int"),
        *(f"{output.name}[{i}] = {value};" for i, value in enumerate(results)),
    ]
    parameters = [f"const double {o.name}[{o.width}]" for o in kernel.inputs]
    described = [kernel.summary, *(f"{o.name}: {' '.join(o.components)}" for o in kernel.inputs)]
    described.append(f"{output.name}: {' '.join(output.components)}")
    lines = [
        c_family.comment([line for text in described for line in wrapped(text, 96)]),
        *call(
            f"{modifier} void {name}", [*parameters, f"double {output.name}[{output.width}]"], ""
        ),
        "{",
        *c_family.indented(body),
        "}",
    ]
    return "\n".join(lines)
