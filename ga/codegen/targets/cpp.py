"""C++17: headers of inline functions: one of scalars for a program, and the library's of one row.

``std::tuple<std::array<double, nA>, …> name(double x, …)`` takes the variables in the order of
first use and returns one array for each output that has components: ``auto [A, B] = name(x);``. A
single array is returned as it is. Outside a function's domain the results are NaN or infinite.

``std::array<Real, m> name(const std::array<Real, n> &a, …)`` is a template where the operations do
not depend on the precision, and takes doubles where they do. Functions of one name are told apart
by the sizes of their arguments.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.passes.rebuild import with_unlike_rows
from motorcade.ga.codegen.precision import DOUBLE, SINGLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets.names import C_FUNCTIONS, CPP_NAMES, check_names
from motorcade.ga.codegen.targets.shared import c_family, text
from motorcade.ga.codegen.targets.shared.c_family import comment, declarations, indented
from motorcade.ga.codegen.targets.shared.expressions import branching_statements, statements
from motorcade.ga.codegen.targets.shared.text import C_LOGIC, Templates, call, wrapped

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


_FUNCTIONS = {
    "sqrt": "std::sqrt",
    "abs": "std::abs",
    "floor": "std::floor",
    "min": "std::min",
    "max": "std::max",
    "exp2_of_integer": "std::exp2",
    "exponent": "std::logb",
}


class _Generic(Templates):
    """Numbers in the type that the template is made for."""

    def constant(self, value: float) -> str:
        return f"Real({super().constant(value)})"


def cpp_header(
    namespace: str, opening: Iterable[str], functions: Iterable[tuple[str, Kernel]]
) -> str:
    """The header: each function is a kernel under the name that it is called by."""
    head = [
        c_family.comment(list(opening)),
        *("#pragma once", "", "#include <algorithm>", "#include <array>", "#include <cmath>", ""),
        f"namespace {namespace} {{",
        "",
    ]
    written = [part for name, kernel in functions for part in (_function(name, kernel), "")]
    return "\n".join([*head, *written, f"}}  // namespace {namespace}"]) + "\n"


def _function(name: str, kernel: Kernel) -> str:
    tape, other = (kernel.tape(replace(p, branches=True)) for p in (DOUBLE, SINGLE))
    generic = tape == other
    real = "Real" if generic else "double"
    dialect = (_Generic if generic else Templates)(C_LOGIC, _FUNCTIONS, DOUBLE)
    statements, (results,) = branching_statements(tape, dialect)
    (output,) = kernel.outputs
    parameters = [
        f"const {_type(o, real)} {'&' if o.width > 1 else ''}{o.name}" for o in kernel.inputs
    ]
    body = [
        *(
            line
            for operand in kernel.inputs
            if operand.width > 1
            for line in c_family.loads(operand, tape, f"const {real}")
        ),
        *c_family.branching_declarations(statements, real, "bool"),
        *(
            [f"return {results[0]};"]
            if output.width == 1
            else ["return {", *_listed(results), "};"]
        ),
    ]
    described = [kernel.summary, *(f"{o.name}: {' '.join(o.components)}" for o in kernel.inputs)]
    described.append(f"returns: {' '.join(output.components)}")
    lines = [
        c_family.comment([line for text in described for line in wrapped(text, 96)]),
        *(["template <class Real>"] if generic else []),
        *call(f"inline {_type(output, real)} {name}", parameters, ""),
        "{",
        *c_family.indented(body),
        "}",
    ]
    return "\n".join(lines)


def _type(operand: Operand, real: str) -> str:
    return real if operand.width == 1 else f"std::array<{real}, {operand.width}>"


def _listed(values: Iterable[str]) -> list[str]:
    return [f"    {value}," for value in values]
