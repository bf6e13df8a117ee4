"""NumPy: a module with one function of keyword arguments, scalars or arrays that broadcast.

The function returns a dictionary of its outputs, each a dictionary of its blades. Every component
has the shape to which all variables broadcast together, constant ones too. Without a precision the
type is that of the variables (float32 stays float32, whole numbers become float64). Outside a
function's domain the results are NaN or infinite, without a warning.

The library's own kernels become functions of arrays ``(*, n)`` whose batches broadcast, one a
precision, that return a tuple of components: the fallback and the witness of the compiled ones.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorcade.ga.codegen.library_kernels.kernel import NOTE, Kernel
from motorcade.ga.codegen.precision import PRECISIONS, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.names import python_names
from motorcade.ga.codegen.targets.shared.expressions import component_name, statements
from motorcade.ga.codegen.targets.shared.python_module import (
    ArrayLibrary,
    ArrayTemplates,
    array_module,
    assignments,
    listed,
)
from motorcade.ga.codegen.targets.shared.text import COMPARISONS, SAME_NAMES, WIDTH, call, wrapped

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

    Raises ValueError: names that Python or the module keeps for itself, numbers too large.
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
_POWERS_OF_TWO = ("exp2_of_integer", "exponent")
_LIBRARY_TEMPLATES = (
    COMPARISONS
    | {"and": "({} & {})", "or": "({} | {})"}
    | {name: f"{name}({{}})" for name in _POWERS_OF_TWO}
)
_LIBRARY_FUNCTIONS = _FUNCTIONS | {"min": "minimum", "max": "maximum"}


def library_dialect(precision: Precision) -> ArrayTemplates:
    """NumPy's operations on arrays of a precision."""
    return ArrayTemplates(
        _LIBRARY_TEMPLATES, _LIBRARY_FUNCTIONS, precision, prefix="np.",
        number=f"np.{precision.numpy}", typed=("select",),
    )  # fmt: skip


def library_source(group: str, kernels: Sequence[Kernel]) -> str:
    """The Python module of a group of kernels, both precisions."""
    listed = ", ".join(kernel.name for kernel in kernels)
    functions = [kernel_function(k, p) for k in kernels for p in PRECISIONS]
    body = "".join(f"\n\n{function}\n" for function in functions)
    called = ", ".join(name for name in _POWERS_OF_TWO if f"{name}(" in body)
    imports = "from typing import Any\n"
    if "np." in body:
        imports += "\nimport numpy as np\n"
    if called:
        imports += f"\nfrom motorcade.ga.kernels.powers_of_two import {called}\n"
    return _opening_of(f"Kernels of the group {group}: {listed}.") + imports + body


def library_table(kernels: Sequence[Kernel]) -> str:
    """The module that lists all kernels: by name, the widths of inputs and outputs."""
    rows = [
        f'    "{k.name}": ("{k.group}", {tuple(o.width for o in k.inputs)}, {k.outputs[0].width}),'
        for k in kernels
    ]
    opening = _opening_of(
        "All kernels: the module that holds them, widths of the inputs, width of the output."
    )
    table = "KERNELS: dict[str, tuple[str, tuple[int, ...], int]] = {"
    return opening + "\n".join([table, *rows, "}"]) + "\n"


def _opening_of(summary: str) -> str:
    note = NOTE.replace("`", "``")
    text = "\n".join(wrapped(summary, WIDTH - 3, ""))
    return f'"""{text}\n\n{note}\n"""\n# fmt: off\n\nfrom __future__ import annotations\n\n'


def kernel_function(kernel: Kernel, precision: Precision) -> str:
    """The text of a kernel as a function of arrays ``(*, n)``, one an input; see above."""
    tape = kernel.tape(precision)
    written = statements(tape, library_dialect(precision))
    results = [value for row in written.results for value in row]
    body = [
        f'"""{kernel.summary}"""',
        *(line for operand in kernel.inputs for line in _load(operand, tape)),
        *assignments(written.body, lead=4),
        "return (",
        *(line for value in results for line in wrapped(f"    {value},", WIDTH - 8, " " * 8)),
        ")",
    ]
    arguments = [f"{operand.name}: Any" for operand in kernel.inputs]
    head = call(f"def {kernel.name}_{precision.suffix}", arguments, " -> tuple[Any, ...]:")
    return "\n".join([*head, *(f"    {line}" for line in body)])


def _load(operand: Operand, tape: Tape) -> list[str]:
    read = tape.components_read(operand.name)
    names = [component_name(operand.name, i, operand.width) for i in read]
    if len(read) == 1:
        return [f"{names[0]} = {operand.name}[..., {read[0]}]"]
    chosen = f"range({len(read)})" if read == list(range(len(read))) else str(tuple(read))
    text = f"{', '.join(names)} = ({operand.name}[..., i] for i in {chosen})"
    lines = wrapped(text, WIDTH - 4)
    if " = (" in lines[0]:
        return lines
    names_alone = wrapped(f"    {', '.join(names)}", WIDTH - 4)
    return ["(", *names_alone, f") = ({operand.name}[..., i] for i in {chosen})"]
