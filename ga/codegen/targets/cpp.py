"""C++: a header of inline functions of one row each, on ``std::array``, for C++17 or later.

``std::array<Real, m> name(const std::array<Real, n> &a, …)`` is a template where the operations do
not depend on the precision, and takes doubles where they do. Functions of one name are told apart
by the sizes of their arguments.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import DOUBLE, SINGLE
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets.shared import c_family
from motorcade.ga.codegen.targets.shared.expressions import branching_statements
from motorcade.ga.codegen.targets.shared.text import C_LOGIC, Templates, call, wrapped

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
