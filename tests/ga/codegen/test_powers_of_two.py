"""Powers of two from the bits of numbers, and the functions of growth that stand on them."""

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
import mpmath

from motorcade.ga.codegen.__main__ import GENERATED
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.library_kernels.powers_of_two import exponent, power_of_two
from motorcade.ga.codegen.precision import PRECISIONS, SINGLE, Precision
from motorcade.ga.codegen.recording import trace
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.codegen.targets import c_batch
from motorcade.ga.codegen.targets import numpy as numpy_target
from motorcade.ga.kernels.definitions.similarities import hyperbolic, inverse_hyperbolic

COMPILER = shutil.which("gcc")
X, OUT = Operand("x", ("x",)), Operand("out", ("a", "b", "c"))
needs_gcc = pytest.mark.skipif(COMPILER is None, reason="no gcc")
precisions = pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: p.numpy)


def bits(precision: Precision, x: Any) -> Sequence[Sequence[Any]]:
    return [[exponent(ca.fabs(x[0])), power_of_two(ca.floor(x[0])), power_of_two(-ca.floor(x[0]))]]


def growth(precision: Precision, x: Any) -> Sequence[Sequence[Any]]:
    return [list(hyperbolic(precision, x[0]))]


def shrunk(precision: Precision, x: Any) -> Sequence[Sequence[Any]]:
    cosh, sinh, _ = hyperbolic(precision, x[0])
    return [[*inverse_hyperbolic(precision, cosh, sinh), 0.0]]


KERNELS = {
    f.__name__: Kernel(f.__name__, "tests", (X,), (OUT,), f, "-") for f in (bits, growth, shrunk)
}


@pytest.fixture(params=["numpy", pytest.param("c", marks=needs_gcc)])
def run(request: pytest.FixtureRequest, tmp_path: Path) -> Any:
    """Both languages: a kernel's outputs ``(n, 3)`` at numbers ``(n)``."""

    def in_numpy(kernel: Kernel, precision: Precision, x: np.ndarray) -> np.ndarray:
        names: dict[str, Any] = {}
        exec(numpy_target.library_source("tests", [kernel]), names)
        columns = names[f"{kernel.name}_{precision.suffix}"](x[:, None])
        return np.stack([np.broadcast_to(column, x.shape) for column in columns], axis=1)

    def in_c(kernel: Kernel, precision: Precision, x: np.ndarray) -> np.ndarray:
        source, library = tmp_path / "tests.c", tmp_path / f"{kernel.name}{precision.suffix}.so"
        source.write_text(c_batch.library_source("tests", [kernel]))
        compiled("-O3", "-shared", "-fPIC", str(source), "-lm", "-o", str(library))
        entry = getattr(ctypes.CDLL(str(library)), f"motorcade_{kernel.name}_{precision.suffix}")
        padded = np.resize(x, -(-len(x) // 16) * 16)
        out = np.zeros((3, len(padded)), x.dtype)
        pointer, step = ctypes.c_void_p * 1, ctypes.c_ssize_t * 1
        entry(
            pointer(padded.ctypes.data),
            step(0),
            pointer(out.ctypes.data),
            step(len(padded)),
            ctypes.c_size_t(len(padded) // 16),
        )
        return out[:, : len(x)].T

    return in_numpy if request.param == "numpy" else in_c


def compiled(*arguments: str) -> str:
    assert COMPILER is not None
    command = [
        COMPILER,
        "-std=c11",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-fno-math-errno",
        "-fno-trapping-math",
        f"-I{GENERATED.parent / 'native'}",
        *arguments,
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stderr


@precisions
def test_the_bits_are_what_numpys_ldexp_and_frexp_say(precision: Precision, run: Any) -> None:
    limits = np.finfo(precision.numpy)
    whole = np.arange(limits.minexp, limits.maxexp, dtype=precision.numpy)
    made = run(KERNELS["bits"], precision, whole)
    np.testing.assert_array_equal(made[:, 1], np.ldexp(np.ones_like(whole), whole.astype(int)))
    powers = np.ldexp(np.ones_like(whole), whole.astype(int))
    for x in (powers, np.nextafter(2 * powers[:-1], 0), 1.37 * powers):
        x = x.astype(precision.numpy)
        expected = np.frexp(x)[1] - 1
        np.testing.assert_array_equal(run(KERNELS["bits"], precision, x)[:, 0], expected)


@precisions
def test_powers_beyond_the_normal_numbers_are_zero_and_infinite(
    precision: Precision, run: Any
) -> None:
    limits = np.finfo(precision.numpy)
    x = np.array([limits.maxexp, 1e9, limits.max], precision.numpy)
    made = run(KERNELS["bits"], precision, x)
    np.testing.assert_array_equal(made[:, 1], np.inf)
    np.testing.assert_array_equal(made[:, 2], 0.0)


@precisions
def test_casadi_evaluates_the_same(precision: Precision, run: Any) -> None:
    x = np.random.default_rng(1).uniform(-14, 14, 200).astype(precision.numpy)
    for kernel in KERNELS.values():
        witness = np.array(kernel.casadi(precision)(x[None])).T
        made = run(kernel, precision, x)
        np.testing.assert_allclose(made, witness, rtol=16 * precision.epsilon, atol=0)


def sizes(precision: Precision) -> np.ndarray:
    """Logarithms of scales from nothing to where products of scales end, of both signs."""
    tiny = [0.0, 1e-30, 1e-12, 1e-6, 1e-3]
    borders = [(n + 0.5) * np.log(2) + off for n in range(5) for off in (-1e-6, 0, 1e-6)]
    x = np.array([*tiny, *borders, *np.linspace(0.01, 30, 301)], precision.numpy)
    return np.concatenate([x, -x])


@precisions
def test_functions_of_growth_are_exact_to_a_few_roundings(precision: Precision, run: Any) -> None:
    x = sizes(precision)
    made = run(KERNELS["growth"], precision, x)
    with mpmath.workdps(40):
        numbers = [mpmath.mpf(v) for v in x.tolist()]
        exact = [[mpmath.cosh(v), mpmath.sinh(v), mpmath.sinh(v) / v if v else 1] for v in numbers]
    np.testing.assert_allclose(
        made, np.array(exact, dtype=float), rtol=6 * precision.epsilon, atol=0
    )


@precisions
def test_logarithms_undo_growth_relative_to_their_own_size(precision: Precision, run: Any) -> None:
    x = sizes(precision)
    made = run(KERNELS["shrunk"], precision, x)
    # Of the scale itself rounding leaves a part, which is the logarithm's error for large ones.
    np.testing.assert_allclose(made[:, 0], x, rtol=6 * precision.epsilon, atol=0)
    quotient = np.where(x == 0, 1, x / np.where(x == 0, 1, np.sinh(x.astype(float))))
    np.testing.assert_allclose(made[:, 1], quotient, rtol=12 * precision.epsilon, atol=0)


def test_only_kernels_and_whole_exponents_get_them() -> None:
    ours = {"exponent", "exp2_of_integer"}
    assert ours <= set(KERNELS["bits"].tape(SINGLE).operations())
    other = trace("f", (X,), (OUT,), lambda x: bits(SINGLE, x))
    assert not ours & set(other.operations())
    broken = trace("f", (X,), (X,), lambda x: [[power_of_two(x[0])]], powers_of_two=True)
    assert not ours & set(broken.operations())


@pytest.mark.quick_every(3)
@needs_gcc
@pytest.mark.parametrize("path", sorted(GENERATED.glob("c/similarity_*.c")), ids=lambda p: p.stem)
def test_loops_over_similarities_become_simd_code(path: Path, tmp_path: Path) -> None:
    flags = ["-O3", "-march=x86-64-v3", "-U__gnu_linux__", "-fopt-info-vec-optimized"]
    if (
        subprocess.run(
            [COMPILER or "gcc", "-dumpmachine"], capture_output=True, text=True, check=True
        ).stdout.split("-")[0]
        != "x86_64"
    ):
        pytest.skip("another processor's flags")
    told = compiled(*flags, "-c", str(path), "-o", str(tmp_path / "kernel.o"))
    kernels = path.read_text().count("\nMOTORCADE_SIMD\n")
    assert told.count("loop vectorized using 32 byte vectors") == kernels, told
