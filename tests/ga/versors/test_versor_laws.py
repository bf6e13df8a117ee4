"""Group laws of rotors, motors and similarities, each on every hard sample."""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor

Distance = Callable[[Versor, Versor], float]
ROUNDING = 2e-14


def identity_like(versors: Versor) -> Versor:
    return type(versors).identity(versors.shape)


def test_exp_undoes_log(versors: Versor, distance: Distance) -> None:
    assert distance(type(versors).exp(versors.log()), versors) < ROUNDING


def test_log_undoes_exp_up_to_half_a_turn(kind: type[Versor], rng: np.random.Generator) -> None:
    size = kind.identity().log().size
    log = rng.standard_normal((9, 50, size))
    angles = np.array([0, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 1, 3, np.pi - 1e-6])
    log[..., :3] *= 0.5 * angles[:, None, None] / np.linalg.norm(log[..., :3], axis=-1)[..., None]
    np.testing.assert_allclose(kind.exp(log).log(), log, rtol=0, atol=ROUNDING)


def test_log_keeps_relative_precision_of_tiny_rotations(kind: type[Versor]) -> None:
    log = np.zeros_like(kind.identity().log())
    log[:3] = 1e-12, -2e-13, 3e-150
    np.testing.assert_allclose(kind.exp(log).log(), log, rtol=1e-15, atol=0)


def test_log_turns_by_half_a_turn_at_most(versors: Versor) -> None:
    assert np.all(2 * np.linalg.norm(versors.log()[..., :3], axis=-1) <= np.pi + 1e-15)


def test_log_does_not_depend_on_the_sign_below_half_a_turn(
    versors: Versor, distance: Distance
) -> None:
    negative = type(versors)(-versors.coefficients)
    turns_less = np.abs(versors.coefficients[..., 0]) > 0
    np.testing.assert_array_equal(negative.log()[turns_less], versors.log()[turns_less])
    assert distance(type(versors).exp(negative.log()), versors) < ROUNDING


def test_composition_is_associative(versors: Versor, others: Versor, distance: Distance) -> None:
    left = (versors @ others) @ versors
    assert distance(versors @ (others @ versors), left) < ROUNDING


def test_inverse_cancels_on_both_sides(versors: Versor) -> None:
    scale = max(1.0, float(np.max(np.abs(versors.coefficients))))
    for product in (versors @ versors.inverse(), versors.inverse() @ versors):
        difference = product.coefficients - identity_like(versors).coefficients
        assert np.max(np.abs(difference)) < ROUNDING * scale


def test_inverse_of_a_product_turns_the_order_round(
    versors: Versor, others: Versor, distance: Distance
) -> None:
    turned = others.inverse() @ versors.inverse()
    assert distance((versors @ others).inverse(), turned) < ROUNDING


def test_identity_changes_nothing(versors: Versor) -> None:
    for product in (versors @ identity_like(versors), identity_like(versors) @ versors):
        np.testing.assert_array_equal(product.coefficients, versors.coefficients)


def test_acting_twice_is_acting_by_the_product(
    versors: Versor, others: Versor, rng: np.random.Generator
) -> None:
    points = rng.standard_normal((*versors.shape, 3))
    once = (versors @ others).apply(points)
    scale = max(1.0, float(np.max(np.abs(once))))
    np.testing.assert_allclose(
        versors.apply(others.apply(points)), once, rtol=0, atol=ROUNDING * scale
    )


def test_action_is_the_matrix(versors: Versor, rng: np.random.Generator) -> None:
    points = rng.standard_normal((*versors.shape, 3))
    matrix = np.asarray(versors.as_matrix())
    witness = (matrix[..., :3, :3] @ points[..., None])[..., 0]
    if matrix.shape[-1] == 4:
        witness += matrix[..., :3, 3]
    scale = max(1.0, float(np.max(np.abs(witness))))
    np.testing.assert_allclose(versors.apply(points), witness, rtol=0, atol=ROUNDING * scale)


def test_matrix_of_the_product_is_the_product_of_matrices(versors: Versor, others: Versor) -> None:
    product = versors.as_matrix() @ others.as_matrix()
    scale = max(1.0, float(np.max(np.abs(product))))
    np.testing.assert_allclose(
        (versors @ others).as_matrix(), product, rtol=0, atol=ROUNDING * scale
    )


def test_matrices_come_back(versors: Versor, distance: Distance) -> None:
    again = type(versors).from_matrix(versors.as_matrix())
    assert distance(again, versors) < ROUNDING
    same = np.minimum(
        *(
            np.max(np.abs(again.coefficients - sign * versors.coefficients), axis=-1)
            for sign in (1, -1)
        )
    )
    assert np.all(same < ROUNDING * max(1.0, float(np.max(np.abs(versors.coefficients)))))


def test_inverse_takes_points_back(versors: Versor, rng: np.random.Generator) -> None:
    points = rng.standard_normal((*versors.shape, 3))
    moved = versors.apply(points)
    scale = max(1.0, float(np.max(np.abs(moved))))
    np.testing.assert_allclose(
        versors.inverse().apply(moved), points, rtol=0, atol=ROUNDING * scale
    )


def test_products_stay_unit(versors: Versor, others: Versor) -> None:
    # The constructor refuses what is not unit.
    type(versors)((versors @ others).coefficients)
    type(versors)(type(versors).exp(versors.log()).coefficients)


def test_normalize_leaves_unit_versors_alone(versors: Versor) -> None:
    scale = max(1.0, float(np.max(np.abs(versors.coefficients))))
    again = type(versors).normalize(versors.coefficients)
    np.testing.assert_allclose(
        again.coefficients, versors.coefficients, rtol=0, atol=ROUNDING * scale
    )


def test_normalize_does_not_depend_on_scale(versors: Versor) -> None:
    for factor in (1e-200, 3.0, 1e150):
        scaled = type(versors).normalize(factor * versors.coefficients)
        np.testing.assert_allclose(
            scaled.coefficients,
            type(versors).normalize(versors.coefficients).coefficients,
            rtol=1e-14,
            atol=1e-14,
        )


def test_normalize_makes_any_even_element_a_motion(rng: np.random.Generator) -> None:
    elements = rng.standard_normal((100, 8))
    made = Motor(Motor.normalize(elements).coefficients)
    rotation = made.as_matrix()[:, :3, :3]
    eye = np.broadcast_to(np.eye(3), rotation.shape)
    np.testing.assert_allclose(rotation @ np.swapaxes(rotation, 1, 2), eye, rtol=0, atol=1e-14)


def test_motor_is_its_translation_after_its_rotor(motors: Motor, distance: Distance) -> None:
    again = Motor.from_rotor_translation(motors.rotor, motors.translation_m)
    assert distance(again, motors) < ROUNDING
    shift = Motor.from_rotor_translation(Rotor.identity(motors.shape), motors.translation_m)
    turn = Motor.from_rotor_translation(motors.rotor, np.zeros(3))
    assert distance(shift @ turn, motors) < ROUNDING


def test_one_versor_serves_a_whole_batch(kind: type[Versor], rng: np.random.Generator) -> None:
    one, many = kind.random(rng), kind.random(rng, (4, 3))
    product = one @ many
    assert product.shape == (4, 3)
    np.testing.assert_allclose(
        product[2, 1].coefficients, (one @ many[2, 1]).coefficients, rtol=0, atol=1e-15
    )
    columns = kind.random(rng, (4, 1)) @ kind.random(rng, (3,))
    assert columns.shape == (4, 3)


def test_points_broadcast_against_versors(kind: type[Versor], rng: np.random.Generator) -> None:
    versors, cloud = kind.random(rng, (5,)), rng.standard_normal((7, 3))
    moved = versors[:, None].apply(cloud)
    assert moved.shape == (5, 7, 3)
    np.testing.assert_allclose(moved[3], versors[3].apply(cloud), rtol=0, atol=1e-15)


def test_empty_batches_pass_through_every_verb(kind: type[Versor]) -> None:
    none = kind.identity((0, 4))
    assert none.log().shape == (0, 4, *kind.identity().log().shape)
    assert kind.exp(none.log()).shape == (0, 4)
    assert (none @ none.inverse()).interpolate(none, 0.5).shape == (0, 4)
    assert none.apply(np.zeros((0, 4, 3))).shape == (0, 4, 3)
    assert kind(none.coefficients).as_matrix().shape[:2] == (0, 4)
    assert kind.normalize(none.coefficients).shape == (0, 4)


def test_random_is_reproducible(kind: type[Versor]) -> None:
    one, two = (kind.random(np.random.default_rng(5), (3,)) for _ in range(2))
    np.testing.assert_array_equal(one.coefficients, two.coefficients)


def test_random_rotations_are_uniform(rng: np.random.Generator) -> None:
    # The angle of a uniform rotation has density (1 - cos φ) / π, hence mean π/2 + 2/π.
    angles = Rotor.random(rng, (20000,)).angle()
    assert np.mean(angles) == pytest.approx(np.pi / 2 + 2 / np.pi, abs=0.02)


def test_batches_stack_index_and_reshape_like_arrays(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    batch = kind.random(rng, (4, 3))
    rows = list(batch)
    assert len(batch) == len(rows) == 4
    np.testing.assert_array_equal(kind.stack(rows).coefficients, batch.coefficients)
    np.testing.assert_array_equal(
        kind.concatenate(rows).coefficients, batch.reshape(12).coefficients
    )
    np.testing.assert_array_equal(batch[..., 1].coefficients, batch.coefficients[:, 1])
    np.testing.assert_array_equal(batch[np.array([2, 0])].coefficients, batch.coefficients[[2, 0]])
    assert batch[None].shape == (1, 4, 3)
    assert batch[batch.coefficients[..., 0] > 2].shape == (0,)


@pytest.mark.parametrize("motions", [Motor, Similarity])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_no_translation_is_a_negative_zero(
    motions: type[Motor] | type[Similarity], dtype: type
) -> None:
    turned = motions.from_twist(np.array([0.1, -0.2, 0.3, *np.zeros(motions._log_size - 3)], dtype))
    for motion in (motions.identity(dtype=dtype), turned, turned.inverse()):
        assert motion.translation_m.dtype == dtype
        assert not np.signbit(motion.translation_m[motion.translation_m == 0.0]).any()
    assert not motions.identity().translation_m.any()
