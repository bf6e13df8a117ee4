"""Both backends of the kernels compute the same, and the room imports nothing heavy."""

import os
import subprocess
import sys
from types import ModuleType

import numpy as np
import pytest

from motorcade.ga import Motor, kernels
from motorcade.ga.kernels import numpy_kernels

ROUNDING = 3e-15


@pytest.fixture(scope="module")
def compiled() -> ModuleType:
    if kernels.backend != "compiled":
        pytest.skip("the compiled kernels are not built, or MOTORCADE_KERNELS=numpy")
    from motorcade.ga.kernels import compiled_kernels

    return compiled_kernels


def assert_close(ours: np.ndarray, witness: np.ndarray) -> None:
    assert ours.shape == witness.shape
    scale = max(1.0, float(np.max(np.abs(witness), initial=0.0)))
    np.testing.assert_allclose(ours, witness, rtol=0, atol=ROUNDING * scale)


@pytest.mark.parametrize("short_way", [True, False])
def test_backends_agree_on_hard_motors(
    compiled: ModuleType, motors: Motor, short_way: bool
) -> None:
    m = motors.coefficients
    assert_close(compiled.compose(m, m[::-1].copy()), numpy_kernels.compose(m, m[::-1].copy()))
    assert_close(compiled.inverse(m), numpy_kernels.inverse(m))
    assert_close(compiled.log(m, short_way), numpy_kernels.log(m, short_way))
    assert_close(compiled.exp(numpy_kernels.log(m)), numpy_kernels.exp(numpy_kernels.log(m)))
    fraction = np.array(0.3)
    other = Motor.from_twist([0.1, 0.2, -0.4, 1.0, 0.5, 0.0]).coefficients
    assert_close(
        compiled.interpolate(other, m, fraction, short_way),
        numpy_kernels.interpolate(other, m, fraction, short_way),
    )


@pytest.mark.parametrize("count", [0, 1, 15, 16, 17, 31, 33, 1000])
def test_backends_agree_at_every_block_boundary(
    compiled: ModuleType, count: int, rng: np.random.Generator
) -> None:
    a, b = (Motor.random(rng, (count,)).coefficients for _ in range(2))
    fraction = rng.uniform(-1, 2, count)
    assert_close(compiled.compose(a, b), numpy_kernels.compose(a, b))
    assert_close(compiled.inverse(a), numpy_kernels.inverse(a))
    assert_close(compiled.log(a), numpy_kernels.log(a))
    assert_close(compiled.interpolate(a, b, fraction), numpy_kernels.interpolate(a, b, fraction))


@pytest.mark.parametrize("half_angle", [1e-12, 1e-3, 0.49, 0.51, 1.5, 3.2, 40.0, 9e4, 2e5, 1e12])
def test_backends_agree_on_the_exponential_of_any_angle(
    compiled: ModuleType, half_angle: float, rng: np.random.Generator
) -> None:
    log = rng.standard_normal((100, 6))
    log[:, :3] *= half_angle / np.linalg.norm(log[:, :3], axis=1, keepdims=True)
    assert_close(compiled.exp(log), numpy_kernels.exp(log))


@pytest.mark.parametrize(
    ("first", "second", "steps"),
    [((), (), ()), ((5,), (), ()), ((), (5,), (5,)), ((3, 1), (4,), ()), ((1, 2), (3, 1), (2,)),
     ((2, 3, 4), (2, 3, 4), (4,)), ((), (), (7,)), ((0,), (1,), ())],
)  # fmt: skip
def test_backends_broadcast_alike(
    compiled: ModuleType,
    first: tuple[int, ...],
    second: tuple[int, ...],
    steps: tuple[int, ...],
    rng: np.random.Generator,
) -> None:
    a, b = Motor.random(rng, first).coefficients, Motor.random(rng, second).coefficients
    fraction = rng.uniform(size=steps)
    assert_close(compiled.compose(a, b), numpy_kernels.compose(a, b))
    assert_close(compiled.interpolate(a, b, fraction), numpy_kernels.interpolate(a, b, fraction))


def test_compiled_kernels_read_strided_input_rightly(
    compiled: ModuleType, rng: np.random.Generator
) -> None:
    m = Motor.random(rng, (40,)).coefficients
    columns = np.asfortranarray(m)
    for view, plain in ((columns, m), (m[::-2], m[::-2].copy())):
        np.testing.assert_array_equal(compiled.log(view), compiled.log(plain))
        np.testing.assert_array_equal(compiled.compose(view, view), compiled.compose(plain, plain))


def test_results_do_not_depend_on_the_place_in_the_batch(rng: np.random.Generator) -> None:
    # A file processed in one piece or in parts must come out with the same bytes.
    a, b = Motor.random(rng, (100,)), Motor.random(rng, (100,))
    fraction = rng.uniform(size=100)
    whole = a.interpolate(b, fraction).coefficients
    part = a[37:61].interpolate(b[37:61], fraction[37:61]).coefficients
    np.testing.assert_array_equal(part, whole[37:61])


def test_the_binding_refuses_arrays_that_do_not_fit(compiled: ModuleType) -> None:
    from motorcade.ga.kernels import _compiled

    motors = np.zeros((3, 8))
    with pytest.raises(ValueError, match="as many rows as the output"):
        _compiled.compose(motors, np.zeros((2, 8)), np.zeros((3, 8)))
    for wrong in (np.zeros((3, 7)), np.zeros((3, 8), dtype=np.float32), np.zeros((6, 8))[::2]):
        with pytest.raises(TypeError):
            _compiled.inverse(wrong, np.zeros((3, 8)))
    read_only = np.zeros((3, 8))
    read_only.setflags(write=False)
    with pytest.raises(TypeError):
        _compiled.inverse(motors, read_only)


def run_python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False,
        env={**os.environ, **environment},
    )  # fmt: skip


def test_numpy_kernels_can_be_forced() -> None:
    done = run_python(
        "from motorcade.ga import kernels; print(kernels.backend, kernels.exp.__module__)",
        MOTORCADE_KERNELS="numpy",
    )
    assert done.stdout.split() == ["numpy", "motorcade.ga.kernels.numpy_kernels"], done.stderr


def test_other_kernel_names_are_refused() -> None:
    done = run_python("import motorcade.ga", MOTORCADE_KERNELS="fortran")
    assert done.returncode != 0
    assert "MOTORCADE_KERNELS: expected 'numpy' or nothing, got 'fortran'" in done.stderr


def test_importing_the_room_loads_numpy_only() -> None:
    done = run_python(
        "import sys, numpy; before = set(sys.modules); import motorcade.ga;"
        "print(*sorted({name.split('.')[0] for name in set(sys.modules) - before}))"
    )
    loaded = set(done.stdout.split())
    assert "motorcade" in loaded, done.stderr
    foreign = {name for name in loaded if name not in sys.stdlib_module_names}
    assert foreign <= {"motorcade", "numpy"}, foreign
