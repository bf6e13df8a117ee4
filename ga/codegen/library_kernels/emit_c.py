"""C from tapes: structure-of-arrays loops that a compiler turns into SIMD code.

Each kernel becomes one function a precision with the signature of ``support.h``: for every
operand a pointer to its first component and the distance to the next one. The loop has no branch
and runs over whole blocks of rows, so the compiler needs no remainder.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from motorcade.ga.codegen.expressions import Statement, component_name, statements
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import PRECISIONS, Precision
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.shared.templates import C_LOGIC, Templates

__all__ = ["c_source", "c_table"]

_NOTE = "Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those."
_FUNCTIONS = {
    "sqrt": "sqrt", "abs": "fabs", "floor": "floor", "min": "smaller", "max": "larger",
    "exp2_of_integer": "exp2_of_integer", "exponent": "exponent",
}  # fmt: skip
_WIDTH = 100


def _dialect(precision: Precision) -> Templates:
    suffix = "f" if precision.c == "float" else ""
    return Templates(C_LOGIC, _FUNCTIONS, precision, suffix=suffix)


def c_source(group: str, kernels: Sequence[Kernel]) -> str:
    """The C file of a group of kernels, both precisions."""
    listed = ", ".join(kernel.name for kernel in kernels)
    parts = [_comment([f"Kernels of the group {group}: {listed}.", _NOTE]), '#include "support.h"']
    for kernel in kernels:
        parts.append(_comment([f"{kernel.name}: {kernel.summary}", *_operands(kernel)]))
        parts.extend(c_function(kernel, precision) for precision in PRECISIONS)
    return "\n\n".join(parts) + "\n"


def c_function(kernel: Kernel, precision: Precision) -> str:
    """One kernel in one precision, without the comment above it."""
    tape = kernel.tape(precision)
    written = statements(tape, _dialect(precision))
    loop = [
        *(_load(operand, precision, tape) for operand in kernel.inputs),
        *(_declaration(statement, precision) for statement in written.body),
        *(
            _store(operand, i, value)
            for operand, row in zip(kernel.outputs, written.results, strict=True)
            for i, value in enumerate(row)
        ),
    ]
    lines = [
        "MOTORCADE_SIMD",
        f"void motorcade_{kernel.name}_{precision.suffix}(MOTORCADE_ARGUMENTS({precision.c}))",
        "{",
        *_pointers(kernel, precision),
        "    MOTORCADE_INDEPENDENT",
        "    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {",
        *(f"        {line}" for part in loop for line in part),
        "    }",
        "}",
    ]
    return "\n".join(lines)


def c_table(kernels: Sequence[Kernel]) -> str:
    """The C file that lists all kernels with the widths of their operands."""
    lines = [_comment(["All kernels, in the order of their definitions.", _NOTE])]
    lines.append('#include "support.h"\n')
    for kernel in kernels:
        for p in PRECISIONS:
            lines.append(f"void motorcade_{kernel.name}_{p.suffix}(MOTORCADE_ARGUMENTS({p.c}));")
    lines.append("\nconst struct motorcade_kernel motorcade_kernels[] = {")
    for kernel in kernels:
        ins, outs = ([o.width for o in side] for side in (kernel.inputs, kernel.outputs))
        widths = ", ".join(map(str, [*ins, *outs]))
        lines.append(
            f'    {{"{kernel.name}", {len(ins)}, {len(outs)}, {{{widths}}},\n'
            f"     motorcade_{kernel.name}_f32, motorcade_{kernel.name}_f64}},"
        )
    lines.append("};")
    lines.append("const size_t motorcade_kernel_count =")
    lines.append("    sizeof motorcade_kernels / sizeof motorcade_kernels[0];")
    return "\n".join(lines) + "\n"


def _comment(lines: Sequence[str]) -> str:
    wrapped = [part for line in lines for part in textwrap.wrap(line, _WIDTH - 3)]
    return "/* " + "\n * ".join(wrapped) + " */"


def _operands(kernel: Kernel) -> list[str]:
    return [
        f"{side} {operand.name}: {' '.join(operand.components)}"
        for side, operands in (("in", kernel.inputs), ("out", kernel.outputs))
        for operand in operands
    ]


def _pointers(kernel: Kernel, precision: Precision) -> list[str]:
    sides = (("input", kernel.inputs), ("output", kernel.outputs))
    lines = [
        line
        for side, operands in sides
        for i, operand in enumerate(operands)
        for line in _pointer(operand, i, precision, side)
    ]
    if not any(operand.width > 1 for operand in kernel.inputs):
        lines.append("    (void)input_steps;")
    return lines


def _pointer(operand: Operand, index: int, precision: Precision, side: str) -> list[str]:
    constant = "const " if side == "input" else ""
    step = f"    const ptrdiff_t {operand.name}_step = {side}_steps[{index}];"
    pointer = f"    {constant}{precision.c} *restrict {operand.name}_at = {side}s[{index}];"
    return [pointer, step] if operand.width > 1 else [pointer]


def _place(operand: Operand, component: int) -> str:
    if component == 0:
        return f"{operand.name}_at[i]"
    factor = f"{component} * " if component > 1 else ""
    return f"{operand.name}_at[{factor}{operand.name}_step + i]"


def _load(operand: Operand, precision: Precision, tape: Tape) -> list[str]:
    items = [
        f"{component_name(operand.name, i, operand.width)} = {_place(operand, i)}"
        for i in tape.components_read(operand.name)
    ]
    rows = [", ".join(items[i : i + 3]) for i in range(0, len(items), 3)]
    return [f"const {precision.c} {row};" for row in rows]


def _declaration(statement: Statement, precision: Precision) -> list[str]:
    kind = "_Bool" if statement.boolean else precision.c
    return _wrapped(f"const {kind} {statement.name} = {statement.expression};")


def _store(operand: Operand, component: int, value: str) -> list[str]:
    return _wrapped(f"{_place(operand, component)} = {value};")


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(
        text, _WIDTH - 8, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
