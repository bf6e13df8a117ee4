"""Julia: one function of real numbers, in their own precision or in a given one.

``name(x, …)`` takes the variables in the order of first use and returns a named tuple with a tuple
for each output, one number a blade; ``name.(xs, …)`` broadcasts. Outside a function's domain the
results are NaN or infinite, where Julia itself would throw.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import JULIA_NAMES, Reserved, check_names
from motorcade.ga.codegen.targets.shared import text
from motorcade.ga.codegen.targets.shared.c_family import indented
from motorcade.ga.codegen.targets.shared.expressions import statements
from motorcade.ga.codegen.targets.shared.python_module import assignments

# Where the functions of Julia throw instead of giving NaN: outside of these.
_DOMAINS = {
    "sqrt": "v >= 0",
    "log": "v >= 0",
    "asin": "abs(v) <= 1",
    "acos": "abs(v) <= 1",
    "sin": "abs(v) < Inf",
    "cos": "abs(v) < Inf",
    "tan": "abs(v) < Inf",
}
_FUNCTIONS = {name: f"real_{name}" if name in _DOMAINS else name for name in text.SAME_NAMES}
_FUNCTIONS |= {"abs": "abs", "min": "min", "max": "max", "atan2": "atan"}
_TEMPLATES = text.C_LOGIC | {"select": "ifelse({}, {}, {})"}
_OWN = frozenset(_FUNCTIONS.values()) | {"Inf", "Float32", "Float64"}
_CALLING = ("", "Returns a named tuple: a tuple for each output, one number a blade.")


class _Julia(text.Templates):
    """Numbers in Julia's spelling: ``1.5f0`` is in single precision."""

    def __init__(self, precision: Precision) -> None:
        super().__init__(_TEMPLATES, _FUNCTIONS, precision)
        self._single = precision.c == "float"

    def constant(self, value: float) -> str:
        digits, _, exponent = super().constant(value).partition("e")
        if self._single:
            return f"{digits}f{int(exponent or 0)}"
        return f"{digits}e{int(exponent)}" if exponent else digits


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The function; it computes in the precision, or in that of the variables where it is None.

    Raises ValueError: names that Julia keeps for itself, numbers too large for the precision.
    """
    reserved = Reserved("Julia", JULIA_NAMES.words | _OWN | _only_underscores(program))
    check_names(program, reserved)
    written = statements(program.tape, _Julia(precision or DOUBLE), reserved.words)
    parameters = text.variables(program)
    option = f" --precision {precision.numpy}" if precision else ""
    kind = "" if precision is None else f"Float{8 * (4 if precision.c == 'float' else 8)}"
    body = [
        *_converted(parameters, kind),
        *(
            f"{_FUNCTIONS[name]}(v) = {domain} ? {name}(v) : oftype(v, NaN)"
            for name, domain in _DOMAINS.items()
            if name in program.tape.operations()
        ),
        *assignments(written.body, lead=4),
        "return (;",
        *(
            f"    {_field(operand.name, reserved)} = ({_listed(row)}),"
            for operand, row in zip(program.tape.outputs, written.results, strict=True)
        ),
        ")",
    ]
    described = [*text.description(program, f"julia{option}"), *_CALLING]
    lines = [
        *(f"# {line}".rstrip() for line in described),
        *text.call(f"function {program.name}", parameters, ""),
        *indented(body),
        "end",
    ]
    return {f"{program.name}.jl": "\n".join(lines) + "\n"}


def _only_underscores(program: Program) -> frozenset[str]:
    """Julia only writes to variables of such names."""
    return frozenset(
        name for name in [*text.variables(program), program.name] if not name.strip("_")
    )


def _field(name: str, reserved: Reserved) -> str:
    """Any name as that of a field."""
    return f'var"{name}"' if reserved.keeps(name) or not name.strip("_") else name


def _converted(values: Sequence[str], kind: str) -> list[str]:
    names = ", ".join(values)
    if not values:
        return []
    numbers = f"{kind}.(({names},))" if kind else f"promote(float.(({names},))...)"
    line = f"({names},) = {numbers}"
    # Julia ends a statement before a line that begins with "=", so a long one has no space there.
    return [line if len(line) < text.WIDTH - 4 else f"({names},)={numbers}"]


def _listed(row: Sequence[str]) -> str:
    return ", ".join(row) + ("," if len(row) == 1 else "")
