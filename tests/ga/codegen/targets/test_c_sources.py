"""A script as C compiles without a warning, as C99 to C++17, and says what its evaluation says."""

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.precision import DOUBLE, SINGLE, Precision
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets import c, c_batch
from motorcade.ga.script import parse

COMPILER, CXX = shutil.which("gcc"), shutil.which("g++")
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-pedantic"]
BOUNDS = [(DOUBLE, 1e-12), (SINGLE, 1e-5)]

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no gcc here")


def run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stderr


def written(target: Any, program: Any, precision: Precision | None, folder: Path) -> Path:
    for file, text in target.write(program, precision).items():
        (folder / file).write_text(text)
    return folder / f"{program.name}.c"


def built(source: Path, flags: list[str]) -> Any:
    library = source.with_suffix(".so")
    run(["gcc", *flags, *WARNINGS, "-shared", "-fPIC", str(source), "-lm", "-o", str(library)])
    return getattr(ctypes.CDLL(str(library)), source.stem)


@pytest.mark.quick_every(3)
@pytest.mark.parametrize(("precision", "bound"), BOUNDS, ids=["float64", "float32"])
def test_a_function_of_scalars_agrees_with_evaluation(
    script: str, precision: Precision, bound: float, cases: Any, tmp_path: Path
) -> None:
    case = cases(script, precision.numpy)
    call = built(written(c, case.program, precision, tmp_path), ["-std=c11", "-O2"])
    real = ctypes.c_double if precision is DOUBLE else ctypes.c_float
    widths = [o.width for o in case.program.tape.outputs if o.width]
    out = np.full((sum(widths), len(next(iter(case.inputs.values())))), np.nan, precision.numpy)
    buffers = [(real * width)() for width in widths]
    call.argtypes = [real] * len(case.inputs) + [real * width for width in widths]
    call.restype = None
    rows = np.stack(list(case.inputs.values()), axis=1).tolist()
    for i, row in enumerate(rows):
        call(*row, *buffers)
        out[:, i] = [value for buffer in buffers for value in buffer]
    case.checked(case.by_place(out), bound)


@pytest.mark.quick_every(3)
@pytest.mark.parametrize(("precision", "bound"), BOUNDS, ids=["float64", "float32"])
def test_a_loop_over_rows_agrees_with_evaluation(
    script: str, precision: Precision, bound: float, cases: Any, tmp_path: Path
) -> None:
    case = cases(script, precision.numpy)
    call = built(written(c_batch, case.program, precision, tmp_path), ["-std=c11", "-O2"])
    rows = len(next(iter(case.inputs.values())))
    count = sum(o.width for o in case.program.tape.outputs)
    out = np.full((count, rows + 1), np.nan, precision.numpy)
    pointers = [a.ctypes.data for a in (*case.inputs.values(), *out)]
    call.restype = None
    call(ctypes.c_size_t(rows), *map(ctypes.c_void_p, pointers))
    assert np.isnan(out[:, rows]).all(), "nothing is written behind the last row"
    case.checked(case.by_place(out[:, :rows]), bound)


@pytest.mark.parametrize("target", [c, c_batch], ids=["c", "c-batch"])
@pytest.mark.parametrize("standard", ["c99", "c11", "gnu17"])
def test_sources_compile_in_every_standard(
    target: Any, standard: str, script: str, cases: Any, tmp_path: Path
) -> None:
    source = written(target, cases(script, "float64").program, SINGLE, tmp_path)
    flags = ["-Wmissing-prototypes", "-Wconversion", "-fsyntax-only"]
    run(["gcc", f"-std={standard}", *WARNINGS, *flags, str(source)])


@pytest.mark.skipif(CXX is None, reason="no g++ here")
@pytest.mark.parametrize("target", [c, c_batch], ids=["c", "c-batch"])
def test_cpp_calls_it_by_its_header(target: Any, tmp_path: Path) -> None:
    program = compile_script(parse("?a = 2*x + y*e1;\n?zero = z - z;"), "pair")
    source = written(target, program, None, tmp_path)
    loop = "pair(1, &in[0], &in[1], &in[2], &out[0], &out[1]);"
    use = loop if target is c_batch else "pair(in[0], in[1], in[2], out);"
    (tmp_path / "main.cpp").write_text(
        '#include "pair.h"\n#include "pair.h"\n#include <cstdio>\n'
        "int main() { const double in[3] = {2, 3, 5}; double out[2];\n"
        f'{use} std::printf("%g %g", out[0], out[1]); }}\n'
    )
    run(["gcc", "-std=c99", *WARNINGS, "-c", str(source), "-o", str(tmp_path / "pair.o")])
    made = str(tmp_path / "main")
    main = str(tmp_path / "main.cpp")
    run(["g++", "-std=c++17", *WARNINGS, main, str(tmp_path / "pair.o"), "-o", made])
    told = subprocess.run([made], capture_output=True, text=True, check=True).stdout
    assert told == "4 3"


def test_the_header_and_the_source_declare_the_same_function(tmp_path: Path) -> None:
    program = compile_script(parse("?a = x*e1;"), "same")
    for target in (c, c_batch):
        source = written(target, program, SINGLE, tmp_path)
        both = tmp_path / "both.c"
        both.write_text(f'#include "same.h"\n#include "{source.name}"\n')
        run(["gcc", "-std=c11", *WARNINGS, "-fsyntax-only", str(both)])


@pytest.mark.parametrize("precision", [DOUBLE, SINGLE], ids=lambda p: p.numpy)
@pytest.mark.parametrize(
    "text",
    [
        "//#pragma algebra ega3\nR = w + x*e1^e2 + y*e2^e3 + z*e1^e3;\n?out = R*(a*e1 + b*e2)*~R;",
        "?p = createPoint(x, y, z)*sqrt(x*x + 1)/(1 + y*y) + abs(z);",
        "?p = step(x)*e1 + abs(y)/(2 + x*x)*e2;",
    ],
    ids=["rotor", "roots and quotients", "choices"],
)
def test_loops_without_calls_become_simd_code(
    text: str, precision: Precision, tmp_path: Path
) -> None:
    source = written(c_batch, compile_script(parse(text), "loop"), precision, tmp_path)
    flags = ["-O3", "-march=x86-64-v3", "-fno-math-errno", "-fno-trapping-math", "-fopt-info-vec"]
    if "x86" not in run(["gcc", "-v"]):
        flags.remove("-march=x86-64-v3")
    told = run(["gcc", "-std=c11", *flags, "-c", str(source), "-o", str(tmp_path / "loop.o")])
    assert "loop vectorized" in told


def test_documentation_lists_inputs_outputs_and_blades_in_order() -> None:
    program = compile_script(parse("?b = y*e1^einf + x*e2;\n?a = x - x;"), "order")
    for text in c.write(program, None).values():
        told = text.split("*/")[0]
        assert "Inputs, in this order: y x." in told
        assert told.index("b: e2 e1^einf") < told.index("a: none, it is zero")


def test_numbers_too_large_for_float_are_refused() -> None:
    program = compile_script(parse("?a = 1e100*x;"), "large")
    assert "1e+100" in c.write(program, DOUBLE)["large.c"]
    with pytest.raises(ValueError, match=r"numbers that float32 can hold, got 1e\+100"):
        c.write(program, SINGLE)
