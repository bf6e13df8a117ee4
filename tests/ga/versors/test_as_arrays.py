"""What a NumPy user expects of versors: precision, comparison, coefficients that stay put."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor

SINGLE, DOUBLE = np.dtype(np.float32), np.dtype(np.float64)


def zeros(*shape: int) -> Callable[[Any], np.ndarray]:
    return lambda dtype: np.zeros(shape, dtype)


def wxyz(dtype: Any) -> np.ndarray:
    return np.array([1.0, 0.0, 0.0, 0.0], dtype)


ONE_ARRAY: dict[str, tuple[Callable[[Any], Any], Callable[[Any], np.ndarray]]] = {
    "Rotor": (Rotor, wxyz),
    "Rotor.normalize": (Rotor.normalize, wxyz),
    "Rotor.exp": (Rotor.exp, zeros(5, 3)),
    "Rotor.from_quaternion": (Rotor.from_quaternion, wxyz),
    "Rotor.from_rotation_vector": (Rotor.from_rotation_vector, zeros(3)),
    "Rotor.from_matrix": (Rotor.from_matrix, lambda dtype: np.eye(3, dtype=dtype)),
    "Rotor.from_euler": (Rotor.from_euler, zeros(2, 3)),
    "Motor.exp": (Motor.exp, zeros(6)),
    "Motor.normalize": (Motor.normalize, lambda dtype: np.eye(8, dtype=dtype)[0]),
    "Motor.from_twist": (Motor.from_twist, zeros(6)),
    "Motor.from_translation": (Motor.from_translation, zeros(20, 3)),
    "Motor.from_matrix": (Motor.from_matrix, lambda dtype: np.eye(4, dtype=dtype)),
    "Motor.from_dual_quaternion": (
        Motor.from_dual_quaternion, lambda dtype: np.eye(8, dtype=dtype)[0],
    ),
    "Similarity.exp": (Similarity.exp, zeros(7)),
    "Similarity.from_twist": (Similarity.from_twist, zeros(4, 7)),
    "Similarity.from_matrix": (Similarity.from_matrix, lambda dtype: np.eye(4, dtype=dtype)),
}  # fmt: skip

TWO_ARRAYS: dict[str, tuple[Callable[[Any, Any], Any], Any, Any]] = {
    "from_rotor_translation": (
        Motor.from_rotor_translation, lambda dtype: Rotor(wxyz(dtype)), zeros(3),
    ),
    "from_quaternion_translation": (Motor.from_quaternion_translation, wxyz, zeros(2, 3)),
    "from_euler_translation": (Motor.from_euler_translation, zeros(3), zeros(3)),
    "from_motor_scale": (
        Similarity.from_motor_scale,
        lambda dtype: Motor.identity((20,), dtype),
        lambda dtype: np.ones(20, dtype),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ONE_ARRAY)
def test_constructors_follow_the_precision_of_their_array(name: str) -> None:
    make, given = ONE_ARRAY[name]
    assert make(given(np.float32)).dtype == SINGLE
    assert make(given(np.float64)).dtype == DOUBLE
    assert make(given(np.float64).tolist()).dtype == DOUBLE
    assert make(given(np.float64).astype(np.int64)).dtype == DOUBLE


@pytest.mark.parametrize("name", TWO_ARRAYS)
def test_constructors_of_two_arrays_promote_as_numpy_does(name: str) -> None:
    make, first, second = TWO_ARRAYS[name]
    for one in (np.float32, np.float64):
        for two in (np.float32, np.float64):
            assert make(first(one), second(two)).dtype == np.result_type(one, two)
    assert make(first(np.float32), second(np.float32).tolist()).dtype == SINGLE


def test_similarities_of_three_parts_promote_too() -> None:
    rotor = Rotor.identity(dtype=np.float32)
    make = Similarity.from_rotor_translation_scale
    assert make(rotor, np.zeros(3, np.float32), 2.0).dtype == SINGLE
    assert make(rotor, np.zeros(3), np.float32(2.0)).dtype == DOUBLE
    assert make(rotor, np.zeros(3, np.float32), np.float64(2.0)).dtype == DOUBLE


def test_what_float32_makes_composes_with_float32(kind: type[Versor]) -> None:
    one = kind.identity((3,), np.float32)
    assert (one @ kind.exp(np.zeros(one.log().shape[-1], np.float32))).dtype == SINGLE


def test_identity_has_the_precision_that_is_asked_for(kind: type[Versor]) -> None:
    assert kind.identity().dtype == kind.identity((2,)).dtype == DOUBLE
    single = kind.identity((2, 3), dtype="float32")
    assert single.dtype == SINGLE
    np.testing.assert_array_equal(single.coefficients, kind.identity((2, 3)).coefficients)
    with pytest.raises(ValueError, match=r"identity: expected float32 or float64, got int64"):
        kind.identity((), dtype=np.int64)


def test_coefficients_cannot_be_made_writable(kind: type[Versor], rng: np.random.Generator) -> None:
    given = np.array(kind.random(rng, (5,)).coefficients)
    many = kind.random(rng, (40,))
    for versor in (
        kind(given), kind.identity(), kind.identity((30,)), many, many[3], many[4:9], many @ many,
        many.inverse(), many[0] @ many[0], many.reshape(8, 5), many.astype(np.float32),
        kind.stack([many, many]), kind.exp(many.log()), many.retract(many.log()),
    ):  # fmt: skip
        with pytest.raises(ValueError, match="WRITEABLE"):
            versor.coefficients.flags.writeable = True
        with pytest.raises(ValueError, match="read-only"):
            versor.coefficients[..., 0] = 0.0
    given[:] = 0.0  # the caller's own array stays the caller's


def test_both_signs_are_close(versors: Versor) -> None:
    negative = type(versors)(-versors.coefficients)
    assert np.all(versors.isclose(versors))
    assert np.all(versors.isclose(negative))
    assert versors.isclose(negative).shape == versors.shape


def test_isclose_tells_motions_apart(kind: type[Versor], rng: np.random.Generator) -> None:
    one, size = kind.random(rng, (4, 1)), kind.identity().log().size
    near, far = one.retract(np.full(size, 1e-9)), one.retract(np.full(size, 1e-2))
    assert np.all(one.isclose(near))
    assert not np.any(one.isclose(far))
    assert np.all(one.isclose(far, atol=1.0))
    assert not np.any(one.isclose(near, rtol=0.0, atol=1e-12))
    assert one.isclose(kind.random(rng, (3,))).shape == (4, 3)


def test_isclose_refuses_what_cannot_be_compared(kind: type[Versor]) -> None:
    one = kind.identity((3,))
    other = Rotor.identity() if kind is not Rotor else Motor.identity()
    with pytest.raises(TypeError, match=rf"expected a {kind.__name__}, got {type(other).__name__}"):
        one.isclose(other)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="one precision"):
        one.isclose(one.astype(np.float32))
    with pytest.raises(ValueError, match=r"\(3,\) and \(2,\)"):
        one.isclose(kind.identity((2,)))


def test_equality_and_hashes_are_refused(kind: type[Versor]) -> None:
    one = kind.identity()
    for compare in (lambda: one == one, lambda: one != kind.identity(), lambda: one == 3):
        with pytest.raises(TypeError, match="isclose compares motions"):
            compare()
    with pytest.raises(TypeError, match="unhashable"):
        hash(one)
