"""NumPy: a module with one function of keyword arguments, scalars or arrays that broadcast.

The function returns a dictionary of its outputs, each a dictionary of its blades. Every component
has the shape to which all variables broadcast together, constant ones too. Without a precision the
type is that of the variables (float32 stays float32, whole numbers become float64). Outside a
function's domain the results are NaN or infinite, without a warning.
"""

from __future__ import annotations

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import python_names
from motorcade.ga.codegen.targets.shared.python_module import ArrayLibrary, array_module, listed
from motorcade.ga.codegen.targets.shared.templates import SAME_NAMES

__all__ = ["write"]

_FUNCTIONS = SAME_NAMES | {
    "asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "abs": "abs",
    "min": "fmin", "max": "fmax", "and": "logical_and", "or": "logical_or", "not": "logical_not",
    "select": "where",
}  # fmt: skip
_NAMES = python_names(
    "np", "isinstance", "int", "float", "TypeError", "_full", "_given", "_number", "_shape",
    "_type", "_value", modules=["numpy"],
)  # fmt: skip
_CLOSING = (
    "_number = _type.type",
    "def _full(_value):",
    "    return np.broadcast_to(_value, _shape).astype(_type)[()]",
)


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The module; it computes in the precision, or in that of the variables where it is None.

    Raises:
        ValueError: names that Python or the module keeps for itself, numbers too large.
    """
    return array_module(program, precision, _LIBRARY)


def _opening(name: str, variables: list[str], precision: Precision | None) -> list[str]:
    """Lines that make arrays of one type of the variables."""
    fixed = f"_type = np.dtype(np.{precision.numpy if precision else 'float64'})"
    if not variables:
        return [fixed, "_shape = ()", *_CLOSING]
    return [
        *listed(f"_given = [{', '.join(variables)}]"),
        "_given = [",
        "    _value if isinstance(_value, (int, float)) else np.asarray(_value)",
        "    for _value in _given",
        "]",
        "_type = np.result_type(*_given)",
        'if _type.kind not in "biuf":',
        f'    raise TypeError(f"{name}: expected real numbers, got {{_type}}")',
        *([fixed] if precision else ['if _type.kind != "f":', f"    {fixed}"]),
        "_given = [np.asarray(_value, _type) for _value in _given]",
        *listed(f"[{', '.join(variables)}] = _given"),
        "_shape = np.broadcast_shapes(*[_value.shape for _value in _given])",
        *_CLOSING,
    ]


_LIBRARY = ArrayLibrary(
    target="numpy",
    imported="import numpy as np",
    prefix="np.",
    functions=_FUNCTIONS,
    names=_NAMES,
    summary="Outputs by name, each a dictionary of its blades; variables broadcast.",
    opening=_opening,
    within='with np.errstate(all="ignore"):',
)
