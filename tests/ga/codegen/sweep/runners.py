"""How the code of every target is run or, where no tool runs it here, read and worked out."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.strategies import table
from motorcade.ga.codegen.targets import TARGETS
from motorcade.ga.notation import name_text
from tests.ga.codegen.targets.test_latex import read as read_latex
from tests.ga.codegen.targets.test_read_languages import read_julia, read_wgsl
from tests.ga.gaalop.languages import LANGUAGES
from tests.ga.gaalop.scripts import Values
from tests.ga.gaalop.targets import COMPILER, RUNNERS, Prepared, Results, in_c, named

Run = Callable[[list[Prepared], Path], Results]
_ROWS = (1, 15, 16, 37)
# GLSL's words as C++ in double precision: what it computes is then held to the digit.
_AS_CPP = """
#include <cmath>
#define out
#define float double
using namespace std;
static double atan(double y, double x) { return atan2(y, x); }
static double min(double x, double y) { return x < y ? x : y; }
static double max(double x, double y) { return x < y ? y : x; }
"""


def in_batches(programs: list[Prepared], folder: Path) -> Results:
    """`c-batch`: every row of several counts holds the same numbers, and must give the same."""
    if COMPILER is None:
        return {case.case.name: "no C compiler" for case in programs}
    for entry in programs:
        for file, text in TARGETS["c-batch"](entry.program, DOUBLE).items():
            (folder / file).write_text(text)
    library = folder / "all.so"
    sources = sorted(str(path) for path in folder.glob("*.c"))
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC"]
    subprocess.run([COMPILER, *flags, *sources, "-o", str(library), "-lm"], check=True)
    functions = ctypes.CDLL(str(library))
    return {entry.case.name: _batches(functions, entry) for entry in programs}


def _batches(library: ctypes.CDLL, entry: Prepared) -> Values | str:
    outputs = entry.program.tape.outputs
    width = sum(operand.width for operand in outputs)
    rows: list[np.ndarray] = []
    for count in _ROWS:
        inputs = [np.full(count, entry.case.given[o.name]) for o in entry.program.tape.inputs]
        results = np.full((width, count), np.nan)
        pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in [*inputs, *results]]
        getattr(library, entry.program.name)(ctypes.c_size_t(count), *pointers)
        rows.append(results)
    everything = np.concatenate(rows, axis=1)
    if width and not np.allclose(everything, everything[:, :1], rtol=1e-13, atol=1e-13):
        return "rows of one batch differ"
    left = iter(everything[:, 0])
    return named(entry.program, {o.name: list(islice(left, o.width)) for o in outputs})


def in_glsl(programs: list[Prepared], folder: Path) -> Results:
    """GLSL as C++ of double precision."""
    if shutil.which("g++") is None:
        return {entry.case.name: "no g++" for entry in programs}
    lines = [_AS_CPP]
    calls = []
    for entry in programs:
        (text,) = TARGETS["glsl"](entry.program, None).values()
        lines.append(f"static {text[text.index('void ') :]}")
        outputs = [o for o in entry.program.tape.outputs if o.width]
        calls += ["{", *(f"double out_{o.name}[{o.width}];" for o in outputs)]
        values = [repr(entry.case.given[o.name]) for o in entry.program.tape.inputs]
        arguments = ", ".join([*values, *(f"out_{o.name}" for o in outputs)])
        calls.append(f"{entry.program.name}({arguments});")
        calls += [f'for (double x : out_{o.name}) printf("%.17g\\n", x);' for o in outputs]
        calls.append("}")
    main = ["#include <cstdio>", *lines, "int main() {", *calls, "}"]
    (folder / "main.cpp").write_text("\n".join(main))
    command = ["g++", "-std=c++17", "-O0", "main.cpp", "-o", "main"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[:2000]
    numbers = iter(
        subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout.split()
    )
    return {
        entry.case.name: named(
            entry.program,
            {o.name: list(islice(numbers, o.width)) for o in entry.program.tape.outputs},
        )
        for entry in programs
    }


def read_by(read: Callable[[Program, Mapping[str, float]], dict[str, list[Any]]]) -> Run:
    """A runner of what our own readers work out."""

    def run(programs: list[Prepared], folder: Path) -> Results:
        results: Results = {}
        for entry in programs:
            try:
                with np.errstate(all="ignore"):
                    rows = read(entry.program, entry.case.given)
                results[entry.case.name] = named(entry.program, rows)
            except Exception as fault:
                results[entry.case.name] = f"not read: {type(fault).__name__}: {fault}"
        return results

    return run


def _wgsl(program: Program, inputs: Mapping[str, float]) -> dict[str, list[Any]]:
    (text,) = TARGETS["wgsl"](program, None).values()
    numbers = iter(read_wgsl(text, dict(inputs)))
    return {o.name: list(islice(numbers, o.width)) for o in program.tape.outputs}


def _julia(program: Program, inputs: Mapping[str, float]) -> dict[str, list[Any]]:
    (text,) = TARGETS["julia"](program, DOUBLE).values()
    return dict(read_julia(text, dict(inputs)))


def _latex(program: Program, inputs: Mapping[str, float]) -> dict[str, list[Any]]:
    (text,) = TARGETS["latex"](program, None).values()
    lines = read_latex(text, dict(inputs))
    return {
        o.name: list(lines[name_text(o.name) + "'" * (o.name in inputs)].values())[: o.width]
        for o in program.tape.outputs
    }


def in_torch(programs: list[Prepared], folder: Path) -> Results:
    """torch, on tensors of double precision."""
    import torch

    results: Results = {}
    for entry in programs:
        (text,) = TARGETS["torch"](entry.program, None if entry.case.given else DOUBLE).values()
        module = ModuleType(entry.program.name)
        exec(compile(text, entry.program.name, "exec"), module.__dict__)
        tensors = {n: torch.tensor(v, dtype=torch.float64) for n, v in entry.case.given.items()}
        values = getattr(module, entry.program.name)(**tensors)
        results[entry.case.name] = {
            name: {blade: float(v) for blade, v in row.items()} for name, row in values.items()
        }
    return results


def parsed(target: str) -> Run:
    """For what nothing here runs: Python parses it, and no value is compared."""

    def run(programs: list[Prepared], folder: Path) -> Results:
        for entry in programs:
            for text in TARGETS[target](entry.program, None).values():
                compile(text, target, "exec")
        return {entry.case.name: entry.case.expected or {} for entry in programs}

    return run


def _table_code(entry: Prepared) -> dict[str, str]:
    return table.write_code(entry.case.script, entry.program, DOUBLE)


WAYS: dict[str, Run] = {
    **{name: run for name, (run, _) in RUNNERS.items() if name != "glsl"},
    "c --strategy table-code": in_c(_table_code),
    "c-batch": in_batches,
    **LANGUAGES,
    "glsl": in_glsl,
    "wgsl": read_by(_wgsl),
    "julia": read_by(_julia),
    "latex": read_by(_latex),
    "torch": in_torch if find_spec("torch") else parsed("torch"),
}
