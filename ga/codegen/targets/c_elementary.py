"""C functions that compilers make SIMD code of, for loops: ``math.h`` has only calls of its own.

They are written from ga/kernels/definitions/elementary.py once, as ``generated/c/elementary.h``;
generated loops carry the text of those that they need, so that they stand alone. Each function is
defined once however many loops one file includes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

from motorcade.ga.codegen.library_kernels.kernel import NOTE, Kernel
from motorcade.ga.codegen.precision import PRECISIONS, Precision
from motorcade.ga.codegen.targets.names import C_FUNCTIONS
from motorcade.ga.codegen.targets.shared.c_family import close_comment, declarations, indented
from motorcade.ga.codegen.targets.shared.expressions import statements
from motorcade.ga.codegen.targets.shared.text import C_LOGIC, Templates

__all__ = ["FUNCTION_NAMES", "PREFIX", "elementary_header", "functions_called", "vector_dialect"]

PREFIX = "motorcade_"
_KERNELS = Path(__file__).resolve().parents[2] / "kernels"
_HEADER = _KERNELS / "generated" / "c" / "elementary.h"
_SUPPORT = _KERNELS / "native" / "support.h"
_FUNCTIONS = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log",
    "min", "max", "exp2_of_integer", "exponent",
)  # fmt: skip
# Of the functions, and of the guards around them.
FUNCTION_NAMES = frozenset(
    spelled
    for name in _FUNCTIONS
    for kind in ("", "f")
    for spelled in (f"{PREFIX}{name}{kind}", f"{PREFIX}{name}{kind}".upper())
)
_CALLED = re.compile(rf"\b{PREFIX}\w+(?=\()")
_DEFINED = re.compile(rf"^static inline \w+ ({PREFIX}\w+)\(", re.MULTILINE)
# What the bits of numbers are taken by, in the header of the library's kernels.
_BITS = re.compile(
    r"^static inline (?:float|double) (?:exp2_of_integer|exponent)f?\(.*?^}", re.MULTILINE | re.S
)
# No power here is out of the range of normal numbers.
_CLAMPED = re.compile(r"smaller\(larger\(n, [-.0-9f]+\), [-.0-9f]+\)")
_CHOSEN = """\
static inline {real} {prefix}{name}{suffix}(const {real} a, const {real} b)
{{
    return a {sign} b ? a : b;
}}"""


def vector_dialect(precision: Precision) -> Templates:
    """C's operations with the functions of this module instead of calls that no loop can hold."""
    suffix = "f" if precision.c == "float" else ""
    calls = C_FUNCTIONS | {name: f"{PREFIX}{name}" for name in _FUNCTIONS}
    return Templates(C_LOGIC, calls, precision, suffix=suffix)


def elementary_header(kernels: Sequence[Kernel]) -> str:
    """The header of all functions in both precisions, separated by empty lines."""
    parts = [close_comment(["Elementary functions for loops.", NOTE])]
    parts.append("#include <math.h>\n#include <stdint.h>\n#include <string.h>")
    for precision in PRECISIONS:
        suffix = "f" if precision.c == "float" else ""
        for name, sign in (("min", "<"), ("max", ">")):
            parts.append(
                _CHOSEN.format(real=precision.c, prefix=PREFIX, name=name, suffix=suffix, sign=sign)
            )
    for text in _BITS.findall(_SUPPORT.read_text(encoding="utf-8")):
        parts.append(_renamed(text))
    parts += [_function(kernel, precision) for kernel in kernels for precision in PRECISIONS]
    return "\n\n".join(parts) + "\n"


def _renamed(text: str) -> str:
    """A function of the kernels' header under the names of this one."""
    named = re.sub(r"\b(exp2_of_integer|exponent)(f?)\(", rf"{PREFIX}\1\2(", text)
    return _CLAMPED.sub("n", named)


def _function(kernel: Kernel, precision: Precision) -> str:
    dialect = vector_dialect(precision)
    written = statements(kernel.tape(precision), dialect)
    suffix = "f" if precision.c == "float" else ""
    number = f"const {precision.c}"
    parameters = ", ".join(f"{number} {operand.name}" for operand in kernel.inputs)
    body = [
        *declarations(written.body, number, "const _Bool"),
        f"return {written.results[0][0]};",
    ]
    head = f"static inline {precision.c} {PREFIX}{kernel.name}{suffix}({parameters})"
    return "\n".join([f"/* {kernel.summary}. */", head, "{", *indented(body), "}"])


def functions_called(lines: Iterable[str]) -> str:
    """The definitions of what is called in these lines, with what they call themselves.

    Empty where nothing is.
    """
    known = _known_functions()
    wanted: dict[str, None] = {}

    def want(text: str) -> None:
        for name in _CALLED.findall(text):
            if name in known and name not in wanted:
                want(known[name].partition("{")[2])
                wanted[name] = None

    for line in lines:
        want(line)
    if not wanted:
        return ""
    parts = ["#include <stdint.h>\n#include <string.h>"]
    for name in wanted:
        guard = name.upper()
        parts.append(f"#ifndef {guard}\n#define {guard}\n{known[name]}\n#endif")
    return "\n\n".join(parts) + "\n"


@cache
def _known_functions() -> dict[str, str]:
    """The text of each function of the header by its name."""
    known_functions = {}
    for block in _HEADER.read_text(encoding="utf-8").split("\n\n"):
        match = _DEFINED.search(block)
        if match:
            known_functions[match[1]] = block
    return known_functions
