"""The code of a tape for the run-time compiler: a C function over blocks of rows, a NumPy function.

Neither has a name of the user's in it: components of inputs are x0, x1, …, in their order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from motorcade.ga.codegen.passes.choices import without_repeated_choices
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.c_batch import BLOCK, WIDEST
from motorcade.ga.codegen.targets.c_elementary import functions_called, vector_dialect
from motorcade.ga.codegen.targets.numpy import library_dialect
from motorcade.ga.codegen.targets.shared.c_family import declarations
from motorcade.ga.codegen.targets.shared.expressions import component_name, statements
from motorcade.ga.codegen.targets.shared.python_module import assignments

SYMBOL = "motorcade_program"

# Arguments are one number or array a component; the results are in a tuple.
NumpyFunction = Callable[..., tuple[Any, ...]]

_INDEPENDENT = """\
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define INDEPENDENT _Pragma("GCC ivdep")
#else
#define INDEPENDENT
#endif"""


def plain_tape(tape: Tape) -> Tape:
    """The tape with one input x of all components, and one output of all."""
    first: dict[str, int] = {}
    count = 0
    for operand in tape.inputs:
        first[operand.name] = count
        count += operand.width
    nodes = tuple(
        node._replace(source=("x", first[node.source[0]] + node.source[1]))
        if node.op == "input"
        else node
        for node in tape.nodes
    )
    results = tuple(index for row in tape.results for index in row)
    given = Operand("x", tuple(map(str, range(count))))
    return Tape(
        (given,), (Operand("out", tuple(map(str, range(len(results))))),), nodes, (results,)
    )


def c_source(tape: Tape, precision: Precision) -> str:
    """A C file with the function `SYMBOL` of a plain tape, as ``native/rows.h`` calls it.

    Raises:
        ValueError: numbers too large for the precision.
    """
    made = without_repeated_choices(tape)
    written = statements(made, vector_dialect(precision))
    real, (given,) = precision.c, made.inputs
    read = made.components_read("x")
    loop = [
        *(f"const {real} {_x(k, given)} = in{k}[i];" for k in read),
        *declarations(written.body, f"const {real}", "const _Bool"),
        *(f"out{k}[i] = {value};" for k, value in enumerate(written.results[0])),
    ]
    lines = [
        "#include <math.h>",
        "#include <stddef.h>",
        functions_called(loop),
        _INDEPENDENT,
        f"void {SYMBOL}(const {real} *const *in, {real} *const *out, size_t blocks);",
        *WIDEST,
        f"void {SYMBOL}(const {real} *const *in, {real} *const *out, size_t blocks)",
        "{",
        *(f"    const {real} *restrict in{k} = in[{k}];" for k in read),
        *(f"    {real} *restrict out{k} = out[{k}];" for k in range(len(written.results[0]))),
        *(["    (void)in;"] if not read else []),
        "    INDEPENDENT",
        f"    for (size_t i = 0; i < {BLOCK} * blocks; ++i) {{",
        *(f"        {line}" for line in loop),
        "    }",
        "}",
    ]
    return "\n".join(lines) + "\n"


def numpy_function(tape: Tape, precision: Precision) -> NumpyFunction:
    """The Python function of a plain tape, in a precision.

    Raises:
        ValueError: numbers too large for the precision.
    """
    made = without_repeated_choices(tape)
    written = statements(made, library_dialect(precision))
    (given,) = made.inputs
    parameters = ", ".join(_x(k, given) for k in range(given.width))
    results = ", ".join(written.results[0])
    lines = [
        "import numpy as np",
        "from motorcade.ga.kernels.powers_of_two import exp2_of_integer, exponent",
        f"def run({parameters}):",
        *(f"    {line}" for line in assignments(written.body, lead=4)),
        f"    return ({results},)" if results else "    return ()",
    ]
    names: dict[str, Any] = {}
    exec(compile("\n".join(lines) + "\n", "<program>", "exec"), names)  # our own text
    function: NumpyFunction = names["run"]
    return function


def _x(k: int, given: Operand) -> str:
    return component_name("x", k, given.width)
