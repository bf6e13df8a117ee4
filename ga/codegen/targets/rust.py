"""Rust: one function of scalars that needs nothing but ``std``, in double or single precision.

``pub fn name(x: f64, …) -> ([f64; nA], …)`` takes the variables in the order of first use and
returns one array for each output that has components: a tuple of them, or the array itself where
there is one. Outside a function's domain the results are NaN or infinite.
"""

from __future__ import annotations

from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import RUST_NAMES, check_names, typed
from motorcade.ga.codegen.targets.shared import text
from motorcade.ga.codegen.targets.shared.c_family import indented
from motorcade.ga.codegen.targets.shared.expressions import statements

_TEMPLATES = text.C_LOGIC | {"select": "(if {} {{ {} }} else {{ {} }})"}
_FUNCTIONS = text.SAME_NAMES | {"abs": "abs", "min": "min", "max": "max", "log": "ln"}
_CALLING = (
    "",
    "Returns an array for each output that has components, one number a blade: a tuple, or the",
    "array alone where there is one.",
)
_ALLOWED = "#[allow(non_snake_case, unused_parens, clippy::all)]"


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The source, in double precision unless another is given.

    Raises ValueError: names that Rust keeps for itself, numbers too large for the precision.
    """
    check_names(program, RUST_NAMES)
    real = precision or DOUBLE
    kind = f"f{8 * (4 if real.c == 'float' else 8)}"
    dialect = text.Templates(_TEMPLATES, _FUNCTIONS, real, prefix=f"{kind}::")
    written = statements(typed(program.tape), dialect, RUST_NAMES.words)
    arrays = [f"[{kind}; {o.width}]" for o in program.tape.outputs if o.width]
    results = [row for row in written.results if row]
    described = [*text.description(program, f"rust --precision {real.numpy}"), *_CALLING]
    parameters = [f"{name}: {kind}" for name in text.variables(program)]
    body = [
        *(f"let _ = {name};" for name in text.unread(program)),
        *(f"let {s.name}: {'bool' if s.boolean else kind} = {s.expression};" for s in written.body),
        *_returned(results),
    ]
    lines = [
        *(f"// {line}".rstrip() for line in described),
        *("", _ALLOWED),
        *text.call(f"pub fn {program.name}", parameters, f" -> {_type(arrays)} {{"),
        *indented(body),
        "}",
    ]
    return {f"{program.name}.rs": "\n".join(lines) + "\n"}


def _type(arrays: list[str]) -> str:
    return arrays[0] if len(arrays) == 1 else f"({', '.join(arrays)})"


def _returned(results: list[tuple[str, ...]]) -> list[str]:
    """The last expression of the function."""
    arrays = [["[", *(f"    {value}," for value in row), "]"] for row in results]
    if len(arrays) == 1:
        return arrays[0]
    return ["(", *(f"    {line}" for a in arrays for line in [*a[:-1], "],"]), ")"]
