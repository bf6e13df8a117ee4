"""Runners of targets whose code is compiled or read by a tool of its own, where that is installed.

All programs go into one run of the tool, which writes the numbers of all outputs in their order.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from itertools import islice
from pathlib import Path
from typing import Any

from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.targets import TARGETS
from tests.ga.gaalop.targets import Prepared, Results, named


def in_javascript(programs: list[Prepared], folder: Path) -> Results:
    """A runner of JavaScript, by Node."""
    if shutil.which("node") is None:
        return {one.case.name: "no Node" for one in programs}
    lines = ["const made = [];"]
    for one in programs:
        name = _written(one, "javascript", folder)
        lines.insert(0, f'import {{ {name} }} from "./{name}.mjs";')
        lines.append(f"made.push(...Object.values({name}({_arguments(one)})).flat());")
    lines.append("console.log(JSON.stringify(made.map(String)));")
    (folder / "main.mjs").write_text("\n".join(lines))
    return _read(programs, json.loads(_output(["node", "main.mjs"], folder)))


def in_rust(programs: list[Prepared], folder: Path) -> Results:
    """A runner of Rust."""
    if shutil.which("rustc") is None:
        return {one.case.name: "no rustc" for one in programs}
    lines = ["fn main() {"]
    for one in programs:
        name = _written(one, "rust", folder)
        lines.insert(0, f"mod {name};")
        lines.append(f"let made = {name}::{name}({_arguments(one)});")
        for part in _parts(one, "made", "made.{}"):
            lines.append(f'for x in {part} {{ println!("{{:e}}", x); }}')
    (folder / "main.rs").write_text("\n".join([*lines, "}"]))
    _output(["rustc", "--edition=2021", "main.rs", "-o", "main"], folder)
    return _read(programs, _output([str(folder / "main")], folder).split())


def in_cpp(programs: list[Prepared], folder: Path) -> Results:
    """A runner of C++."""
    if shutil.which("g++") is None:
        return {one.case.name: "no g++" for one in programs}
    lines = ["#include <cstdio>", "int main() {"]
    for one in programs:
        name = _written(one, "cpp", folder)
        lines.insert(0, f'#include "{name}.hpp"')
        lines.append(f"{{ const auto made = {name}({_arguments(one)}); (void)made;")
        for part in _parts(one, "made", "std::get<{}>(made)"):
            lines.append(f'for (double x : {part}) std::printf("%.17g\\n", x);')
        lines.append("}")
    (folder / "main.cpp").write_text("\n".join([*lines, "}"]))
    _output(["g++", "-std=c++17", "main.cpp", "-o", "main"], folder)
    return _read(programs, _output([str(folder / "main")], folder).split())


def _written(one: Prepared, target: str, folder: Path) -> str:
    """The name of a program whose code has been written."""
    for file, text in TARGETS[target](one.program, DOUBLE).items():
        (folder / file).write_text(text)
    return one.program.name


def _arguments(one: Prepared) -> str:
    return ", ".join(f"{one.case.given[o.name]!r}" for o in one.program.tape.inputs)


def _parts(one: Prepared, alone: str, several: str) -> list[str]:
    """The arrays of a result: the result itself where there is one."""
    count = sum(bool(operand.components) for operand in one.program.tape.outputs)
    return [alone] if count == 1 else [several.format(k) for k in range(count)]


def _output(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return done.stdout


def _read(programs: list[Prepared], numbers: list[Any]) -> Results:
    """The outputs of all programs from their numbers in order."""
    rest = iter(numbers)
    return {
        one.case.name: named(
            one.program,
            {o.name: list(islice(rest, o.width)) for o in one.program.tape.outputs},
        )
        for one in programs
    }


LANGUAGES = {"cpp": in_cpp, "javascript": in_javascript, "rust": in_rust}
