"""torch: a module with one function of tensors, which broadcast and can be differentiated.

The function returns a dictionary of its outputs, each a dictionary of its blades. Every component
has the shape to which all variables broadcast together, constant ones too, and the variables'
device. Without a precision the type is what torch promotes the variables to. Where a choice leaves
out a branch that is not finite, its gradient is NaN: torch multiplies it by zero.
"""

from __future__ import annotations

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets.names import python_names
from motorcade.ga.codegen.targets.shared.python_module import ArrayLibrary, array_module, listed
from motorcade.ga.codegen.targets.shared.text import SAME_NAMES

_FUNCTIONS = SAME_NAMES | {
    "abs": "abs", "min": "fmin", "max": "fmax", "and": "logical_and", "or": "logical_or",
    "not": "logical_not", "select": "where",
}  # fmt: skip
_NAMES = python_names(
    "torch", "sum", "TypeError", "_full", "_given", "_number", "_shape", "_value", "_zero",
    modules=["torch"],
)  # fmt: skip
_CLOSING = (
    "_number = _zero.new_tensor",
    "def _full(_value):",
    "    _value = torch.as_tensor(_value, dtype=_zero.dtype, device=_zero.device)",
    "    return _value.expand(_shape).clone()",
)


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """The module; it computes in the precision, or in that of the variables where it is None.

    Raises ValueError: names that Python or the module keeps for itself, numbers too large.
    """
    return array_module(program, precision, _LIBRARY)


def _opening(name: str, variables: list[str], precision: Precision | None) -> list[str]:
    """Lines that bring the variables to one type; a zero carries it, and the device."""
    kind = f"torch.{precision.numpy}" if precision else "torch.get_default_dtype()"
    if not variables:
        return [f"_zero = torch.zeros((), dtype={kind})", "_shape = ()", *_CLOSING]
    return [
        *listed(f"_given = [{', '.join(variables)}]"),
        "_zero = sum(_value.detach().new_zeros(()) for _value in _given)",
        "if _zero.is_complex():",
        f'    raise TypeError(f"{name}: expected real numbers, got {{_zero.dtype}}")',
        *([] if precision else ["if not _zero.is_floating_point():"]),
        f"{'' if precision else '    '}_zero = _zero.to({kind})",
        "_given = [_value.to(_zero.dtype) for _value in _given]",
        *listed(f"[{', '.join(variables)}] = _given"),
        "_shape = torch.broadcast_shapes(*[_value.shape for _value in _given])",
        *_CLOSING,
    ]


_LIBRARY = ArrayLibrary(
    target="torch",
    imported="import torch",
    prefix="torch.",
    functions=_FUNCTIONS,
    names=_NAMES,
    summary="Outputs by name, each a dictionary of its blades; variables are tensors.",
    opening=_opening,
)
