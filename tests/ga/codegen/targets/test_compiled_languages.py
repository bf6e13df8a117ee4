"""Rust, C++ and JavaScript are compiled and run on every script, and agree with its evaluation."""

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.precision import DOUBLE, SINGLE, Precision
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.targets import cpp, javascript, rust
from motorcade.ga.script import parse
from tests.ga.codegen.targets.conftest import scripts

BOUNDS = [(DOUBLE, 1e-12), (SINGLE, 1e-5)]
PRECISIONS = pytest.mark.parametrize(("precision", "bound"), BOUNDS, ids=["float64", "float32"])
WARNINGS = ["-std=c++17", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"]
needs_rust = pytest.mark.skipif(shutil.which("rustc") is None, reason="no rustc here")
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="no node here")
needs_cxx = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++ here")


def run(command: list[Any], folder: Path) -> str:
    done = subprocess.run(
        list(map(str, command)), cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def arrays_of(program: Program) -> list[str]:
    return [o.name for o in program.tape.outputs if o.width]


def laid_out(cases: Any, target: Any, precision: Precision, folder: Path) -> list[Any]:
    """All scripts as code and their inputs, a row after the other, in a folder."""
    made = [cases(name, precision.numpy) for name in scripts()]
    for case in made:
        for file, text in target.write(case.program, precision).items():
            (folder / file).write_text(text)
        np.stack(list(case.inputs.values()), axis=1).tofile(folder / f"{case.program.name}.in")
    return made


def checked(made: list[Any], precision: Precision, bound: float, folder: Path) -> None:
    for case in made:
        width = sum(o.width for o in case.program.tape.outputs)
        out = np.fromfile(folder / f"{case.program.name}.out", precision.numpy).reshape(-1, width)
        case.checked(case.by_place(out.T), bound)


@needs_rust
@PRECISIONS
def test_rust_agrees_with_evaluation(
    precision: Precision, bound: float, cases: Any, tmp_path: Path
) -> None:
    made = laid_out(cases, rust, precision, tmp_path)
    kind = precision.suffix
    lines = ["#![deny(warnings)]", *(f"mod {case.program.name};" for case in made), "fn main() {"]
    for case in made:
        name, given, arrays = case.program.name, len(case.inputs), arrays_of(case.program)
        read = ", ".join(f"v[{i}]" for i in range(given))
        lines += [
            f'let read = std::fs::read("{name}.in").unwrap();',
            "let mut out: Vec<u8> = Vec::new();",
            f"for row in read.chunks_exact({given} * std::mem::size_of::<{kind}>()) {{",
            f"let v: Vec<{kind}> = row.chunks_exact(std::mem::size_of::<{kind}>())",
            f".map(|b| {kind}::from_le_bytes(b.try_into().unwrap())).collect();",
            f"let made = {name}::{name}({read});",
        ]
        parts = ["made"] if len(arrays) == 1 else [f"made.{i}" for i in range(len(arrays))]
        lines += [
            f"for x in {part} {{ out.extend_from_slice(&x.to_le_bytes()); }}" for part in parts
        ]
        lines += ["}", f'std::fs::write("{name}.out", out).unwrap();']
    (tmp_path / "main.rs").write_text("\n".join([*lines, "}"]))
    run(["rustc", "--edition=2021", "-Copt-level=1", "main.rs", "-o", "main"], tmp_path)
    run([tmp_path / "main"], tmp_path)
    checked(made, precision, bound, tmp_path)


@needs_cxx
@PRECISIONS
def test_cpp_agrees_with_evaluation(
    precision: Precision, bound: float, cases: Any, tmp_path: Path
) -> None:
    made = laid_out(cases, cpp, precision, tmp_path)
    lines = [f'#include "{case.program.name}.hpp"' for case in made]
    lines += ["#include <cstdio>", "int main() {"]
    for case in made:
        name, given, arrays = case.program.name, len(case.inputs), arrays_of(case.program)
        read = ", ".join(f"v[{i}]" for i in range(given))
        bound_to = f"[{', '.join(f'a{i}' for i in range(len(arrays)))}]"
        lines += [
            f'{{ FILE *in = std::fopen("{name}.in", "rb"), *out = std::fopen("{name}.out", "wb");',
            f"{precision.c} v[{given}];",
            "while (std::fread(v, sizeof v, 1, in) == 1) {",
            f"const auto {'a0' if len(arrays) == 1 else bound_to} = {name}({read});",
            *(f"std::fwrite(a{i}.data(), sizeof a{i}, 1, out);" for i in range(len(arrays))),
            "} std::fclose(in); std::fclose(out); }",
        ]
    (tmp_path / "main.cpp").write_text("\n".join([*lines, "}"]))
    run(["g++", *WARNINGS, "main.cpp", "-o", "main"], tmp_path)
    run([tmp_path / "main"], tmp_path)
    checked(made, precision, bound, tmp_path)


@needs_node
def test_javascript_agrees_with_evaluation(cases: Any, tmp_path: Path) -> None:
    made = laid_out(cases, javascript, DOUBLE, tmp_path)
    lines = ['import { readFileSync, writeFileSync } from "node:fs";']
    for case in made:
        name, given = case.program.name, len(case.inputs)
        lines += [
            f'import {{ {name} }} from "./{name}.mjs";',
            f'{{ const read = new Float64Array(readFileSync("{name}.in").buffer), out = [];',
            f"for (let i = 0; i < read.length; i += {given})",
            f"out.push(...Object.values({name}(...read.subarray(i, i + {given}))).flat());",
            f'writeFileSync("{name}.out", Buffer.from(new Float64Array(out).buffer)); }}',
        ]
    (tmp_path / "main.mjs").write_text("\n".join(lines))
    run(["node", "main.mjs"], tmp_path)
    checked(made, DOUBLE, 1e-12, tmp_path)


HOSTILE = "x = x + 1;\n?x;\n?__proto__ = 2*x;\n?type = 3*x*e1 - 3*x*e1;\n?in = x;\n?let = y*e1;"
LOGIC = "?a = step(x)*y + sign(y)*3 - step(step(x) + step(y) - 1.5);"
PLAIN = {"hostile": HOSTILE, "logic": LOGIC, "constant": "?pair = 2*e1 + 0.1*e2;\n?one = 1;"}


@needs_node
def test_names_that_javascript_keeps_are_fields_all_the_same(tmp_path: Path) -> None:
    answered = "console.log(JSON.stringify(Object.entries(scene(1, 5))));"
    (text,) = javascript.write(compile_script(parse(HOSTILE), "scene"), None).values()
    (tmp_path / "main.mjs").write_text(text + answered)
    told = run(["node", "main.mjs"], tmp_path).strip()
    assert told == '[["x",[2]],["__proto__",[4]],["type",[]],["in",[2]],["let",[5]]]'


@pytest.mark.parametrize("plain", list(PLAIN))
@needs_rust
def test_rust_takes_any_outputs(plain: str, tmp_path: Path) -> None:
    program = compile_script(parse(PLAIN[plain]), "scene")
    values = ["1.0", "-2.0"][: len(program.tape.inputs)]
    (text,) = rust.write(program, None).values()
    main = f'fn main() {{ println!("{{:?}}", scene({", ".join(values)})); }}'
    (tmp_path / "main.rs").write_text(f"#![deny(warnings)]\n{text}\n{main}")
    run(["rustc", "--edition=2021", "main.rs", "-o", "main"], tmp_path)
    expected = {
        "hostile": "([2.0], [4.0], [2.0], [-2.0])",
        "logic": "[-5.0]",
        "constant": "([2.0, 0.1], [1.0])",
    }
    assert run([tmp_path / "main"], tmp_path).strip() == expected[plain]


@pytest.mark.parametrize("plain", list(PLAIN))
@needs_cxx
def test_cpp_takes_any_outputs(plain: str, tmp_path: Path) -> None:
    (text,) = cpp.write(compile_script(parse(PLAIN[plain]), "scene"), SINGLE).values()
    (tmp_path / "scene.hpp").write_text(text)
    (tmp_path / "main.cpp").write_text('#include "scene.hpp"\n#include "scene.hpp"\n')
    run(["g++", *WARNINGS, "-fsyntax-only", "main.cpp"], tmp_path)


def test_an_output_without_blades_alone_is_no_array() -> None:
    program = compile_script(parse("?zero = x - x;"), "gone")
    told: dict[str, Callable[..., dict[str, str]]] = {
        "pub fn gone(x: f64) -> ()": rust.write,
        "inline std::tuple<> gone(double x)": cpp.write,
        "zero: [],": javascript.write,
    }
    for expected, write in told.items():
        (text,) = write(program, None).values()
        assert expected in text


def test_javascript_is_in_double_precision_only() -> None:
    with pytest.raises(ValueError, match="target javascript: expected precision float64, got"):
        javascript.write(compile_script(parse("?a = x;"), "one"), SINGLE)
