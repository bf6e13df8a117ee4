"""C++: a header of one inline function of scalars, C++17, in double or single precision.

``std::tuple<std::array<double, nA>, …> name(double x, …)`` takes the variables in the order of
first use and returns one array for each output that has components: ``auto [A, B] = name(x);``. A
single array is returned as it is. Outside a function's domain the results are NaN or infinite.
"""

from __future__ import annotations

from motorcade.ga.codegen.passes.rows import with_unlike_rows
from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import C_FUNCTIONS, CPP_NAMES, check_names
from motorcade.ga.codegen.targets.shared import text
from motorcade.ga.codegen.targets.shared.c_family import comment, declarations, indented
from motorcade.ga.codegen.targets.shared.expressions import statements

_PAIRS = ("atan2", "min", "max")
_TEMPLATES = text.C_LOGIC | {
    op: f"std::{name}({{}}{', {}' if op in _PAIRS else ''})" for op, name in C_FUNCTIONS.items()
}
_CALLING = (
    "",
    "Returns a std::array for each output that has components, one number a blade: a std::tuple,",
    "or the array alone where there is one.",
)


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The header, in double precision unless another is given.

    Raises ValueError: names that C++ keeps for itself, numbers too large for the precision.
    """
    check_names(program, CPP_NAMES)
    real = precision or DOUBLE
    suffix = "f" if real.c == "float" else ""
    dialect = text.Templates(_TEMPLATES, {}, real, suffix=suffix)
    tape = with_unlike_rows(program.tape)
    written = statements(tape, dialect, CPP_NAMES.words)
    arrays = [f"std::array<{real.c}, {o.width}>" for o in program.tape.outputs if o.width]
    array = arrays[0] if len(arrays) == 1 else f"std::tuple<{', '.join(arrays)}>"
    body = [
        *(f"static_cast<void>({name});" for name in text.unread(program)),
        *declarations(written.body, f"const {real.c}", "const bool"),
        *_returned(array, arrays, [row for row in written.results if row]),
    ]
    described = [*text.description(program, f"cpp --precision {real.numpy}"), *_CALLING]
    parameters = [f"{real.c} {name}" for name in text.variables(program)]
    lines = [
        comment(described),
        *("#pragma once", "", "#include <array>", "#include <cmath>", "#include <tuple>", ""),
        *text.call(f"inline {array} {program.name}", parameters, ""),
        *("{", *indented(body), "}"),
    ]
    return {f"{program.name}.hpp": "\n".join(lines) + "\n"}


def _returned(kind: str, arrays: list[str], results: list[tuple[str, ...]]) -> list[str]:
    if len(arrays) == 1:
        return ["return {{", *(f"    {value}," for value in results[0]), "}};"]
    inside = []
    for array, row in zip(arrays, results, strict=True):
        inside += [f"    {array}{{{{", *(f"        {value}," for value in row), "    }},"]
    if not inside:
        return ["return {};"]
    inside[-1] = inside[-1].removesuffix(",")
    return [f"return {kind}{{", *inside, "};"]
