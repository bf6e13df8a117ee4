"""What is not a versor or a matching batch is refused by name; nothing is repaired."""

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.ga import Motor, Rotor, Similarity, Versor
from motorcade.ga.arrays import checked_floats, frozen
from motorcade.ga.classical import DualQuaternion, QuaternionPose


@pytest.mark.parametrize("shape", [(), (3,), (5,), (4, 1), (2, 7), (9,)])
def test_wrong_last_dimension_is_refused(kind: type[Versor], shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=rf"{kind.__name__}.coefficients: expected shape"):
        kind(np.zeros(shape))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_nan_and_infinity_are_refused(kind: type[Versor], bad: float) -> None:
    coefficients = np.array(kind.identity((3,)).coefficients)
    coefficients[1, 2] = bad
    with pytest.raises(ValueError, match="expected finite numbers, got 1 NaN or infinite"):
        kind(coefficients)
    with pytest.raises(ValueError, match="expected finite numbers"):
        kind.normalize(coefficients)
    with pytest.raises(ValueError, match="expected finite numbers"):
        kind.identity().apply([0.0, bad, 0.0])
    with pytest.raises(ValueError, match="expected finite numbers"):
        kind.identity().interpolate(kind.identity(), bad)
    with pytest.raises(ValueError, match="expected finite numbers"):
        kind.exp(np.full_like(kind.identity().log(), bad))


def test_zero_is_refused(kind: type[Versor]) -> None:
    zero = np.zeros_like(kind.identity((2,)).coefficients)
    with pytest.raises(ValueError, match="expected unit versors"):
        kind(zero)
    with pytest.raises(ValueError, match=r"expected .*non-zero.*, got 2 zero ones"):
        kind.normalize(zero)


def test_a_motor_without_rotation_part_has_no_direction() -> None:
    with pytest.raises(ValueError, match="non-zero rotor part"):
        Motor.normalize([0, 0, 0, 0, 1, 2, 3, 4])


@pytest.mark.parametrize("factor", [0.5, 1 + 2e-6, -1.1, 1e200])
def test_versors_that_are_not_unit_are_refused(kind: type[Versor], factor: float) -> None:
    with pytest.raises(ValueError, match=rf"{kind.__name__}.normalize projects"):
        kind(factor * kind.identity().coefficients)


def test_norms_within_tolerance_are_kept_as_they_are(kind: type[Versor]) -> None:
    given = (1 + 5e-7) * kind.identity().coefficients
    np.testing.assert_array_equal(kind(given).coefficients, given)


def test_motors_off_the_study_quadric_are_refused() -> None:
    with pytest.raises(ValueError, match=r"m0 m7 = m1 m4.* off by 0\.1"):
        Motor([1, 0, 0, 0, 0, 0, 0, 0.1])


def test_motors_far_from_the_origin_are_accepted(rng: np.random.Generator) -> None:
    far = Motor.random(rng, (100,), extent_m=1e9)
    Motor(far.coefficients)


@pytest.mark.parametrize("text", ["abc", ["a", "b"], [[1.0], [1.0, 2.0]], None, 1j, object()])
def test_what_is_no_number_is_refused(text: object) -> None:
    with pytest.raises(ValueError, match="field: expected"):
        checked_floats(text, "field", (2,))


def test_batches_that_do_not_broadcast_are_refused(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    three, four = kind.random(rng, (3,)), kind.random(rng, (4,))
    message = r"expected batch shapes that broadcast together, got \(3,\) and \(4,\)"
    with pytest.raises(ValueError, match=message):
        three @ four
    with pytest.raises(ValueError, match=message):
        three.interpolate(four, 0.5)
    with pytest.raises(ValueError, match=message):
        three.apply(np.zeros((4, 3)))
    with pytest.raises(ValueError, match="broadcast together"):
        three.interpolate(three, np.zeros(2))


def test_arrays_and_motors_do_not_mix(rng: np.random.Generator) -> None:
    with pytest.raises(TypeError):
        Motor.random(rng) @ np.eye(4)
    with pytest.raises(TypeError):
        np.eye(4) @ Motor.random(rng)


def test_two_types_of_versor_have_no_path_between(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    for other in {Rotor, Motor, Similarity} - {kind}:
        for shape in ((), (3,)):
            one, two = kind.random(rng, shape), other.random(rng, shape)
            with pytest.raises((TypeError, ValueError), match="expected"):
                one.interpolate(two, 0.5)


@pytest.mark.parametrize("dtype", [np.float32, np.float16, np.int64, np.uint8, np.bool_])
def test_other_real_numbers_are_read_as_they_are(kind: type[Versor], dtype: type) -> None:
    given = np.asarray(kind.identity((2,)).coefficients, dtype=dtype)
    np.testing.assert_array_equal(kind(given).coefficients, kind.identity((2,)).coefficients)
    expected = np.float32 if dtype is np.float32 else np.float64
    assert kind(given).coefficients.dtype == expected
    points = kind.identity().apply(np.array([1, 0, 1], dtype=dtype))
    np.testing.assert_array_equal(points, [1.0, 0.0, 1.0])


@pytest.mark.parametrize("dtype", [np.complex128, object, "datetime64[ns]", str])
def test_what_is_not_real_is_refused(kind: type[Versor], dtype: object) -> None:
    given = np.zeros(kind.identity().coefficients.shape, dtype=np.int64).astype(dtype)
    with pytest.raises(ValueError, match="expected real numbers"):
        kind(given)
    with pytest.raises(ValueError, match="expected real numbers"):
        kind.normalize(given)


def test_points_need_three_coordinates(kind: type[Versor]) -> None:
    with pytest.raises(ValueError, match=r"apply\(points\): expected shape \(\*, 3\)"):
        kind.identity().apply([1.0, 2.0])


def test_matrices_that_are_no_rotations_are_refused() -> None:
    with pytest.raises(ValueError, match="expected determinant"):
        Rotor.from_matrix(np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(ValueError, match=r"Rotor\.nearest gives the nearest rotation"):
        Rotor.from_matrix(np.eye(3) + 1e-3 * np.eye(3)[[1, 0, 2]])
    for scale in (1.001, 2.0, 0.01):
        with pytest.raises(ValueError, match=r"a scale, which Similarity\.from_matrix reads"):
            Rotor.from_matrix(scale * np.eye(3))
    with pytest.raises(ValueError, match=r"expected shape \(\*, 3, 3\)"):
        Rotor.from_matrix(np.eye(4))
    bottom = np.eye(4)
    bottom[3, 0] = 1e-3
    with pytest.raises(ValueError, match="expected the last row 0 0 0 1"):
        Motor.from_matrix(bottom)


@pytest.mark.parametrize("value", [1e200, 1e308])
def test_numbers_whose_squares_overflow_are_refused_without_a_warning(value: float) -> None:
    for make in (
        lambda: Rotor.from_quaternion([value] * 4),
        lambda: Motor.from_quaternion_translation([value] * 4, [0.0, 0.0, 0.0]),
        lambda: Rotor.from_matrix(np.full((3, 3), value)),
        lambda: Rotor.from_matrix([[value, 0, 0], [0, -value, 0], [value, value, 1]]),
        lambda: QuaternionPose([value] * 7),
        lambda: DualQuaternion([value] * 8),
        lambda: DualQuaternion([1.0, 0.0, 0.0, 0.0, value, -value, value, value]),
    ):
        with pytest.raises(ValueError, match="expected"):
            make()


def test_quaternions_that_are_not_unit_are_refused() -> None:
    with pytest.raises(ValueError, match=r"from_quaternion\(wxyz\): expected unit quaternions"):
        Rotor.from_quaternion([0.9, 0.1, 0.0, 0.0])


@pytest.mark.parametrize("sequence", ["", "xy", "xxy", "XYZ", "abc", "xyzx"])
def test_unknown_euler_sequences_are_refused(sequence: str) -> None:
    with pytest.raises(ValueError, match="sequence: expected one of xyz"):
        Rotor.from_euler([0.1, 0.2, 0.3], sequence)
    with pytest.raises(ValueError, match="sequence: expected one of xyz"):
        Rotor.identity().as_euler(sequence)


def test_nothing_can_be_stacked_from_nothing(kind: type[Versor]) -> None:
    with pytest.raises(ValueError, match="expected one or more, got none"):
        kind.stack([])
    with pytest.raises(ValueError, match="stack joins single ones"):
        kind.concatenate([kind.identity()])


def test_a_single_versor_has_no_batch(kind: type[Versor]) -> None:
    with pytest.raises(TypeError, match="has no length"):
        len(kind.identity())
    with pytest.raises(IndexError, match="has no batch"):
        kind.identity()[0]


def test_values_are_frozen(kind: type[Versor], rng: np.random.Generator) -> None:
    versor = kind.random(rng, (3,))
    made = (
        versor,
        versor @ versor,
        versor[1],
        versor.reshape(3, 1),
        versor.inverse(),
        kind.stack(list(versor)),
        kind(versor.coefficients),
        pickle.loads(pickle.dumps(versor)),
        copy.deepcopy(versor),
    )
    for one in made:
        with pytest.raises(ValueError, match="read-only"):
            one.coefficients[..., 0] = 2.0
    with pytest.raises(AttributeError):
        versor.coefficients = versor.coefficients


def test_what_a_caller_passes_in_stays_his(kind: type[Versor], rng: np.random.Generator) -> None:
    given = np.array(kind.random(rng, (3,)).coefficients)
    kept = given.copy()
    versor = kind(given)
    given[0] = 0.0
    np.testing.assert_array_equal(versor.coefficients, kept)
    log = versor.log()
    before = log.copy()
    kind.exp(log)
    log += 1.0
    np.testing.assert_array_equal(versor.log(), before)


def test_strided_and_read_only_inputs_are_read_in_place(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    plain = kind.random(rng, (6,))
    wide = np.zeros((6, 2 * plain.coefficients.shape[1]))
    wide[:, ::2] = plain.coefficients
    strided = frozen(wide)[::-1, ::2]
    np.testing.assert_array_equal(kind(strided).coefficients, plain.coefficients[::-1])
    turned = plain[::-1] @ plain
    np.testing.assert_array_equal(turned.coefficients[::-1], (plain @ plain[::-1]).coefficients)
    single = np.asarray(plain.coefficients, dtype=np.float32)
    assert kind.normalize(single).coefficients.dtype == np.float32


def test_the_nearest_rotation_is_that_of_another_library(rng: np.random.Generator) -> None:
    """Scipy turns noisy matrices into rotations by the same criterion, with another algorithm."""
    exact = Rotation.random(50, random_state=7)
    noisy = exact.as_matrix() + 0.05 * rng.standard_normal((50, 3, 3))
    nearest = Rotor.nearest(noisy).as_matrix()
    np.testing.assert_allclose(nearest, Rotation.from_matrix(noisy).as_matrix(), atol=1e-12)
    reflected = Rotor.nearest(np.diag([1.0, 1.0, -1.0])).as_matrix()
    np.testing.assert_allclose(np.linalg.det(reflected), 1.0)
    with pytest.raises(ValueError, match="rank 2 or 3"):
        Rotor.nearest(np.diag([1.0, 0.0, 0.0]))


@pytest.mark.parametrize("rng", [(3,), 7, None])
def test_random_versors_want_a_generator(kind: type[Versor], rng: Any) -> None:
    with pytest.raises(TypeError, match=r"random\(rng\): expected a numpy\.random\.Generator"):
        kind.random(rng)  # type: ignore[attr-defined]


def test_matrices_with_noise_have_a_nearest_motor() -> None:
    rng = np.random.default_rng(2)
    motors = Motor.random(rng, (50,))
    noisy = motors.as_matrix()
    noisy[..., :3, :3] += 2.5e-4 * rng.standard_normal((50, 3, 3))
    with pytest.raises(ValueError, match="nearest"):
        Motor.from_matrix(noisy)
    found = Motor.nearest(noisy)
    np.testing.assert_allclose(found.translation_m, motors.translation_m, atol=1e-12)
    assert np.all((~motors @ found).rotor.angle() < 2e-3)
    rotations, polar = found.rotor.as_matrix(), np.linalg.svd(noisy[..., :3, :3])
    np.testing.assert_allclose(rotations, polar.U @ polar.Vh, atol=1e-12)
    with pytest.raises(ValueError, match="last row"):
        Motor.nearest(np.ones((4, 4)))
