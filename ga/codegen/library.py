"""The library's own kernels as files: one C and one Python file a group, and the table of all."""

from __future__ import annotations

from pathlib import Path

from motorcade.ga.codegen.emit_c import c_source, c_table
from motorcade.ga.codegen.emit_numpy import numpy_source, numpy_table
from motorcade.ga.codegen.kernel import Kernel

__all__ = ["GENERATED", "library_files", "write_library"]

GENERATED = Path(__file__).resolve().parents[1] / "kernels" / "generated"


def library_files() -> dict[str, str]:
    """Name and text of each generated file.

    Raises:
        ModuleNotFoundError: without CasADi or mpmath, which only this needs.
    """
    from motorcade.ga.kernels.definitions import KERNELS

    groups: dict[str, list[Kernel]] = {}
    for kernel in KERNELS:
        groups.setdefault(kernel.group, []).append(kernel)
    files = {"table.c": c_table(KERNELS), "__init__.py": numpy_table(KERNELS)}
    for group, kernels in groups.items():
        files[f"{group}.c"] = c_source(group, kernels)
        files[f"{group}.py"] = numpy_source(group, kernels)
    return files


def write_library(folder: Path) -> list[Path]:
    """Write the generated files into a folder; files of kernels that are gone are removed."""
    files = library_files()
    folder.mkdir(exist_ok=True)
    for old in (*folder.glob("*.c"), *folder.glob("*.py")):
        if old.name not in files:
            old.unlink()
    paths = [folder / name for name in files]
    for path in paths:
        path.write_text(files[path.name], encoding="utf-8")
    return paths
