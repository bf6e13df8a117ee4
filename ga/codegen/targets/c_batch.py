"""C over batches: one loop over rows in structure-of-arrays layout, which compilers vectorise.

``void name(size_t rows, const double *in_x, …, double *out_A_e1_e2, …)`` takes one pointer to
`rows` numbers for each variable and each component of each output. No output may overlap another
array. The loop has no branch; where it calls no function of ``math.h`` but sqrt, floor, ceil or
fabs, gcc -O3 -fno-math-errno -fno-trapping-math makes SIMD code of it.
"""

from __future__ import annotations

from dataclasses import replace

from motorcade.ga.codegen.expressions import statements
from motorcade.ga.codegen.precision import DOUBLE, Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets.c import c_dialect, c_files
from motorcade.ga.codegen.targets.names import C_NAMES, check_names
from motorcade.ga.codegen.targets.shared.c_family import declarations, function, indented
from motorcade.ga.codegen.targets.shared.text import description, unread, variables

__all__ = ["write"]

_NAMES = replace(C_NAMES, words=C_NAMES.words | {"row", "rows"})
_TOLD = (
    "",
    "Every pointer is to `rows` numbers: variable x is in_x, blade e1^e2 of output A is",
    "out_A_e1_e2. No output may overlap another array. gcc makes SIMD code of the loop with",
    "-O3 -fno-math-errno -fno-trapping-math where it calls no sin, exp and the like.",
)


def write(program: Program, precision: Precision | None) -> dict[str, str]:
    """Source and header, in double precision unless another is given.

    Raises:
        ValueError: names that C or C++ keeps for itself, numbers too large for the precision.
    """
    real = precision or DOUBLE
    pointers = {name: f"in_{name}" for name in variables(program)}
    places = [_places(operand) for operand in program.tape.outputs]
    slots = [*pointers.items(), *(slot for row in places for slot in row)]
    check_names(program, _NAMES, slots)
    reserved = _NAMES.words | {slot for _, slot in slots}
    written = statements(program.tape, c_dialect(real), reserved)
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
    body = [
        *(f"    (void){pointers[name]};" for name in unused),
        "    for (size_t row = 0; row < rows; ++row) {",
        *indented(loop, 2),
        "    }",
    ]
    told = [*description(program, f"c-batch --precision {real.numpy}"), *_TOLD]
    heads = []
    for restrict in ("", "restrict "):
        parameters = [f"const {real.c} *{restrict}{pointer}" for pointer in pointers.values()]
        parameters += [f"{real.c} *{restrict}{slot}" for row in places for _, slot in row]
        heads.append(function(program.name, ["size_t rows", *parameters], "void"))
    return c_files(program.name, told, heads[0], heads[1], body)


def _places(operand: Operand) -> list[tuple[str, str]]:
    """The output and the pointer to each of its components."""
    return [
        (operand.name, f"out_{operand.name}_{blade.replace('^', '_')}")
        for blade in operand.components
    ]
