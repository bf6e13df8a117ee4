"""Both backends of the kernels compute the same, and the room imports nothing heavy."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor, kernels
from motorcade.ga.kernels import numpy_backend
from motorcade.ga.kernels.generated.python import KERNELS
from motorcade.ga.versors.euler_angles import SEQUENCES, sequence_operands
from tests.ga.cases import over
from tests.ga.conftest import SAMPLES

# Where the blades of a similarity's logarithm stand in it; twists have the scale last.
LOG_PLACES = (1, 2, 3, 4, 8, 9, 10)
TWIST_PLACES = (1, 2, 3, 8, 9, 10, 4)
SCALES = (1.0, 1 + 1e-12, 1 - 1e-3, 0.25, 1.5, 4.0)
pytestmark = pytest.mark.usefixtures("one_thread")
DTYPES = (np.float32, np.float64)
# Roundings differ where products are fused with sums, and grow with the number of operations.
ROUNDINGS = 24


@pytest.fixture
def one_thread() -> Iterator[None]:
    before = kernels.threads()
    kernels.set_threads(1)
    yield
    kernels.set_threads(before)


@pytest.fixture
def compiled() -> Callable[[str], Callable[..., None]]:
    if kernels.backend != "compiled":
        pytest.skip("the compiled kernels are not built, or MOTORCADE_KERNELS=numpy")
    return kernels.function


def inputs_of(name: str, motors: np.ndarray, rng: np.random.Generator) -> list[np.ndarray]:
    """Hard motors as a kernel's inputs, whatever their width; numbers are fractions in (0, 1].

    As similarities they grow and shrink by up to four.
    """
    rows = motors.reshape(-1, 8)
    if "matrix33" in name and KERNELS[name][1] == (9,):
        return [np.ascontiguousarray(kernels.MOTORS.matrix34(rows)[:, :, :3]).reshape(-1, 9)]
    if KERNELS[name][1] == (16,):
        return [np.ascontiguousarray(kernels.MOTORS.matrix44(rows)).reshape(-1, 16)]
    places = LOG_PLACES if name == "similarity_exp" else TWIST_PLACES
    others = np.asarray(Motor.random(rng, (len(rows),)).coefficients, dtype=rows.dtype)
    made: list[np.ndarray] = []
    for width in KERNELS[name][1]:
        source = others if made else rows
        if width == 1:
            made.append(1 - rng.uniform(size=len(rows)).astype(rows.dtype))
        elif width in (9, 10):
            known = [sequence_operands(sequence) for sequence in SEQUENCES]
            if width == 10:
                known = [one for one in known if one.proper == ("proper" in name)]
            listed = [one.axes if width == 9 else one.frame for one in known]
            made.append(np.array([one[rows.dtype] for one in listed])[np.arange(len(rows)) % 6])
        elif width == 13:
            made.append(np.concatenate([rows, others[:, :5]], axis=-1))
        elif width in (7, 12):
            scale = np.resize(SCALES[:: -1 if made else 1], len(rows)).astype(rows.dtype)
            grown = kernels.similarity_of_motor(source, scale)
            made.append(np.ascontiguousarray(grown[:, places] if width == 7 else grown))
        else:
            first = 1 if width in (3, 6) else 0
            made.append(np.ascontiguousarray(source[:, first : first + width]))
    return made


def assert_close(ours: np.ndarray, witness: np.ndarray, size: float = 1.0) -> None:
    assert ours.shape == witness.shape
    assert ours.dtype == witness.dtype
    scale = max(size, float(np.max(np.abs(witness), initial=0.0)))
    atol = ROUNDINGS * float(np.finfo(ours.dtype).eps) * scale
    np.testing.assert_allclose(ours, witness, rtol=0, atol=atol)


def results(
    name: str,
    compiled: Callable[[str], Callable[..., None]],
    inputs: list[Any],
    count: int,
    dtype: Any,
) -> tuple[np.ndarray, np.ndarray]:
    shape = (count, KERNELS[name][2])
    ours, witness = np.full(shape, np.nan, dtype), np.full(shape, np.nan, dtype)
    compiled(name)(*inputs, ours)
    numpy_backend.function(name)(*inputs, witness)
    return ours, witness


@pytest.mark.parametrize("name", KERNELS)
@over(motors=SAMPLES, dtype=DTYPES)
def test_backends_agree_on_hard_motors(
    name: str, dtype: Any, compiled: Callable[..., Any], motors: Motor, rng: np.random.Generator
) -> None:
    if "log_long" in name and np.any(motors.coefficients[..., 0] < -0.9):
        pytest.skip("close to a full turn the axis is lost")
    inputs = inputs_of(name, motors.coefficients.astype(dtype), rng)
    reach = float(np.max(np.abs(motors.coefficients))) ** (2 if name == "accumulate" else 1)
    assert_close(*results(name, compiled, inputs, len(inputs[0]), dtype), reach)


@pytest.mark.parametrize("name", KERNELS)
@over(count=[0, 1, 15, 16, 17, 31, 33, 54, 1000, 5000], dtype=DTYPES)
def test_backends_agree_at_every_block_boundary(
    name: str, count: int, dtype: Any, compiled: Callable[..., Any], rng: np.random.Generator
) -> None:
    motors = Motor.random(rng, (count,)).coefficients.astype(dtype)
    assert_close(*results(name, compiled, inputs_of(name, motors, rng), count, dtype))


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("half_angle", [1e-12, 1e-3, 0.49, 1.5, 1.58, 3.2, 40.0, 5e3])
def test_backends_agree_on_the_exponential_of_any_angle(
    compiled: Callable[..., Any], half_angle: float, dtype: Any, rng: np.random.Generator
) -> None:
    log = rng.standard_normal((100, 6))
    log[:, :3] *= half_angle / np.linalg.norm(log[:, :3], axis=1, keepdims=True)
    inputs = [log.astype(dtype)]
    assert_close(*results("exp", compiled, inputs, 100, dtype), max(1.0, half_angle))


@pytest.mark.parametrize("name", KERNELS)
@over(dtype=DTYPES)
def test_kernels_read_and_write_any_layout_rightly(
    name: str, dtype: Any, compiled: Callable[..., Any], rng: np.random.Generator
) -> None:
    inputs = inputs_of(name, Motor.random(rng, (333,)).coefficients.astype(dtype), rng)
    plain, _ = results(name, compiled, inputs, 333, dtype)
    for x in inputs:
        x.setflags(write=False)
    wide = np.zeros((666, 2 * plain.shape[1]), dtype)
    layouts: list[tuple[list[np.ndarray], np.ndarray]] = [
        ([np.asfortranarray(x) for x in inputs], np.asfortranarray(np.empty_like(plain))),
        ([np.repeat(x, 2, axis=0)[::2] for x in inputs], wide[::2, ::2]),
        ([x[::-1].copy()[::-1] for x in inputs], np.empty_like(plain)[::-1]),
    ]
    for given, out in layouts:
        compiled(name)(*given, out)
        np.testing.assert_array_equal(out, plain)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("count", [0, 5, 54, 64, 3000])
@pytest.mark.parametrize("make", [numpy_backend.Block, kernels.Block])
def test_blocks_hold_operands_without_copies(
    make: Any, count: int, dtype: str, rng: np.random.Generator
) -> None:
    module = numpy_backend if make is numpy_backend.Block else kernels
    a, b, part, out = (make(width, count, dtype) for width in (8, 8, 1, 12))
    for block in (a, b):
        block.array[:] = Motor.random(rng, (count,)).coefficients
    part.array[:, 0] = rng.uniform(size=count)
    module.function("screw_blend_matrix")(a, b, part, out)
    assert (len(out), out.width, out.array.dtype) == (count, 12, dtype)
    witness = kernels.screw_blend_matrix(a.array, b.array, part.array[:, 0].copy())
    assert_close(out.array.reshape(count, 3, 4), witness)
    module.function("screw_blend_matrix")(a, b, 0.25, out)
    assert_close(out.array.reshape(count, 3, 4), kernels.screw_blend_matrix(a.array, b.array, 0.25))


@pytest.mark.parametrize(
    ("first", "second", "steps"),
    [
        ((), (), ()),
        ((5,), (), ()),
        ((), (5,), (5,)),
        ((3, 1), (4,), ()),
        ((1, 2), (3, 1), (2,)),
        ((2, 3, 4), (2, 3, 4), (4,)),
        ((), (), (7,)),
        ((0,), (1,), ()),
        ((40, 3), (3,), (40, 1)),
    ],
)
def test_batches_broadcast_as_arrays_do(
    first: tuple[int, ...],
    second: tuple[int, ...],
    steps: tuple[int, ...],
    rng: np.random.Generator,
) -> None:
    a, b = Motor.random(rng, first).coefficients, Motor.random(rng, second).coefficients
    fraction = rng.uniform(size=steps)
    shape = np.broadcast_shapes(first, second, steps)
    a_all, b_all = (np.broadcast_to(x, (*shape, 8)).reshape(-1, 8) for x in (a, b))
    witness = np.empty((len(a_all), 8))
    part = np.broadcast_to(fraction, shape).reshape(-1)
    numpy_backend.function("interpolate")(a_all, b_all, part, witness)
    assert_close(kernels.MOTORS.interpolate(a, b, fraction), witness.reshape(*shape, 8))
    pairs = np.broadcast_shapes(first, second)
    assert kernels.MOTORS.compose(a, b).shape == (*pairs, 8)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("kind", ["ROTORS", "MOTORS", "SIMILARITIES"])
def test_one_versor_moves_many_points_as_it_moves_each(
    kind: str, dtype: Any, rng: np.random.Generator
) -> None:
    """Many go through its matrix, few do not."""
    verbs = getattr(kernels, kind)
    versor = verbs.exp(rng.standard_normal((1, verbs._twist_size)).astype(dtype))
    points = (10 * rng.standard_normal((40, 50, 3))).astype(dtype)
    alone = np.stack([verbs.apply(versor[0], some) for some in points])
    for one in (versor, versor[0]):
        moved = verbs.apply(one, points)
        assert_close(moved, alone, 10.0)
        checked, finite = verbs.checked_apply(one, points)
        assert finite
        np.testing.assert_array_equal(checked, moved)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("count", [1024, 1025, 4096, 100_000])
def test_components_of_long_results_begin_on_a_cache_line(
    count: int, dtype: Any, rng: np.random.Generator
) -> None:
    for shape in ((count,), (count, 1), (1, count)):
        made = kernels.MOTORS.exp(rng.standard_normal((*shape, 6)).astype(dtype))
        assert made.shape == (*shape, 8)
        columns = np.moveaxis(made, -1, 0).reshape(8, count)
        assert np.shares_memory(columns, made)
        places = {column.__array_interface__["data"][0] % 64 for column in columns}
        assert places == {0}
        assert columns.strides[0] // 64 % 2 == 1


def test_results_do_not_depend_on_the_place_in_the_batch(rng: np.random.Generator) -> None:
    # A file processed in one piece or in parts must come out with the same bytes.
    a, b = Motor.random(rng, (100,)), Motor.random(rng, (100,))
    fraction = rng.uniform(size=100)
    whole = a.interpolate(b, fraction).coefficients
    part = a[37:61].interpolate(b[37:61], fraction[37:61]).coefficients
    np.testing.assert_array_equal(part, whole[37:61])


def test_threads_share_large_batches_without_changing_a_bit(rng: np.random.Generator) -> None:
    a, b = (Motor.random(rng, (150_001,)).coefficients for _ in range(2))
    alone = kernels.MOTORS.compose(a, b)
    kernels.set_threads(3)
    np.testing.assert_array_equal(kernels.MOTORS.compose(a, b), alone)


def test_chained_results_are_read_where_they_lie(rng: np.random.Generator) -> None:
    a = Motor.random(rng, (64,))
    product = a @ a
    assert product.coefficients.strides == (8, 64 * 8)
    np.testing.assert_array_equal(
        (product @ a).coefficients, (Motor(product.coefficients.copy()) @ a).coefficients
    )


def test_blending_many_is_the_normalized_sum_with_the_pivots_signs(
    rng: np.random.Generator,
) -> None:
    motors = Motor.random(rng, (4, 30)).coefficients
    for weights in (rng.uniform(size=4), rng.uniform(size=(4, 30))):
        signs = np.where(np.sum(motors[0, :, :4] * motors[:, :, :4], axis=-1) < 0, -1.0, 1.0)
        factors = signs * weights.reshape(4, -1)
        expected = Motor.normalize(np.sum(factors[..., None] * motors, axis=0))
        assert_close(kernels.blend_many(motors, weights), np.array(expected.coefficients))
        assert_close(kernels.blend_many_matrix(motors, weights), expected.as_matrix()[:, :3])


@pytest.mark.parametrize("module", [numpy_backend, kernels])
def test_operands_that_do_not_fit_are_refused(module: Any) -> None:
    compose, motors = module.function("compose"), np.zeros((3, 8))
    with pytest.raises(ValueError, match="float32' or 'float64'"):
        module.Block(8, 3, "int32")
    with pytest.raises(TypeError, match="expected one precision"):
        compose(motors, motors.astype(np.float32), np.zeros((3, 8)))
    with pytest.raises(ValueError, match=r"expected arrays \(\*, 8\)"):
        compose(motors, np.zeros((6, 4)), np.zeros((3, 8)))
    with pytest.raises(TypeError, match="expected 3 arguments"):
        compose(motors, motors)
    with pytest.raises(ValueError, match=r"as many rows|broadcast|\(2,\)"):
        compose(motors, np.zeros((2, 8)), np.zeros((3, 8)))


def test_the_binding_refuses_arrays_that_do_not_fit(compiled: Callable[..., Any]) -> None:
    compose, motors = compiled("compose"), np.zeros((3, 8))
    with pytest.raises(ValueError, match="as many rows as the output"):
        compose(motors, np.zeros((2, 8)), np.zeros((3, 8)))
    with pytest.raises(ValueError, match=r"expected arrays \(\*, 8\)"):
        compose(motors, np.zeros((3, 7)), np.zeros((3, 8)))
    with pytest.raises(ValueError, match="Block of 8 components, got one of 4"):
        compose(motors, kernels.Block(4, 3), np.zeros((3, 8)))
    with pytest.raises(ValueError, match="at one stride"):
        compose(np.zeros((3, 4, 8))[:, :2], np.zeros((3, 2, 8)), np.zeros((3, 2, 8)))
    with pytest.raises(TypeError, match="float32 or float64"):
        compose(motors, np.zeros((3, 8), dtype=int), np.zeros((3, 8)))
    with pytest.raises(ValueError, match="overlap"):
        compose(motors, motors.copy(), motors)
    read_only = np.zeros((3, 8))
    read_only.setflags(write=False)
    with pytest.raises((BufferError, ValueError)):
        compose(motors, motors, read_only)


@pytest.mark.parametrize("module", [numpy_backend, kernels])
def test_an_output_that_overlaps_an_input_is_refused_and_one_that_lies_between_is_not(
    module: Any, rng: np.random.Generator
) -> None:
    inverse = module.function("inverse")
    table = rng.uniform(size=(40, 24))
    for given, out in (
        (table[:-1, :8], table[1:, :8]),
        (table[:, :8], table[:, 4:12]),
        (table[:, :8], table[::-1, 4:12]),
        (table[0, :8], table[:, :8]),
        (table.ravel()[:320].reshape(8, 40).T, table.ravel()[40:360].reshape(8, 40).T),
    ):
        with pytest.raises(ValueError, match="overlap"):
            inverse(given, out)
    witness = kernels.MOTORS.inverse(table[:, :8].copy())
    inverse(table[:, :8], table[::-1, 16:])
    np.testing.assert_array_equal(table[::-1, 16:], witness)
    inverse(table[:20, :8], table[10:30, 8:16])
    np.testing.assert_array_equal(table[10:30, 8:16], witness[:20])
    rows = np.asfortranarray(witness).T.repeat(2, axis=0)
    inverse(rows[::2].T, rows[1::2].T)
    np.testing.assert_array_equal(rows[1::2].T, table[:, :8])


def test_what_is_no_array_is_refused_by_name(rng: np.random.Generator) -> None:
    motors = Motor.random(rng, (3,)).coefficients
    rows = motors.tolist()
    for call in (
        lambda: kernels.MOTORS.compose(rows, rows),
        lambda: kernels.MOTORS.compose(motors, rows),
        lambda: kernels.MOTORS.log(rows),
        lambda: kernels.blend(motors, motors, "0.5"),
        lambda: kernels.blend_many(rows, [0.5, 0.5]),
        lambda: kernels.blend_many(motors[:2], [0.5, 0.5]),
        lambda: kernels.similarity_of_motor(motors, [1.0, 2.0, 3.0]),
    ):
        with pytest.raises(TypeError, match="expected NumPy arrays of float32 or float64, got "):
            call()


def test_a_fraction_may_be_a_whole_number(rng: np.random.Generator) -> None:
    a, b = Motor.random(rng, (2, 3)).coefficients
    for kernel in (kernels.MOTORS.interpolate, kernels.blend, kernels.screw_blend_matrix):
        np.testing.assert_array_equal(kernel(a, b, 1), kernel(a, b, 1.0))


def run_python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **environment},
    )


def test_numpy_kernels_can_be_forced() -> None:
    done = run_python(
        "from motorcade.ga import kernels as k; print(k.backend, k.function('exp').__module__)",
        MOTORCADE_KERNELS="numpy",
    )
    assert done.stdout.split() == ["numpy", "motorcade.ga.kernels.numpy_backend"], done.stderr


def test_other_kernel_names_are_refused() -> None:
    done = run_python("from motorcade.ga import Motor", MOTORCADE_KERNELS="fortran")
    assert done.returncode != 0
    assert "MOTORCADE_KERNELS: expected 'numpy' or nothing, got 'fortran'" in done.stderr


def test_importing_the_room_loads_numpy_only() -> None:
    done = run_python(
        "import sys, numpy; before = set(sys.modules); import motorcade.ga as ga;"
        "print(*sorted(set(sys.modules) - before)); [getattr(ga, name) for name in ga.__all__];"
        "print(*sorted({name.split('.')[0] for name in set(sys.modules) - before}))"
    )
    at_first, *every = done.stdout.splitlines()
    ours = {name for name in at_first.split() if name.startswith("motorcade")}
    assert ours == {"motorcade", "motorcade.ga"}, done.stderr
    loaded = set(every[0].split())
    foreign = {name for name in loaded if name not in sys.stdlib_module_names}
    assert foreign <= {"motorcade", "numpy", "lazy_loader"}, foreign
