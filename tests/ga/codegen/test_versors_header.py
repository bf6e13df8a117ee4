"""The header of functions for one versor gives what the kernels of batches give."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")
pytest.importorskip("mpmath", reason="mpmath, which only the generator needs, is not installed")

from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.ga.codegen.__main__ import GENERATED
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets.shared.expressions import Branch, branched
from motorcade.ga.kernels.backend import function
from motorcade.ga.kernels.definitions.library import FUNCTIONS, KERNELS

COUNT = 400
BATCHED = [(name, kernel) for name, kernel in FUNCTIONS if kernel in KERNELS]


def bivectors(rng: np.random.Generator, width: int) -> FloatArray:
    """From nothing to beyond a whole turn, with small and large shares of growth."""
    sizes = 10.0 ** rng.uniform(-12.0, 0.6, (COUNT, 1))
    made = sizes * rng.standard_normal((COUNT, width))
    made[:10] = 0.0
    made[10:20, :3] *= 1e-9
    made[20:40] /= 1.0 + np.abs(made[20:40])
    return made


def rows_of(operand: Operand, rng: np.random.Generator) -> FloatArray:
    """Unit versors of all sizes where an operand is one, any numbers else."""
    made: dict[int, FloatArray] = {
        1: np.exp(rng.standard_normal((COUNT, 1))),
        4: Rotor.from_rotation_vector(bivectors(rng, 3)).coefficients,
        8: Motor.from_twist(bivectors(rng, 6)).coefficients,
        12: Similarity.from_twist(bivectors(rng, 7)).coefficients,
    }
    # Second points lie apart from the first ones.
    return made.get(operand.width, bivectors(rng, operand.width) + float(operand.name == "q"))


def program(functions: list[tuple[str, Kernel]]) -> str:
    """Reads rows of all inputs, function by function, and writes rows of outputs."""
    lines = ["#include <cstdio>", '#include "versors.h"', "using namespace motorcade::versors;"]
    lines += ["template <class T> T get() {", "    T x;"]
    lines += ["    if (fread(&x, sizeof x, 1, stdin) != 1) throw 1;", "    return x;", "}"]
    lines += ["int main() {"]
    for name, kernel in functions:
        lines.append(f"    for (int i = 0; i < {COUNT}; ++i) {{")
        for operand in kernel.inputs:
            kind = "double" if operand.width == 1 else f"std::array<double, {operand.width}>"
            lines.append(f"        const auto {operand.name} = get<{kind}>();")
        arguments = ", ".join(operand.name for operand in kernel.inputs)
        lines.append(f"        const auto made = {name}({arguments});")
        lines += ["        fwrite(&made, sizeof made, 1, stdout);", "    }"]
    return "\n".join([*lines, "}"])


def test_header_agrees_with_kernels(rng: np.random.Generator, tmp_path: Path) -> None:
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("needs g++")
    source, made = tmp_path / "all.cpp", tmp_path / "all"
    source.write_text(program(BATCHED))
    flags = ["-std=c++17", "-O1", "-Wall", "-Werror", f"-I{GENERATED / 'cpp'}"]
    subprocess.run([compiler, *flags, str(source), "-o", str(made)], check=True)
    given = [[rows_of(operand, rng) for operand in kernel.inputs] for _, kernel in BATCHED]
    sent = b"".join(np.concatenate(rows, axis=1).tobytes() for rows in given)
    done = subprocess.run([str(made)], input=sent, capture_output=True, check=True).stdout
    read = np.frombuffer(done)
    for (_, kernel), rows in zip(BATCHED, given, strict=True):
        (output,) = kernel.outputs
        size = COUNT * output.width
        found, read = read[:size].reshape(COUNT, output.width), read[size:]
        expected = np.empty_like(found)
        function(kernel.name)(*rows, expected)
        largest = np.maximum(1.0, np.abs(expected).max(axis=1, keepdims=True))
        assert np.abs((found - expected) / largest).max() < 1e-13, kernel.name
    assert read.size == 0


def choices(precision: object, x: list, y: list) -> list[list]:
    """Two values by one condition, one of them needed by a choice that comes after."""
    import casadi as ca

    near = x[0] < 1
    first = ca.if_else(near, ca.sin(ca.cos(ca.exp(ca.sin(x[0])))), y[0])
    second = ca.if_else(near, ca.cos(ca.exp(ca.cos(x[0]) + y[0])) * y[0], x[0])
    return [[first, second, ca.if_else(near, ca.exp(ca.sin(ca.cos(ca.sin(first)))), 2)]]


def test_branches_hold_what_one_side_alone_needs() -> None:
    inputs = Operand("x", ("x",)), Operand("y", ("y",))
    kernel = Kernel("k", "g", inputs, (Operand("out", ("a", "b", "c")),), choices)
    tape = kernel.tape(DOUBLE)
    branches = [item for item in branched(tape) if isinstance(item, Branch)]
    assert [len(branch.choices) for branch in branches] == [2, 1]
    inside = {tape.nodes[k].op for k in branches[0].chosen if isinstance(k, int)}
    assert {"sin", "cos", "exp"} <= inside
    outside = [tape.nodes[k].op for k in branched(tape) if isinstance(k, int)]
    assert "exp" not in outside
