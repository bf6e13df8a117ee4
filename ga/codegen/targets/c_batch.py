"""C over batches: one loop over rows in structure-of-arrays layout, which compilers vectorise.

``void name(size_t rows, const double *in_x, …, double *out_A_e1_e2, …)`` takes one pointer to
`rows` numbers for each variable and each component of each output. No output may overlap another
array. The loop has no branch and calls no function of ``math.h`` but sqrt, floor, ceil and fabs:
sines, logarithms and the like stand above it as polynomials (`c_elementary`), so that gcc -O3
-fno-math-errno -fno-trapping-math makes SIMD code of all of it. It runs over whole blocks of rows;
the last rows are part of a block that begins earlier, or that is filled up where there are few.

The library's own kernels are such loops too, one a precision, with the signature of ``support.h``:
for every operand a pointer to its first component and the distance to the next one. They run over
whole blocks of rows, so that the compiler needs no remainder.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from motorcade.ga.codegen.library_kernels.kernel import NOTE, Kernel
from motorcade.ga.codegen.passes.choices import without_repeated_choices
from motorcade.ga.codegen.precision import DOUBLE, PRECISIONS, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets.c import c_dialect, c_files
from motorcade.ga.codegen.targets.c_elementary import (
    FUNCTION_NAMES,
    functions_called,
    vector_dialect,
)
from motorcade.ga.codegen.targets.names import C_NAMES, check_names
from motorcade.ga.codegen.targets.shared.c_family import (
    close_comment,
    declarations,
    function,
    indented,
    loads,
    operand_lines,
)
from motorcade.ga.codegen.targets.shared.expressions import statements
from motorcade.ga.codegen.targets.shared.text import description, unread, variables

BLOCK = 16
_OWN_NAMES = FUNCTION_NAMES | {"blocks", "last", "padded", "row", "rows"}
_NAMES = replace(C_NAMES, words=C_NAMES.words | _OWN_NAMES)
_LIBRARY_FUNCTIONS = {
    "min": "smaller",
    "max": "larger",
    "exp2_of_integer": "exp2_of_integer",
    "exponent": "exponent",
}
# gcc takes half of a vector of AVX-512 for some processors, unless it is told otherwise. It also
# makes paths of choices by one condition, each with masks of its own, and leaves long chains of
# operations in the order of the source, where a processor has nothing else to do meanwhile.
WIDEST = (
    "#if defined(__GNUC__) && !defined(__clang__)",
    '__attribute__((optimize("schedule-insns", "sched-pressure", "no-thread-jumps")))',
    "#if defined(__AVX512F__)",
    '__attribute__((target("prefer-vector-width=512")))',
    "#endif",
    "#endif",
)
_NO_STEP = re.compile(r"\[0 \* \w+_step \+ i\]")
_CALLING = (
    "",
    "Every pointer is to `rows` numbers: variable x is in_x, blade e1^e2 of output A is",
    "out_A_e1_e2. No output may overlap another array. gcc makes SIMD code of the loop with",
    "-O3 -march=native -fno-math-errno -fno-trapping-math -ffp-contract=fast.",
)


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """Source and header, in double precision unless another is given.

    Raises ValueError: names that C or C++ keeps for itself, numbers too large for the precision.
    """
    real = precision or DOUBLE
    pointers = {name: f"in_{name}" for name in variables(program)}
    places = [_places(operand) for operand in program.tape.outputs]
    slots = [*pointers.items(), *(slot for row in places for slot in row)]
    check_names(program, _NAMES, slots)
    reserved = _NAMES.words | {slot for _, slot in slots}
    tape = without_repeated_choices(program.tape)
    written = statements(tape, vector_dialect(real), reserved)
    unused = unread(program)
    read = [name for name in pointers if name not in unused]
    loop = [
        *(f"const {real.c} {name} = {pointers[name]}[row];" for name in read),
        *declarations(written.body, f"const {real.c}", "const _Bool"),
        *(
            f"{slot}[row] = {value};"
            for row, values in zip(places, written.results, strict=True)
            for (_, slot), value in zip(row, values, strict=True)
        ),
    ]
    inputs, outputs = list(pointers.values()), [slot for row in places for _, slot in row]
    blocks = f"{program.name}_blocks"
    described = [*description(program, f"c-batch --precision {real.numpy}"), *_CALLING]
    heads = [
        function(name, [f"size_t {count}", *_parameters(real, restrict, inputs, outputs)], "void")
        for name, count, restrict in (
            (program.name, "rows", ""),
            (program.name, "rows", "restrict "),
            (blocks, "blocks", "restrict "),
        )
    ]
    inner = [
        *WIDEST,
        f"static {heads[2]}",
        "{",
        *(f"    (void){pointers[name]};" for name in unused),
        f"    for (size_t row = 0; row < {BLOCK} * blocks; ++row) {{",
        *indented(loop, 2),
        "    }",
        "}",
    ]
    defined = "\n\n".join([functions_called(loop), "\n".join(inner), heads[1]]).lstrip()
    return c_files(program.name, described, heads[0], defined, _body(blocks, real, inputs, outputs))


def _parameters(
    precision: Precision, restrict: str, values: Sequence[str], outputs: Sequence[str]
) -> list[str]:
    return [
        *(f"const {precision.c} *{restrict}{pointer}" for pointer in values),
        *(f"{precision.c} *{restrict}{pointer}" for pointer in outputs),
    ]


def _body(
    blocks: str, precision: Precision, values: Sequence[str], outputs: Sequence[str]
) -> list[str]:
    """Whole blocks, and the last rows in one that overlaps them, or in one that is padded."""
    pointers = [*values, *outputs]
    padded = [f"padded[{k}]" for k in range(len(pointers))]
    loads = [f"padded[{k}][row] = {one}[row];" for k, one in enumerate(values)]
    stores = [f"{one}[row] = padded[{k}][row];" for k, one in enumerate(outputs, len(values))]
    lines = [f"if (rows < {BLOCK}) {{"]
    lines.append(f"    {precision.c} padded[{len(pointers)}][{BLOCK}] = {{{{0}}}};")
    if loads:
        lines += ["    for (size_t row = 0; row < rows; ++row) {"]
        lines += [*(f"        {line}" for line in loads), "    }"]
    lines.append(f"    {blocks}(1, {', '.join(padded)});")
    lines += ["    for (size_t row = 0; row < rows; ++row) {"]
    lines += [*(f"        {line}" for line in stores), "    }", "    return;", "}"]
    lines.append(f"{blocks}(rows / {BLOCK}, {', '.join(pointers)});")
    lines += [f"if (rows % {BLOCK}) {{", f"    const size_t last = rows - {BLOCK};"]
    lines.append(f"    {blocks}(1, {', '.join(f'&{pointer}[last]' for pointer in pointers)});")
    return indented([*lines, "}"])


def _places(operand: Operand) -> list[tuple[str, str]]:
    """The output and the pointer to each of its components."""
    return [
        (operand.name, f"out_{operand.name}_{blade.replace('^', '_')}")
        for blade in operand.components
    ]


def library_source(group: str, kernels: Sequence[Kernel]) -> str:
    """The C file of a group of kernels, both precisions."""
    listed = ", ".join(kernel.name for kernel in kernels)
    parts = [close_comment([f"Kernels of the group {group}: {listed}.", NOTE])]
    parts.append('#include "support.h"')
    for kernel in kernels:
        parts.append(close_comment([f"{kernel.name}: {kernel.summary}", *operand_lines(kernel)]))
        parts.extend(_kernel(kernel, precision) for precision in PRECISIONS)
    return "\n\n".join(parts) + "\n"


def library_table(kernels: Sequence[Kernel]) -> str:
    """The C file that lists all kernels with the widths of their operands."""
    lines = [close_comment(["All kernels, in the order of their definitions.", NOTE])]
    lines += ['#include "support.h"', ""]
    lines += [f"{_head(kernel, p)};" for kernel in kernels for p in PRECISIONS]
    lines += ["", "const struct motorcade_kernel motorcade_kernels[] = {"]
    for kernel in kernels:
        widths = ", ".join(str(o.width) for o in (*kernel.inputs, *kernel.outputs))
        lines += [
            f'    {{"{kernel.name}", {len(kernel.inputs)}, {len(kernel.outputs)}, {{{widths}}},',
            f"     motorcade_{kernel.name}_f32, motorcade_{kernel.name}_f64}},",
        ]
    lines += ["};", "const size_t motorcade_kernel_count ="]
    lines += ["    sizeof motorcade_kernels / sizeof motorcade_kernels[0];"]
    return "\n".join(lines) + "\n"


def _kernel(kernel: Kernel, precision: Precision) -> str:
    tape = kernel.tape(precision)
    written = statements(tape, c_dialect(precision, _LIBRARY_FUNCTIONS))
    number = f"const {precision.c}"
    read = [
        line
        for operand in kernel.inputs
        for line in loads(operand, tape, number, "{0}_at[{1} * {0}_step + i]", 3)
    ]
    loop = [
        *declarations(written.body, number, "const _Bool"),
        *(
            f"{operand.name}_at[{i} * {operand.name}_step + i] = {value};"
            for operand, row in zip(kernel.outputs, written.results, strict=True)
            for i, value in enumerate(row)
        ),
    ]
    lines = [
        "MOTORCADE_SIMD",
        _head(kernel, precision),
        "{",
        *indented(_pointers(kernel, precision)),
        "    MOTORCADE_INDEPENDENT",
        "    for (size_t i = 0; i < MOTORCADE_LANES * blocks; ++i) {",
        *(f"        {_first_steps(line)}" for line in read),
        *indented(map(_first_steps, loop), 2),
        "    }",
        "}",
    ]
    return "\n".join(lines)


def _first_steps(line: str) -> str:
    """Without multiples by 0 and 1 in the places of components."""
    return _NO_STEP.sub("[i]", line).replace("[1 * ", "[")


def _head(kernel: Kernel, precision: Precision) -> str:
    arguments = f"MOTORCADE_ARGUMENTS({precision.c})"
    return f"void motorcade_{kernel.name}_{precision.suffix}({arguments})"


def _pointers(kernel: Kernel, precision: Precision) -> list[str]:
    lines = []
    for side, operands in (("input", kernel.inputs), ("output", kernel.outputs)):
        kind = f"const {precision.c}" if side == "input" else precision.c
        for k, operand in enumerate(operands):
            lines.append(f"{kind} *restrict {operand.name}_at = {side}s[{k}];")
            if operand.width > 1:
                lines.append(f"const ptrdiff_t {operand.name}_step = {side}_steps[{k}];")
    if all(operand.width == 1 for operand in kernel.inputs):
        lines.append("(void)input_steps;")
    return lines
