"""Elementary functions for loops: within two roundings, SIMD code, and NaN where there is none."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from motorcade.ga.codegen.passes.rebuild import with_unlike_rows
from motorcade.ga.codegen.precision import DOUBLE, PRECISIONS, Precision
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets import c, c_batch
from motorcade.ga.script import parse

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc here")

FLAGS = ["-std=c11", "-O3", "-fno-math-errno", "-fno-trapping-math"]
SCRIPT = """
?a = sin(x) + cos(x)*e1 + tan(x)*e2 + exp(y)*e3 + log(z)*e0 + atan(z)*einf;
?b = asin(u) + acos(u)*e1 + atan2(u, v)*e2 + min(u, v)*e3 + max(u, v)*e0;
"""
INPUTS = ("x", "y", "z", "u", "v")
EXACT = {
    "a": (mp.sin, mp.cos, mp.tan, mp.exp, mp.log, mp.atan),
    "b": (mp.asin, mp.acos, mp.atan2, min, max),
}


def looped(precision: Precision, inputs: np.ndarray, folder: Path) -> np.ndarray:
    """The components of both outputs ``(11, rows)`` at inputs ``(5, rows)``."""
    program = compile_script(parse(SCRIPT), "several")
    for name, text in c_batch.write(program, precision).items():
        (folder / name).write_text(text)
    library = folder / f"several_{precision.suffix}.so"
    subprocess.run(
        ["gcc", *FLAGS, "-shared", "-fPIC", str(folder / "several.c"), "-lm", "-o", str(library)],
        check=True,
    )
    out = np.empty((11, inputs.shape[1]), precision.numpy)
    pointers = [ctypes.c_void_p(row.ctypes.data) for row in (*inputs, *out)]
    ctypes.CDLL(str(library)).several(ctypes.c_size_t(inputs.shape[1]), *pointers)
    return out


@pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: p.numpy)
def test_functions_are_within_two_roundings(precision: Precision, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    count, small = 600, precision.bits == 24
    sizes = 10.0 ** rng.uniform(-6, 3.4 if small else 7, count)
    inputs = np.stack([
        rng.choice([-1.0, 1.0], count) * sizes,
        rng.uniform(-80, 80, count) if small else rng.uniform(-700, 700, count),
        10.0 ** rng.uniform(-37 if small else -300, 37 if small else 300, count),
        rng.choice([-1.0, 1.0], count) * (1 - 10.0 ** rng.uniform(-6, 0, count)),
        rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-3, 3, count),
    ]).astype(precision.numpy)  # fmt: skip
    inputs[:4, :8] = np.array([0.0, 1.0, -1.0, 0.5, 1e-30, -0.5, 0.25, -0.25])
    inputs[2, :8] = np.array([1.0, 2.0, 0.5, 1.5, 1e-38, 1e-30, 0.99, 1.01])
    made = iter(looped(precision, inputs, tmp_path))
    x, y, z, u, v = ([mp.mpf(float(value)) for value in row] for row in inputs)
    given = {"a": (x, x, x, y, z, z), "b": (u, u, (u, v), (u, v), (u, v))}
    # Components come by grade, then in the order of the basis, as they are written above.
    with mp.workdps(50):
        for output, functions in EXACT.items():
            for function, arguments in zip(functions, given[output], strict=True):
                rows = zip(*arguments, strict=True) if isinstance(arguments, tuple) else (
                    (one,) for one in arguments
                )  # fmt: skip
                for value, row in zip(next(made), rows, strict=True):
                    exact = function(*row)
                    size = max(abs(exact), mp.mpf(float(np.finfo(precision.numpy).tiny)))
                    off = abs(mp.mpf(float(value)) - exact) / size
                    assert off <= 2 * precision.epsilon, (function.__name__, row, value)


@pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: p.numpy)
def test_what_is_no_number_says_so(precision: Precision, tmp_path: Path) -> None:
    inputs = np.ones((5, 6), precision.numpy)
    inputs[0, :3] = np.inf, -np.inf, np.nan
    inputs[1, :5] = np.inf, -np.inf, np.nan, 1e4, -1e4
    inputs[2, :5] = np.inf, 0.0, np.nan, -1.0, -np.inf
    inputs[3, :3] = 1.5, -1.5, np.nan
    made = looped(precision, inputs, tmp_path)
    with np.errstate(all="ignore"):
        expected = [np.sin, np.cos, np.tan]
        for row, function in zip(made[:3], expected, strict=True):
            np.testing.assert_allclose(row, function(inputs[0]), rtol=1e-6)
        np.testing.assert_allclose(made[3], np.exp(inputs[1]), rtol=1e-6)
        np.testing.assert_allclose(made[4], np.log(inputs[2]), rtol=1e-6)
        np.testing.assert_allclose(made[6], np.arcsin(inputs[3]), rtol=1e-6)
        np.testing.assert_allclose(made[7], np.arccos(inputs[3]), rtol=1e-6, atol=1e-6)


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: p.numpy)
@pytest.mark.parametrize("count", [0, 1, 15, 16, 17, 54])
def test_every_row_is_computed_alike_wherever_it_stands(
    precision: Precision, count: int, tmp_path: Path
) -> None:
    rng = np.random.default_rng(count)
    inputs = rng.uniform(0.1, 0.9, (5, 64)).astype(precision.numpy)
    whole = looped(precision, inputs, tmp_path)
    part = looped(precision, np.ascontiguousarray(inputs[:, :count]), tmp_path)
    np.testing.assert_array_equal(part, whole[:, :count])


def test_loops_of_functions_become_simd_code(tmp_path: Path) -> None:
    program = compile_script(parse(SCRIPT), "several")
    source = tmp_path / "several.c"
    source.write_text(c_batch.write(program, DOUBLE)["several.c"])
    level = ["-march=x86-64-v3"] if "x86" in _told(["gcc", "-v"]) else []
    told = _told(
        ["gcc", *FLAGS, *level, "-fopt-info-vec", "-c", str(source), "-o", str(tmp_path / "a.o")]
    )
    assert "loop vectorized" in told


def _told(command: list[str]) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stderr


def test_rows_of_plain_c_are_unlike_in_plain_arithmetic_alone() -> None:
    plain = compile_script(parse("?r = (a*e1 + b*e2 + c*e3)*(d*e1 + f*e2 + g*e3);"), "plain").tape
    assert with_unlike_rows(plain) is not plain
    angle = compile_script(parse("?r = atan2(a*b + c*d + f*g, a)*(a + b + c)*e1;"), "angle")
    assert with_unlike_rows(angle.tape) is angle.tape


def test_plain_c_carries_the_polynomials_of_inverse_tangents_and_keeps_sines_of_any_angle() -> None:
    program = compile_script(parse("?r = atan2(sin(a), b);"), "turn")
    text = c.write(program, DOUBLE)["turn.c"]
    assert "motorcade_atan2(sin(a), b)" in text
    assert text.count("static inline double motorcade_atan2(") == 1
    assert "motorcade_sin(" not in text
