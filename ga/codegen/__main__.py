"""``python -m motorcade.ga.codegen``: write ``ga/kernels/generated`` again from the definitions.

One C and one Python file a group, and the table of all; GLSL of what carries vertices; a C++ header
of what other compiled code does to one versor; a C header of elementary functions for loops.
"""

from __future__ import annotations

import sys
from pathlib import Path

from motorcade.ga.codegen.library_kernels.kernel import NOTE, Kernel
from motorcade.ga.codegen.targets import c_batch, glsl, numpy
from motorcade.ga.codegen.targets.c_elementary import elementary_header
from motorcade.ga.codegen.targets.cpp import cpp_header

GENERATED = Path(__file__).resolve().parents[1] / "kernels" / "generated"
# The groups that shaders use.
_IN_SHADERS = ("skinning",)
_VERSORS = (
    "Rotors, motors and similarities one at a time. Versors are taken for unit.",
    NOTE,
)


def library_files() -> dict[str, str]:
    """Path inside the folder, and text, of each generated file.

    Raises ModuleNotFoundError: without CasADi or mpmath, which only this needs.
    """
    from motorcade.ga.kernels.definitions import elementary
    from motorcade.ga.kernels.definitions.library import FUNCTIONS, KERNELS

    groups: dict[str, list[Kernel]] = {}
    for kernel in KERNELS:
        groups.setdefault(kernel.group, []).append(kernel)
    files = {
        "c/table.c": c_batch.library_table(KERNELS),
        "python/__init__.py": numpy.library_table(KERNELS),
    }
    for group, kernels in groups.items():
        files[f"c/{group}.c"] = c_batch.library_source(group, kernels)
        files[f"python/{group}.py"] = numpy.library_source(group, kernels)
    for group in _IN_SHADERS:
        files[f"glsl/{group}.glsl"] = glsl.library_source(group, groups[group])
    files["c/elementary.h"] = elementary_header(elementary.FUNCTIONS)
    files["cpp/versors.h"] = cpp_header("motorcade::versors", _VERSORS, FUNCTIONS)
    return files


def written_files(folder: Path) -> list[Path]:
    """The generated files that lie in a folder."""
    kinds = ("c/*.c", "c/*.h", "cpp/*.h", "python/*.py", "glsl/*.glsl")
    return [path for kind in kinds for path in folder.glob(kind)]


def write_library(folder: Path) -> list[Path]:
    """Write the generated files into a folder; files of kernels that are gone are removed."""
    files = library_files()
    for old in written_files(folder):
        if old.relative_to(folder).as_posix() not in files:
            old.unlink()
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return [folder / name for name in files]


if __name__ == "__main__":
    written = write_library(GENERATED)
    sys.stdout.write(f"{GENERATED}: {len(written)} files\n")
