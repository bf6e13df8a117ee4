"""CasADi: a module with one function that returns a ``casadi.Function``, to differentiate further.

The function's inputs are the variables and its outputs those of the script, all by name. An output
is a column of its components; one without components is an empty column.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import check_names, python_names
from motorcade.ga.codegen.targets.shared import text
from motorcade.ga.codegen.targets.shared.expressions import statements
from motorcade.ga.codegen.targets.shared.python_module import assignments, listed, module

_FUNCTIONS = text.SAME_NAMES | {
    "abs": "fabs", "min": "fmin", "max": "fmax", "and": "logic_and", "or": "logic_or",
    "not": "logic_not", "select": "if_else",
}  # fmt: skip
_NAMES = python_names("ca", modules=["casadi", "null", "jac", "hess"], underscores=True)


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The module, in double precision, which is the only one that CasADi has.

    Raises ValueError: another precision, names that Python, CasADi or the module keeps for itself.
    """
    if precision not in (None, DOUBLE):
        raise ValueError(f"target casadi: expected precision float64, got {precision.numpy}")
    check_names(program, _NAMES)
    written = statements(
        program.tape, text.Templates(text.COMPARISONS, _FUNCTIONS, prefix="ca."), _NAMES.words
    )
    names = text.variables(program)
    outputs = [operand.name for operand in program.tape.outputs]
    # CasADi wants to be told that an input and an output may have one name.
    shared = ', {"allow_duplicate_io_names": True}' if {*names} & {*outputs} else ""
    body = [
        *(f'{name} = ca.SX.sym("{name}")' for name in names),
        *assignments(written.body),
        "_columns = [",
        *(f"    {line}" for row in written.results for line in _column(row)),
        "]",
        *listed(f"_inputs = [{', '.join(names)}]"),
        *listed(f"_names = [{', '.join(map(_quoted, names))}]"),
        *listed(f"_results = [{', '.join(map(_quoted, outputs))}]"),
        f'return ca.Function("{program.name}", _inputs, _columns, _names, _results{shared})',
    ]
    described = text.description(program, "casadi")
    return module(program, described, "import casadi as ca", [], "The program as a function.", body)


def _column(row: Sequence[str]) -> list[str]:
    """A dense column of these components; the empty one in front makes it SX whatever they are."""
    rows = [
        line for value in row for line in text.wrapped(f"    {value},", text.WIDTH - 12, " " * 8)
    ]
    return ["ca.densify(ca.vertcat(", "    ca.SX(0, 1),", *rows, ")),"]


def _quoted(name: str) -> str:
    return f'"{name}"'
