"""What a NumPy user expects of versors: precision, comparison, coefficients that stay put."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
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


def test_equality_is_of_values_and_hashes_agree_with_it(kind: type[Versor]) -> None:
    rng = np.random.default_rng(5)
    single, batch = kind.random(rng), kind.random(rng, (3,))
    for versor in (single, batch):
        same = kind(versor.coefficients.copy())
        assert versor == same
        assert hash(versor) == hash(same)
        assert versor != versor.astype(np.float32)
        assert versor != kind.random(rng, versor.shape)
    assert single != batch[:1]
    assert kind.identity() == kind(kind.identity().coefficients * [1.0, *[-1.0] * (kind._size - 1)])
    there_and_back = -kind.identity()
    assert hash(kind.identity()) == hash(-there_and_back)


def test_versors_live_among_strangers(kind: type[Versor]) -> None:
    rng = np.random.default_rng(6)
    versor, other = kind.random(rng), kind.random(rng)
    assert (versor == None) is False  # noqa: E711 (what careless code does)
    assert (versor == 3.0) is False
    assert versor in [None, "a", other, versor]
    assert other not in [versor, None]
    assert {versor: "one", other: "another"}[kind(versor.coefficients)] == "one"

    @dataclass(frozen=True)
    class Named:
        name: str
        pose: Versor

    assert Named("a", versor) == Named("a", versor)
    assert Named("a", versor) != Named("a", other)


def test_numpy_sees_the_coefficients(kind: type[Versor]) -> None:
    versors = kind.random(np.random.default_rng(7), (4,))
    np.testing.assert_array_equal(np.asarray(versors), versors.coefficients)
    np.testing.assert_array_equal(np.stack([versors, versors])[1], versors.coefficients)
    np.testing.assert_array_equal(np.concatenate([versors, versors])[4:], versors.coefficients)
    assert np.asarray(versors, np.float32).dtype == np.float32
    assert versors.reshape((2, 2)).shape == versors.reshape(2, -1).shape == (2, 2)


def test_coefficients_are_taken_for_nothing_else(kind: type[Versor]) -> None:
    versor = kind.identity()
    for call in (versor.apply, kind, Rotor.from_quaternion, Rotor.from_rotation_vector):
        with pytest.raises(ValueError, match=f"expected numbers, got a {kind.__name__}"):
            call(versor)


def test_operators_say_what_the_verbs_say(kind: type[Versor]) -> None:
    rng = np.random.default_rng(8)
    a, b = kind.random(rng, (5,)), kind.random(rng, (5,))
    assert a * b == a @ b
    assert ~a == a.inverse()
    assert np.all((-a).isclose(a))
    np.testing.assert_array_equal((-a).coefficients, -a.coefficients)
    half = a**0.5
    assert np.all((half @ half).isclose(a, atol=1e-12))
    assert np.all((a**-1).isclose(~a, atol=1e-12))
    assert np.all((a**0).isclose(kind.identity()))


def test_types_that_hold_less_are_promoted() -> None:
    rng = np.random.default_rng(9)
    points = rng.normal(size=(7, 3))
    kinds = (Rotor, Motor, Similarity)
    for first, second in itertools.product(kinds, kinds):
        a, b = first.random(rng, (7,)), second.random(rng, (7,))
        composed = a @ b
        assert type(composed) is max(first, second, key=lambda one: one._size)
        np.testing.assert_allclose(composed.apply(points), a.apply(b.apply(points)), atol=1e-12)
    with pytest.raises(TypeError):
        Rotor.identity() @ np.eye(3)


def test_formats_write_the_sum_of_blades() -> None:
    moved = Motor.from_translation([1.0, 2.0, 3.0])
    assert f"{moved:.1f}".endswith("-0.5 e1^einf -1.0 e2^einf -1.5 e3^einf +0.0 e1^e2^e3^einf")
    assert f"{moved:.3f}".startswith("+1.000 +0.000 e2^e3 ")
    assert f"{moved}" == repr(moved)
    assert f"{Motor.identity((2,)):.3f}" == "Motor(shape=(2,))"
