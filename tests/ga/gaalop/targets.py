"""Scripts as code of every target, run on the numbers of a case.

A runner takes programs and gives the outputs of each, or what went wrong. To add a target is to add
a runner to `RUNNERS`.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.strategies import product, table
from motorcade.ga.codegen.targets import TARGETS
from tests.ga.gaalop.scripts import Case, Values

Results = dict[str, "Values | str"]
COMPILER = shutil.which("gcc") or shutil.which("cc")
_WRITTEN_AT_ONCE = 64


@dataclass(frozen=True)
class Prepared:
    """A case and its program, whose name is one that every language takes."""

    case: Case
    program: Program


def prepared(case: Case) -> Prepared | str:
    """The program of a case, or why it has none."""
    try:
        return Prepared(case, compile_script(case.script, f"run_{case.name}", case.algebra))
    except ValueError as refused:
        return f"{type(refused).__name__}: {str(refused).splitlines()[0]}"


def named(program: Program, rows: dict[str, Any]) -> Values:
    """Rows of coefficients by output, as coefficients by blade."""
    return {
        operand.name: {
            blade: float(value)
            for blade, value in zip(operand.components, rows.get(operand.name, ()), strict=True)
        }
        for operand in program.tape.outputs
    }


def in_python(target: str) -> Callable[[list[Prepared], Path], Results]:
    """A runner of a target that writes a Python module."""

    def run(programs: list[Prepared], folder: Path) -> Results:
        made: Results = {}
        for one in programs:
            (text,) = TARGETS[target](one.program, None).values()
            module = ModuleType(one.program.name)
            exec(compile(text, one.program.name, "exec"), module.__dict__)
            function = getattr(module, one.program.name)
            made[one.case.name] = _READERS[target](one, function)
        return made

    return run


def _of_numpy(one: Prepared, function: Any) -> Values:
    found = function(**one.case.given)
    return {name: {b: float(v) for b, v in x.items()} for name, x in found.items()}


def _of_casadi(one: Prepared, function: Any) -> Values:
    found = function().call(dict(one.case.given))  # by keyword no input may be called self
    return named(one.program, {name: np.array(x).ravel() for name, x in found.items()})


_READERS: dict[str, Callable[[Prepared, Any], Values]] = {
    "numpy": _of_numpy,
    "casadi": _of_casadi,
}


def in_c(write: Callable[[Prepared], dict[str, str]]) -> Callable[[list[Prepared], Path], Results]:
    """A runner of C: all programs in one library, by one call of the compiler."""

    def run(programs: list[Prepared], folder: Path) -> Results:
        if COMPILER is None:
            return {one.case.name: "no C compiler" for one in programs}
        made: Results = {}
        for one in programs:
            try:
                files = write(one)
            except ValueError as refused:
                made[one.case.name] = str(refused)
                continue
            for file, text in files.items():
                (folder / file).write_text(text)
        library = folder / "all.so"
        sources = sorted(str(path) for path in folder.glob("*.c"))
        build = [COMPILER, "-std=c99", "-O1", "-shared", "-fPIC", *sources, "-lm"]
        subprocess.run([*build, "-o", str(library)], check=True)
        functions = ctypes.CDLL(str(library))
        written = [one for one in programs if one.case.name not in made]
        return made | {one.case.name: _called(functions, one) for one in written}

    return run


def _called(library: ctypes.CDLL, one: Prepared) -> Values:
    function = getattr(library, one.program.name)
    outputs = [operand for operand in one.program.tape.outputs if operand.components]
    real = ctypes.c_double
    given = [one.case.given[operand.name] for operand in one.program.tape.inputs]
    function.argtypes = [real] * len(given) + [ctypes.POINTER(real)] * len(outputs)
    function.restype = None
    made = {operand.name: (real * operand.width)() for operand in outputs}
    function(*given, *made.values())
    return named(one.program, {name: list(row) for name, row in made.items()})


def in_glsl(programs: list[Prepared], folder: Path) -> Results:
    """A runner of GLSL, in single precision, by transform feedback."""
    try:
        import moderngl

        context = moderngl.create_standalone_context(backend="egl", require=330)
    except Exception as missing:
        return {one.case.name: f"no OpenGL: {missing}" for one in programs}
    context.simple_framebuffer((1, 1)).use()
    made: Results = {one.case.name: _shaded(context, one) for one in programs}
    context.release()
    return made


def _shaded(context: Any, one: Prepared) -> Values:
    """The outputs of a shader, whose inputs are written into it as numbers."""
    (function,) = TARGETS["glsl"](one.program, None).values()
    outputs = [operand for operand in one.program.tape.outputs if operand.components]
    places = iter([f"out_{o.name}[{k}]" for o in outputs for k in range(o.width)])
    values: list[float] = []
    given = [np.float32(one.case.given[o.name]) for o in one.program.tape.inputs]
    while chosen := list(islice(places, _WRITTEN_AT_ONCE)):
        names = [f"made{k}" for k in range(len(chosen))]
        shader = ["#version 330 core", function, "in float unused;"]
        shader += [f"out float {name};" for name in names]
        shader += ["void main() {", "gl_Position = vec4(unused);"]
        shader += [f"float out_{o.name}[{o.width}];" for o in outputs]
        arguments = [*map(_literal, given), *(f"out_{o.name}" for o in outputs)]
        shader.append(f"{one.program.name}({', '.join(arguments)});")
        shader += [f"{name} = {place};" for name, place in zip(names, chosen, strict=True)]
        compiled = context.program(vertex_shader="\n".join([*shader, "}"]), varyings=names)
        result = context.buffer(reserve=4 * len(chosen))
        points = context.buffer(np.zeros(1, np.float32).tobytes())
        vertices = context.vertex_array(compiled, [(points, "f", "unused")])
        vertices.transform(result, 0, vertices=1)
        values += np.frombuffer(result.read(), np.float32).tolist()
    rest = iter(values)
    return named(one.program, {o.name: list(islice(rest, o.width)) for o in outputs})


def _literal(value: np.float32) -> str:
    return f"uintBitsToFloat({int(value.view(np.uint32))}u)"


def _strategy(write: Any) -> Callable[[Prepared], dict[str, str]]:
    return lambda one: write(one.case.script, one.program, DOUBLE)


# Runners, and the largest difference beside the largest coefficient that is rounding.
RUNNERS: dict[str, tuple[Callable[[list[Prepared], Path], Results], float]] = {
    "c": (in_c(lambda one: TARGETS["c"](one.program, DOUBLE)), 1e-9),
    "c --strategy product": (in_c(_strategy(product.write)), 1e-9),
    "c --strategy table": (in_c(_strategy(table.write)), 1e-9),
    "numpy": (in_python("numpy"), 1e-9),
    "casadi": (in_python("casadi"), 1e-9),
    "glsl": (in_glsl, 2e-4),
}
