"""Programs give the same as compiled C, as NumPy and as plain multivectors.

Also run under the sanitizers (`make sanitize`), which see what is read or written beside an array.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.ga import CGA3, EGA3, Motor, Multivector, kernels
from motorcade.ga import compile as compile_program
from motorcade.ga.codegen import program
from motorcade.ga.codegen.functions import CompiledFunction, compile_function
from motorcade.ga.codegen.precision import PRECISIONS
from motorcade.ga.codegen.runtime.by_numpy import NumpyProgram, plain_tape
from motorcade.ga.script import evaluate, parse
from tests.ga.kernels.accuracy_motors import hard_motors

MOTOR = "1 e2^e3 e3^e1 e1^e2 e1^einf e2^einf e3^einf e1^e2^e3^einf"
POINT = "e1 e2 e3 e0 einf"
TOLERANCE = {"float32": 2e-5, "float64": 1e-12}


def moved(m: Any, p: Any) -> Any:
    """The sandwich ``m p ~m``."""
    return m * p * ~m


def by_numpy(function: CompiledFunction) -> NumpyProgram:
    """The NumPy way of a function, whichever it takes by itself."""
    tape = function.program.tape
    inputs, outputs = (
        [(o.name, -1 if o.components == ("1",) else o.width) for o in operands]
        for operands in (tape.inputs, tape.outputs)
    )
    count = sum(operand.width for operand in tape.inputs)
    return NumpyProgram(function.program.name, plain_tape(tape), inputs, outputs, [False] * count)


def point_of(coordinates: np.ndarray) -> np.ndarray:
    square = 0.5 * np.sum(coordinates**2, axis=-1, keepdims=True)
    return np.concatenate([coordinates, np.ones_like(square), square], axis=-1)


def test_motors_move_points_as_the_kernel_does(compiled: Path, rng: np.random.Generator) -> None:
    function = compile_function(moved, m=MOTOR, p=POINT)
    motors, points = Motor.random(rng, (500,)).coefficients, rng.normal(size=(500, 3))
    made = function.arrays(motors, point_of(points))
    assert function.backend() == "c"
    np.testing.assert_allclose(
        made[:, :3] / made[:, 3:4], kernels.MOTORS.apply(motors, points), atol=1e-12
    )


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("count", [1100, 5001])
def test_long_results_begin_on_a_cache_line(
    compiled: Path, dtype: str, count: int, rng: np.random.Generator
) -> None:
    function = compile_function(moved, m=MOTOR, p=POINT)
    motors, point = rng.normal(size=(8, count)).astype(dtype), np.ones(5, dtype)
    made = function.arrays(motors.T, point)
    assert function.backend(dtype) == "c"
    assert {made[:, k].__array_interface__["data"][0] % 64 for k in range(5)} == {0}
    columns = dict(zip(MOTOR.split(), motors, strict=True))
    whole = function(CGA3.multivector(columns), CGA3.multivector(dict.fromkeys(POINT.split(), 1.0)))
    assert isinstance(whole, Multivector)
    for k, blade in enumerate(function.program.tape.outputs[0].components):
        np.testing.assert_allclose(whole[blade], made[:, k], rtol=TOLERANCE[dtype], atol=1e-4)
        if count >= 4096:
            assert whole[blade].__array_interface__["data"][0] % 64 == 0


@pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: p.numpy)
def test_one_row_is_computed_by_numpy_as_many_are(precision: Any, rng: np.random.Generator) -> None:
    way = by_numpy(compile_function(moved, m=MOTOR, p=POINT))
    motors, points = (rng.normal(size=(20, n)).astype(precision.numpy) for n in (8, 5))
    many = way.arrays(precision, (motors, points))
    for k in range(20):
        one = way.arrays(precision, (motors[k], points[k]))
        for own, all_rows in zip(one, many, strict=True):
            assert own.dtype == precision.numpy
            np.testing.assert_array_equal(own, all_rows[k])


def test_arrays_and_multivectors_are_one_function(compiled: Path, rng: np.random.Generator) -> None:
    function = compile_function(moved, m=MOTOR, p=POINT)
    motors, points = Motor.random(rng, (3, 7)).coefficients, point_of(rng.normal(size=(7, 3)))
    m = CGA3.multivector(dict(zip(MOTOR.split(), np.moveaxis(motors, -1, 0), strict=True)))
    p = CGA3.multivector(dict(zip(POINT.split(), points.T, strict=True)))
    made, plain = function(m, p), m * p * ~m
    assert isinstance(made, Multivector)
    arrays = function.arrays(motors, points)
    for k, blade in enumerate(function.program.tape.outputs[0].components):
        np.testing.assert_allclose(made[blade], plain[blade], atol=1e-12)
        np.testing.assert_array_equal(arrays[..., k], made[blade])
    one = function(CGA3.blade("e2^e3"), CGA3.blade("e1"))
    assert isinstance(one, Multivector)
    assert isinstance(one["e1"], float)
    assert one["e1"] == (CGA3.blade("e2^e3") * CGA3.blade("e1") * ~CGA3.blade("e2^e3"))["e1"]


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("seed", range(4))
def test_random_programs_agree(
    seed: int, precision: str, compiled: Path, random_script: Callable[..., str]
) -> None:
    rng = np.random.default_rng(seed)
    script = parse(random_script(rng))
    function = compile_program(script, name="drawn")
    names = [operand.name for operand in function.program.tape.inputs]
    drawn = {name: rng.uniform(0.2, 1.5, 300).astype(precision) for name in names}
    made = function.arrays(**drawn)
    assert not names or function.backend(precision) == "c"
    exact = {name: values.astype(np.float64) for name, values in drawn.items()}
    expected = evaluate(script, **exact)
    kind = next(p for p in PRECISIONS if p.numpy == precision)
    numpy_way = by_numpy(function).arrays(kind, list(drawn.values()))
    for operand, other in zip(function.program.tape.outputs, numpy_way, strict=True):
        rows = made[operand.name].reshape(len(made[operand.name]) if names else 1, -1)
        wanted = np.stack(
            [np.broadcast_to(expected[operand.name][b], len(rows)) for b in operand.components]
            or [np.empty(len(rows))[:0]],
            axis=-1,
        ).reshape(len(rows), -1)
        size = np.maximum(1.0, np.abs(wanted).max(initial=0.0))
        assert rows.dtype == (precision if names else "float64")
        np.testing.assert_allclose(rows, wanted, atol=TOLERANCE[precision] * size)
        np.testing.assert_allclose(
            other.reshape(rows.shape), wanted, atol=TOLERANCE[precision] * size
        )


def layouts(rng: np.random.Generator, width: int) -> list[np.ndarray]:
    """Arrays ``(…, width)`` that lie in every way in memory."""
    whole = rng.normal(size=(6, 50, 2 * width))
    return [
        whole[0, :, :width].copy(),
        np.asfortranarray(whole[1, :, :width]),
        whole[2, ::-2, :width],
        whole[3, :25, ::2],
        whole[:, :, 1 : width + 1],
        whole[:, :1, ::-2][:, :, :width],
        np.broadcast_to(whole[0, 0, :width], (6, 50, width)),
        whole[4, 0, :width],
        whole[:0, :, :width],
        np.moveaxis(rng.normal(size=(width, 6, 50)), 0, -1),
    ]


@pytest.mark.parametrize("way", ["compiled", "numpy"])
def test_any_layouts_broadcast(way: str, compiled: Path, rng: np.random.Generator) -> None:
    function = compile_function(moved, algebra=EGA3, m="1 e1^e2 e2^e3", p="e1 e2 e3")
    numpy_way = by_numpy(function)
    for m in layouts(rng, 3):
        for p in layouts(rng, 3):
            try:
                shape = np.broadcast_shapes(m.shape, p.shape)
            except ValueError:
                continue
            if way == "compiled":
                made = function.arrays(m, p)
            else:
                (made,) = numpy_way.arrays(PRECISIONS[1], [m, p])
            rows = [np.broadcast_to(one, shape).reshape(-1, 3) for one in (m, p)]
            x, y = (
                EGA3.multivector(dict(zip(blades.split(), one.T, strict=True)))
                for blades, one in zip(("1 e1^e2 e2^e3", "e1 e2 e3"), rows, strict=True)
            )
            plain = x * y * ~x
            assert made.shape[:-1] == shape[:-1]
            for k, blade in enumerate(function.program.tape.outputs[0].components):
                wanted = np.broadcast_to(plain[blade], len(rows[0])).reshape(shape[:-1])
                np.testing.assert_allclose(made[..., k], wanted, atol=1e-12)


@pytest.mark.parametrize("count", [1, 15, 16, 17, 1023, 1025, 60_001])
def test_every_count_of_rows_is_computed_whole(
    count: int, compiled: Path, rng: np.random.Generator
) -> None:
    function = compile_function(moved, m=MOTOR, p=POINT)
    threads = kernels.threads()
    kernels.set_threads(3)
    try:
        motors, point = rng.normal(size=(count, 8)), point_of(rng.normal(size=3))
        made = function.arrays(motors, point)
        assert made.shape == (count, len(function.program.tape.outputs[0].components))
        (wanted,) = by_numpy(function).arrays(PRECISIONS[1], [motors, point])
        np.testing.assert_allclose(made, wanted, atol=1e-11)
        turned = np.asfortranarray(motors)
        np.testing.assert_array_equal(function.arrays(turned, point), made)
    finally:
        kernels.set_threads(threads)


def test_precisions_are_numpys(compiled: Path) -> None:
    function = compile_program("?a = x*y + 0.1*z*e1;")
    single, double = np.float32([1.0, 2.0]), np.array([1.0, 2.0])
    for given, kind in (
        ((single, single, 2.0), "float32"),
        ((single, 1, 2.0), "float32"),
        ((single, double, 2.0), "float64"),
        ((single, np.float64(3.0), 2.0), "float64"),
        ((double, single, single), "float64"),
        ((np.array([1, 2]), single, 1.0), "float64"),
        ((1.0, 2.0, 3.0), "float64"),
    ):
        made = function.arrays(*given)["a"]
        assert made.dtype == kind, given
        np.testing.assert_allclose(made[..., 0], np.asarray(given[0]) * np.asarray(given[1]))


@pytest.mark.parametrize("way", ["compiled", "numpy"])
def test_what_does_not_fit_is_refused_alike(way: str, compiled: Path) -> None:
    function = compile_function(moved, algebra=EGA3, m="1 e1^e2", p="e1 e2 e3")
    numpy_way = by_numpy(function)
    good = np.zeros((4, 2)), np.zeros((4, 3))
    function.arrays(*good)
    assert function.backend() == "c"

    def call(*given: Any) -> Any:
        if way == "compiled":
            return function._runs.arrays(*given)
        return numpy_way.arrays(PRECISIONS[1], given)

    for given, error, message in (
        ((good[0],), ValueError, "moved: expected 2 arguments, got 1"),
        ((np.zeros((4, 3)), good[1]), ValueError, r"m: expected an array \(\*, 2\), got .* \(4"),
        ((np.zeros(()), good[1]), ValueError, r"m: expected an array \(\*, 2\)"),
        ((1.0, good[1]), TypeError, "m: expected an array of real numbers, got float"),
        (([1.0, 2.0], good[1]), TypeError, "m: expected an array of real numbers, got list"),
        ((good[0] + 1j, good[1]), TypeError, "m: expected real numbers, got the"),
        ((np.zeros((4, 2), bool), good[1]), TypeError, "m: expected real numbers, got the"),
        ((np.zeros((3, 2)), good[1]), ValueError, "expected batches that broadcast together"),
        ((np.zeros([1] * 17 + [2]), good[1]), ValueError, "at most 16 batch dimensions, got 17"),
    ):  # fmt: skip
        with pytest.raises(error, match=message):
            call(*given)


def test_results_that_are_not_finite_are_refused_of_multivectors(compiled: Path) -> None:
    function = compile_program("?fine = x; ?lost = log(x);")
    with pytest.raises(ValueError, match="script: expected finite numbers in lost"):
        function(-1.0)
    with pytest.raises(ValueError, match="script: expected finite numbers in lost"):
        function(np.array([1.0, 0.0]))
    assert np.isnan(function.arrays(-1.0)["lost"])
    np.testing.assert_allclose(by_numpy(function).arrays(PRECISIONS[1], [2.0])[1], np.log(2.0))
    with pytest.raises(ValueError, match="script: expected finite numbers in lost"):
        by_numpy(function).components(PRECISIONS[1], [-1.0])


def test_decorators_work_with_and_without_arguments(folder: Path) -> None:
    @program
    def twice(x: Any) -> Any:
        return 2 * x

    @program(algebra=EGA3, v="e1 e2")
    def squared(v: Any) -> Any:
        return v * v

    assert twice.arrays(np.arange(3.0)).tolist() == [0.0, 2.0, 4.0]
    assert squared.arrays(np.array([3.0, 4.0])) == 25.0
    with pytest.raises(ValueError, match="expected blades of a function's parameters"):
        compile_program("?a = x;", x="e1")


def test_a_script_of_log_and_exp_is_as_accurate_as_the_kernel(compiled: Path) -> None:
    script = Path(__file__).parents[3] / "bench/algebra/table3/scripts/motor.clu"
    function = compile_program(parse(script.read_text(encoding="utf-8")), name="motor")
    rng = np.random.default_rng(0)
    a, b = hard_motors(rng), hard_motors(rng)
    pairs = [(a, b), (a, kernels.MOTORS.compose(a, b)), (a, kernels.MOTORS.compose(b, a))]
    given = np.concatenate([np.concatenate(pair, axis=1) for pair in pairs]).T.astype(np.float32)
    sure = np.abs(np.sum(given[:4] * given[8:12], axis=0)) > 1e-5  # which way round is short
    for fraction in (0.0, 0.3, 0.5, 1.0):
        ours, exact = (
            np.concatenate(list(function.arrays(*rows, kind(fraction)).values()), axis=-1)
            for rows, kind in ((given, np.float32), (given.astype(np.float64), float))
        )
        error = np.linalg.norm(ours - exact, axis=-1) / np.linalg.norm(exact, axis=-1)
        assert error[sure].max() <= 6.1e-7, fraction
    assert function.backend("float32") == "c"


def test_derivatives_are_those_of_the_function(compiled: Path, rng: np.random.Generator) -> None:
    def turned(angle: Any, v: Any) -> Any:
        rotor = (-angle / 2 * EGA3.blade("e1^e2")).exp()
        return {"turned": rotor.sandwich(v), "square": v * v}

    function = compile_function(turned, algebra=EGA3, v="e1 e2 e3")
    angle, v, step = rng.normal(size=(5, 1)), rng.normal(size=(4, 3)), 1e-6
    made = function.jacobian("v")(angle, v)
    assert made["turned"].shape == (5, 4, 3, 3)
    assert made["square"].shape == (5, 4, 1, 3)
    for k in range(3):
        ahead, behind = (function.arrays(angle, v + s * step * np.eye(3)[k]) for s in (1, -1))
        slope = (ahead["turned"] - behind["turned"]) / (2 * step)
        np.testing.assert_allclose(made["turned"][..., k], slope, atol=1e-8)
    np.testing.assert_allclose(made["square"][0, :, 0], 2 * v, atol=1e-12)
    by_angle = function.jacobian("angle")
    ahead, behind = (function.arrays(angle + s * step, v)["turned"] for s in (1, -1))
    slopes = by_angle(angle, v)["turned"][..., 0]
    np.testing.assert_allclose(slopes, (ahead - behind) / (2 * step), atol=1e-8)
    assert by_angle.backend() == "c"
    with pytest.raises(ValueError, match="parameter: expected one of angle, v, got w"):
        function.jacobian("w")
