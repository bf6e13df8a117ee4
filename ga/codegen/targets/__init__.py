"""Programs as source code: one module a target, each with ``write(program, precision)``.

``write`` returns the text of each file by its name. Names from scripts are checked by `names`; no
other text of a script gets into the code. `shared` holds what several targets need, `languages`
those targets that write a plain function in one language more.
"""

from __future__ import annotations

from collections.abc import Callable

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets import c, c_batch, casadi, glsl, numpy, torch
from motorcade.ga.codegen.targets.languages import (
    cpp_function,
    javascript,
    julia,
    latex,
    rust,
    wgsl,
)
from motorcade.ga.codegen.targets.shared.reader import check_text

__all__ = ["TARGETS", "Write"]

Write = Callable[[Program, Precision | None], dict[str, str]]


def _read_back(language: str, write: Write) -> Write:
    def written(program: Program, precision: Precision | None) -> dict[str, str]:
        files = write(program, precision)
        for name, text in files.items():
            check_text(language, name, text)
        return files

    return written


_BY_PYTHON = ("numpy", "casadi", "torch")  # which parses them where they are put together
_WRITERS: dict[str, Write] = {
    "c": c.write,
    "c-batch": c_batch.write,
    "numpy": numpy.write,
    "glsl": glsl.write,
    "casadi": casadi.write,
    "torch": torch.write,
    "cpp": cpp_function.write,
    "rust": rust.write,
    "javascript": javascript.write,
    "wgsl": wgsl.write,
    "julia": julia.write,
    "latex": latex.write,
}
TARGETS: dict[str, Write] = {
    language: write if language in _BY_PYTHON else _read_back(language, write)
    for language, write in _WRITERS.items()
}
