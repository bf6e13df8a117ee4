"""NumPy from tapes: the same operations on whole batches, the fallback and witness of the C.

Each kernel becomes one function a precision that takes arrays ``(*, n)`` whose batches broadcast
and returns a tuple of components, each an array over the batch.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from motorcade.ga.codegen.expressions import component_name, statements
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import PRECISIONS, Precision
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.shared.templates import COMPARISONS, Templates

__all__ = ["numpy_source", "numpy_table"]

_NOTE = "Written by ``python -m motorcade.ga.codegen`` from ga/kernels/definitions; edit those."
_LOGIC = COMPARISONS | {"and": "({} & {})", "or": "({} | {})"}
_FUNCTIONS = {
    "sqrt": "np.sqrt", "abs": "np.abs", "floor": "np.floor", "min": "np.minimum",
    "max": "np.maximum", "not": "np.logical_not", "select": "np.where",
    "exp2_of_integer": "exp2_of_integer", "exponent": "exponent",
}  # fmt: skip
_POWERS_OF_TWO = ("exp2_of_integer", "exponent")
_WIDTH = 100


class _NumPy(Templates):
    def __init__(self, precision: Precision) -> None:
        super().__init__(_LOGIC, _FUNCTIONS, precision)
        self._cast = f"np.{precision.numpy}"

    def call(self, op: str, args: list[str]) -> str:
        if op == "select":
            args = [args[0], *map(self._typed, args[1:])]
        return super().call(op, args)

    def _typed(self, branch: str) -> str:
        """Two plain numbers would come out of `np.where` as float64."""
        number = branch.lstrip("-").replace(".", "", 1)
        return f"{self._cast}({branch})" if number[:1].isdigit() else branch


def numpy_source(group: str, kernels: Sequence[Kernel]) -> str:
    """The Python module of a group of kernels, both precisions."""
    listed = ", ".join(kernel.name for kernel in kernels)
    opening = "\n".join(textwrap.wrap(f"Kernels of the group {group}: {listed}.", _WIDTH - 3))
    functions = [numpy_function(k, p) for k in kernels for p in PRECISIONS]
    body = "".join(f"\n\n{function}\n" for function in functions)
    called = [name for name in _POWERS_OF_TWO if f"{name}(" in body]
    imports = "\nimport numpy as np\n" if "np." in body else ""
    if called:
        listed = ", ".join(called)
        imports += f"\nfrom motorcade.ga.kernels.powers_of_two import {listed}\n"
    return (
        f'"""{opening}\n\n{_NOTE}\n"""\n# fmt: off\n\nfrom __future__ import annotations\n\n'
        "from typing import Any\n" + imports + body
    )


def numpy_table(kernels: Sequence[Kernel]) -> str:
    """The module that lists all kernels: by name, the widths of inputs and outputs."""
    rows = [
        f'    "{k.name}": ("{k.group}", {tuple(o.width for o in k.inputs)}, {k.outputs[0].width}),'
        for k in kernels
    ]
    return (
        f'"""All kernels: the module that holds them, widths of the inputs, width of the output.'
        f'\n\n{_NOTE}\n"""\n# fmt: off\n\nfrom __future__ import annotations\n\n'
        "KERNELS: dict[str, tuple[str, tuple[int, ...], int]] = {\n" + "\n".join(rows) + "\n}\n"
    )


def numpy_function(kernel: Kernel, precision: Precision) -> str:
    """One kernel in one precision."""
    tape = kernel.tape(precision)
    written = statements(tape, _NumPy(precision))
    arguments = ", ".join(f"{operand.name}: Any" for operand in kernel.inputs)
    results = [value for row in written.results for value in row]
    lines = [
        f"def {kernel.name}_{precision.suffix}({arguments}) -> tuple[Any, ...]:",
        *_indented(f'"""{kernel.summary}"""'),
        *(line for operand in kernel.inputs for line in _load(operand, tape)),
    ]
    for statement in written.body:
        lines += _assigned(statement.name, statement.expression)
    lines.append("    return (")
    for value in results:
        lines += [f"    {line}" for line in _wrapped(f"{value},")]
    lines.append("    )")
    return "\n".join(lines)


def _load(operand: Operand, tape: Tape) -> list[str]:
    read = tape.components_read(operand.name)
    names = [component_name(operand.name, i, operand.width) for i in read]
    if len(read) == 1:
        return [f"    {names[0]} = {operand.name}[..., {read[0]}]"]
    chosen = f"range({len(read)})" if read == list(range(len(read))) else str(tuple(read))
    return _indented(f"{', '.join(names)} = ({operand.name}[..., i] for i in {chosen})")


def _assigned(name: str, expression: str) -> list[str]:
    if len(name) + len(expression) + 7 <= _WIDTH:
        return [f"    {name} = {expression}"]
    return [f"    {name} = (", *(f"    {line}" for line in _wrapped(expression)), "    )"]


def _indented(text: str) -> list[str]:
    return _wrapped(text)


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(
        text, _WIDTH - 4, initial_indent="    ", subsequent_indent="        ",
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
