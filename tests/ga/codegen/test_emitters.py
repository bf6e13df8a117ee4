"""A tape means the same in C, in NumPy and in CasADi, and says what the definition says."""

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")
pytest.importorskip("mpmath", reason="mpmath, which only the generator needs, is not installed")

import casadi as ca

from motorcade.ga.codegen.__main__ import GENERATED
from motorcade.ga.codegen.library_kernels.kernel import Kernel, collected
from motorcade.ga.codegen.precision import DOUBLE, PRECISIONS, SINGLE, Precision
from motorcade.ga.codegen.recording import trace
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets import c_batch
from motorcade.ga.codegen.targets import numpy as numpy_target
from motorcade.ga.kernels.definitions.functions import fitted, horner

COMPILER = shutil.which("gcc") or shutil.which("cc")
WARNINGS = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-fno-math-errno"]
X, Y, OUT = (Operand(name, tuple("abcd")[:n]) for name, n in (("x", 3), ("y", 1), ("out", 4)))


def everything(precision: Precision, x: Any, y: Any) -> Sequence[Sequence[Any]]:
    """Every operation that the emitters know, with terms that repeat and signs that move."""
    a, b, c, t = x[0], x[1], x[2], y[0]
    chosen = ca.if_else(ca.logic_and(a < b, ca.logic_not(c <= t)), -a * b, 2.0)
    either = ca.if_else(ca.logic_or(a == b, b != c), ca.fmin(a, c), -1.5)
    root = ca.sqrt(ca.fabs(a * b)) / (1 + ca.fmax(b, t) ** 2)
    return [
        [
            chosen - (a * b + c * t + a * b + c * t),
            either / root + c / root,
            ca.floor(a * 3 + 0.5) - (b - (c - t)),
            -(-1 * a) - a + 1 / (c * c + 1) + precision.epsilon,
        ]
    ]


KERNEL = Kernel("everything", "tests", (X, Y), (OUT,), everything)


@pytest.fixture
def samples(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return rng.uniform(-2, 2, (64, 3)), rng.uniform(-2, 2, 64)


def witness(x: np.ndarray, y: np.ndarray, precision: Precision) -> np.ndarray:
    columns = KERNEL.casadi(precision)(x.T, y[None])
    return np.array(columns).T


@pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: p.numpy)
def test_numpy_code_computes_what_casadi_computes(
    precision: Precision, samples: tuple[np.ndarray, np.ndarray]
) -> None:
    names: dict[str, Any] = {}
    exec(numpy_target.library_source("tests", [KERNEL]), names)
    x, y = (part.astype(precision.numpy) for part in samples)
    made = np.stack(names[f"everything_{precision.suffix}"](x, y[:, None]), axis=-1)
    assert made.dtype == precision.numpy
    expected = witness(x, y, precision)
    np.testing.assert_allclose(
        made, expected, rtol=64 * precision.epsilon, atol=64 * precision.epsilon
    )


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: p.numpy)
def test_c_code_compiles_without_warnings_and_computes_what_casadi_computes(
    precision: Precision, samples: tuple[np.ndarray, np.ndarray], tmp_path: Path
) -> None:
    (tmp_path / "tests.c").write_text(c_batch.library_source("tests", [KERNEL]))
    library = tmp_path / "tests.so"
    build(["-shared", "-fPIC", str(tmp_path / "tests.c"), "-lm", "-o", str(library)])
    entry = getattr(ctypes.CDLL(str(library)), f"motorcade_everything_{precision.suffix}")
    x, y = (np.ascontiguousarray(part.T.astype(precision.numpy)) for part in samples)
    out = np.zeros((4, 64), precision.numpy)
    pointers, steps = ctypes.c_void_p * 2, ctypes.c_ssize_t * 2
    entry(
        pointers(x.ctypes.data, y.ctypes.data),
        steps(64, 0),
        pointers(out.ctypes.data),
        steps(64),
        ctypes.c_size_t(4),
    )
    expected = witness(x.T, y, precision)
    np.testing.assert_allclose(
        out.T, expected, rtol=64 * precision.epsilon, atol=64 * precision.epsilon
    )


def build(arguments: list[str]) -> None:
    assert COMPILER is not None
    command = [COMPILER, *WARNINGS, "-I", str(GENERATED.parent / "native"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.quick_every(4)
@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("path", sorted(GENERATED.glob("c/*.c")), ids=lambda path: path.name)
def test_generated_c_compiles_without_warnings(path: Path, tmp_path: Path) -> None:
    build(["-c", str(path), "-o", str(tmp_path / "kernel.o")])


def test_like_terms_are_added_up_once() -> None:
    def twice(x: Any) -> list[list[Any]]:
        return [[x[0] * x[1] + x[2] * x[0] + x[1] * x[0] + x[0] * x[2]]]

    tape = collected(trace("f", (X,), (Y,), twice))
    assert tape.operations() == {"add": 1, "mul": 3}
    assert "keep" not in KERNEL.tape(DOUBLE).operations(), "choices are selects, not sums of halves"


def test_quotients_by_one_number_share_its_reciprocal() -> None:
    tape = trace("f", (X,), (X,), lambda x: [[x[0] / x[2], x[1] / x[2], x[0] * x[1] / x[2]]])
    assert tape.operations()["div"] == 1


def test_operations_without_a_counterpart_are_refused() -> None:
    with pytest.raises(ValueError, match="expected operations that the emitters know, got OP_ERF"):
        trace("f", (Y,), (Y,), lambda y: [[ca.erf(y[0])]])
    with pytest.raises(ValueError, match=r"expected outputs of \[1\] components, got \[2\]"):
        trace("f", (Y,), (Y,), lambda y: [[y[0], y[0]]])


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE], ids=lambda p: p.numpy)
def test_fits_stay_within_their_error(precision: Precision) -> None:
    import mpmath as mp

    error = precision.epsilon / 16
    coefficients = fitted(mp.exp, 0.0, 1.0, error)
    x = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(horner(coefficients, x), np.exp(x), atol=error + 1e-15)


def test_functions_that_are_not_smooth_are_refused() -> None:
    import mpmath as mp

    with pytest.raises(ValueError, match="polynomial of 40 terms"):
        fitted(mp.sqrt, 0.0, 1.0, 1e-12)
