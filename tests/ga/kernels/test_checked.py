"""Kernels that look at their inputs find every number that is not finite, and no other."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor, kernels
from motorcade.ga.kernels import numpy_backend
from motorcade.ga.kernels.backend import checked_function
from motorcade.ga.versors.euler_angles import SEQUENCES

DTYPES = (np.float32, np.float64)
COUNTS = (1, 15, 16, 17, 54, 700, 5000)


@pytest.fixture(params=[checked_function, numpy_backend.checked_function])
def checked(request: pytest.FixtureRequest) -> Callable[[str], Callable[..., bool]]:
    return request.param


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("order", "CF")
def test_one_number_that_is_not_finite_is_found_wherever_it_lies(
    count: int, order: Any, dtype: Any, checked: Any, rng: np.random.Generator
) -> None:
    apply = checked("apply")
    motors = np.array(Motor.random(rng, (count,)).coefficients, dtype, order=order)
    points = np.array(rng.standard_normal((count, 3)), dtype, order=order)
    out = np.empty((count, 3), dtype)
    assert apply(motors, points, out) is True
    rounding = 100 * np.finfo(dtype).eps
    np.testing.assert_allclose(out, kernels.MOTORS.apply(motors, points), rtol=0, atol=rounding)
    for bad in (np.nan, np.inf, -np.inf):
        for row in {0, count // 2, count - 1}:
            for given in (motors, points):
                column = int(rng.integers(given.shape[1]))
                kept = given[row, column]
                given[row, column] = bad
                assert apply(motors, points, out) is False
                given[row, column] = kept
    points[...] = np.finfo(dtype).max
    assert apply(motors, points, out) is True, "too large to compute with is finite all the same"


def test_what_lies_beside_the_rows_is_not_looked_at(checked: Any) -> None:
    """Storage is padded; a row that serves all is looked at too."""
    storage = np.full((8, 48), np.nan)
    motors = storage[:, :33].T
    motors[...] = Motor.identity().coefficients
    out = np.empty((33, 8))
    assert checked("inverse")(motors, out) is True
    one = np.array(Motor.identity().coefficients)
    assert checked("apply")(one, np.zeros((33, 3)), np.empty((33, 3))) is True
    one[3] = np.inf
    assert checked("apply")(one, np.zeros((33, 3)), np.empty((33, 3))) is False


@pytest.mark.parametrize("kind", [Rotor, Motor, Similarity])
@pytest.mark.parametrize("dtype", DTYPES)
def test_large_batches_are_checked_by_all_threads(kind: type[Versor], dtype: Any) -> None:
    before = kernels.threads()
    kernels.set_threads(3)
    try:
        points = np.zeros((150_001, 3), dtype)
        one = kind.identity(dtype=dtype)
        for row in (0, 75_000, 150_000):
            points[row, 1] = np.nan
            with pytest.raises(
                ValueError, match=r"apply\(points\): expected finite numbers, got 1"
            ):
                one.apply(points)
            points[row, 1] = 0.0
        assert one.apply(points).dtype == dtype
    finally:
        kernels.set_threads(before)


def conversions() -> dict[str, tuple[Callable[[Any], Any], Any]]:
    """What makes versors of numbers, and numbers that it takes."""
    still = Rotor.identity()
    return {
        "quaternion": (Rotor.from_quaternion, [1.0, 0, 0, 0]),
        "rotation vector": (Rotor.from_rotation_vector, [0.1, 0.2, 0.3]),
        "rotation matrix": (Rotor.from_matrix, np.eye(3)),
        **{s: (lambda x, s=s: Rotor.from_euler(x, s), [0.1, 0.2, 0.3]) for s in SEQUENCES},
        "translation": (Motor.from_translation, [1.0, 2, 3]),
        "rotor and translation": (lambda t: Motor.from_rotor_translation(still, t), [1.0, 2, 3]),
        "quaternion and translation": (
            lambda t: Motor.from_quaternion_translation([1.0, 0, 0, 0], t), [1.0, 2, 3]),
        "matrix": (Motor.from_matrix, np.eye(4)),
        "dual quaternion": (Motor.from_dual_quaternion, [1.0, 0, 0, 0, 0, 0, 0, 0]),
        "twist": (Motor.from_twist, np.ones(6)),
        "similarity's matrix": (Similarity.from_matrix, np.diag([2.0, 2, 2, 1])),
        "similarity's twist": (Similarity.from_twist, np.ones(7)),
        "scale": (lambda s: Similarity.from_motor_scale(Motor.identity(), s), [2.0]),
        "rotor's normalize": (Rotor.normalize, [1.0, 2, 3, 4]),
        "motor's normalize": (Motor.normalize, np.arange(1.0, 9.0)),
    }  # fmt: skip


@pytest.mark.parametrize("name", conversions())
def test_conversions_refuse_what_is_not_finite_in_either_precision(name: str) -> None:
    make, good = conversions()[name]
    beside_doubles = {"rotor and translation", "quaternion and translation", "scale"}
    for dtype in DTYPES:
        batch = np.tile(np.asarray(good, dtype), (40, *(1,) * np.ndim(good)))
        assert make(batch).dtype == (np.float64 if name in beside_doubles else dtype)
        for bad in (np.nan, np.inf):
            batch[(37, *(0,) * np.ndim(good))] = bad
            with pytest.raises(ValueError, match="expected finite numbers, got 1 NaN or infinite"):
                make(batch)
            if name != "scale":
                with pytest.raises(ValueError, match="expected finite numbers"):
                    make(batch[37])


def test_matrices_of_all_layouts_are_read_alike(rng: np.random.Generator) -> None:
    motors = Motor.random(rng, (50,))
    plain = motors.as_matrix()
    for given in (np.array(plain, order="C"), np.array(plain, order="F"), plain[::-1][::-1]):
        again = Motor.from_matrix(given)
        np.testing.assert_array_equal(
            again.coefficients, Motor.from_matrix(plain.tolist()).coefficients
        )
    assert np.all(Motor.from_matrix(plain).isclose(motors, atol=1e-14))
