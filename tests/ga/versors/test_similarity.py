"""Similarities: conversions, refusals, and the laws for scales from a thousandth to a thousand."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, kernels
from tests.ga.cases import over

SCALES = (1e-12, 1e-3, 0.01, 0.25, 1 - 1e-7, 1.0, 1 + 1e-12, 2.0, 4.0, 30.0, 1e3, 1e12)
EPS = float(np.finfo(float).eps)


def off(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference, relative to the largest entry, over a batch of vectors."""
    size = np.maximum(1.0, np.max(np.abs(b), axis=-1, keepdims=True))
    return float(np.max(np.abs(a - b) / size))


def numbers(similarity: Similarity) -> np.ndarray:
    """Matrices as vectors, whose largest entry may be that of another row."""
    return similarity.as_matrix().reshape(*similarity.shape, 16)


def bound(scale: float) -> float:
    return 16 * EPS * max(scale, 1 / scale)


@over(scale=SCALES)
def test_exp_undoes_log_at_every_scale(scale: float, motors: Motor) -> None:
    grown = Similarity.from_motor_scale(motors, scale)
    signs = np.where(grown.coefficients[..., :1] < 0, -1.0, 1.0)
    assert off(Similarity.exp(grown.log()).coefficients, signs * grown.coefficients) < bound(4)


@over(scale=SCALES)
def test_inverse_cancels_at_every_scale(scale: float, motors: Motor) -> None:
    grown = Similarity.from_motor_scale(motors, scale)
    size = max(1.0, float(np.max(np.abs(grown.translation_m)))) / min(1.0, scale)
    for product in (grown @ grown.inverse(), grown.inverse() @ grown):
        difference = product.coefficients - np.eye(12)[0]
        assert np.max(np.abs(difference)) < bound(scale) * size


@over(scale=SCALES)
def test_parts_come_back_at_every_scale(scale: float, motors: Motor) -> None:
    grown = Similarity.from_motor_scale(motors, scale)
    motor, back = grown.as_motor_scale()
    assert off(motor.coefficients, motors.coefficients) < bound(4)
    np.testing.assert_allclose(back, np.full(motors.shape, scale), rtol=32 * EPS)
    again = Similarity.from_rotor_translation_scale(*grown.as_rotor_translation_scale())
    assert off(again.coefficients, grown.coefficients) < bound(4)
    Similarity(grown.coefficients)


@over(scale=SCALES)
def test_matrices_come_back_at_every_scale(scale: float, motors: Motor) -> None:
    grown = Similarity.from_motor_scale(motors, scale)
    again = Similarity.from_matrix(grown.as_matrix())
    np.testing.assert_allclose(again.scale, grown.scale, rtol=32 * EPS)
    assert off(again.rotor.as_matrix(), grown.rotor.as_matrix()) < bound(1)
    np.testing.assert_allclose(again.translation_m, grown.translation_m, rtol=1e-13, atol=1e-14)


@over(scale=SCALES)
def test_action_is_the_matrix(scale: float, motors: Motor, rng: np.random.Generator) -> None:
    grown = Similarity.from_motor_scale(motors, scale)
    points = rng.standard_normal((*motors.shape, 3))
    column = np.concatenate([points, np.ones((*motors.shape, 1))], axis=-1)[..., None]
    witness = (grown.as_matrix() @ column)[..., :3, 0]
    assert off(grown.apply(points), witness) < bound(scale)


def test_a_similarity_without_growth_is_its_motor(motors: Motor, rng: np.random.Generator) -> None:
    still = Similarity.from_motor_scale(motors)
    np.testing.assert_array_equal(still.coefficients[..., 4:8], 0.0)
    with_motor = [0, 1, 2, 4, 5, 6]
    assert off(still.log()[..., with_motor], motors.log()) < bound(1)
    other = Motor.random(rng, motors.shape)
    product = still @ Similarity.from_motor_scale(other)
    witness = (motors @ other).coefficients
    assert off(product.coefficients[..., [0, 1, 2, 3, 8, 9, 10, 11]], witness) < bound(1)


@pytest.mark.parametrize("growth", [1e-5, 1e-2, 1 + 1e-6, 50.0, 1e5])
def test_float32_keeps_its_own_rounding_at_every_scale(growth: float, motors: Motor) -> None:
    single, eps = motors.astype(np.float32), float(np.finfo(np.float32).eps)
    grown = Similarity.from_motor_scale(single, growth)
    motor, scale = grown.as_motor_scale()
    assert {grown.dtype, motor.dtype, scale.dtype} == {np.dtype(np.float32)}
    np.testing.assert_allclose(scale, np.float32(growth), rtol=16 * eps)
    assert off(motor.coefficients, single.coefficients) < 16 * eps
    signs = np.where(grown.coefficients[..., :1] < 0, -1.0, 1.0)
    assert off(Similarity.exp(grown.log()).coefficients, signs * grown.coefficients) < 32 * eps
    Similarity(grown.coefficients)


def test_tiny_growth_keeps_its_relative_precision() -> None:
    for log_scale in (1e-300, 1e-12, -1e-9, 1e-3):
        made = Similarity.exp([0.0, 0.0, 0.0, 0.5 * log_scale, 0.0, 0.0, 0.0])
        assert made.log()[3] == pytest.approx(0.5 * log_scale, rel=1e-15, abs=0.0)


@over(scale=SCALES)
def test_products_are_associative_at_every_scale(
    scale: float, motors: Motor, rng: np.random.Generator
) -> None:
    a = Similarity.from_motor_scale(motors, scale)
    b, c = (Similarity.random(rng, motors.shape) for _ in range(2))
    assert off(((a @ b) @ c).as_matrix(), (a @ (b @ c)).as_matrix()) < 32 * bound(scale)


@over(scale=SCALES)
def test_paths_have_even_speed_and_meet_their_ends_at_every_scale(
    scale: float, motors: Motor
) -> None:
    start, end = Similarity.identity(motors.shape), Similarity.from_motor_scale(motors, scale)
    fractions = np.linspace(0, 1, 9).reshape(9, *(1 for _ in motors.shape))
    path = start.interpolate(end, fractions)
    assert off(numbers(path[0]), numbers(start)) < bound(4)
    assert off(numbers(path[-1]), numbers(end)) < 8 * bound(scale)
    steps = (path[:-1].inverse() @ path[1:]).log()
    assert off(8.0 * steps, np.broadcast_to(end.log(), steps.shape)) < 8 * bound(scale)


def test_growth_along_the_path_is_even(rng: np.random.Generator) -> None:
    start, end = Similarity.random(rng, (20,)), Similarity.random(rng, (20,))
    path = start.interpolate(end, np.linspace(0, 1, 6)[:, None])
    ratios = path.scale[1:] / path.scale[:-1]
    np.testing.assert_allclose(ratios, np.broadcast_to(ratios[0], ratios.shape), rtol=1e-13)


@over(scale=SCALES)
def test_projection_restores_what_was_scaled_and_rounded(
    scale: float, motors: Motor, rng: np.random.Generator
) -> None:
    grown = Similarity.from_motor_scale(motors, scale)
    again = Similarity.normalize(7.0 * grown.coefficients)
    assert off(again.coefficients, grown.coefficients) < bound(scale)
    rounded = grown.coefficients.astype(np.float32).astype(np.float64)
    if 0.1 < scale < 10:
        near = Similarity(Similarity.normalize(rounded).coefficients)
        assert off(near.coefficients, grown.coefficients) < 1e-6


def test_projection_is_a_versor_and_the_projection_of_itself(rng: np.random.Generator) -> None:
    elements = np.eye(12)[0] + 0.3 * rng.standard_normal((200, 12))
    once = Similarity(Similarity.normalize(elements).coefficients)
    twice = Similarity.normalize(once.coefficients)
    assert off(twice.coefficients, once.coefficients) < 1e-13


def test_projection_moves_with_the_versors(rng: np.random.Generator) -> None:
    elements = np.eye(12)[0] + 0.2 * rng.standard_normal((50, 12))
    left, right = Similarity.random(rng, (50,)), Similarity.random(rng, (50,))
    moved = kernels.SIMILARITIES.compose(
        kernels.SIMILARITIES.compose(left.coefficients, elements), right.coefficients
    )
    witness = left @ Similarity.normalize(elements) @ right
    assert off(Similarity.normalize(moved).coefficients, witness.coefficients) < 1e-12


@pytest.mark.parametrize(
    "element",
    [
        {4: 1.0},  # E alone turns everything inside out
        {0: 1.0, 4: 1.0},  # no scale: S ~S = 0
        {0: 1.0, 4: -1.0, 9: 3.0},
        {0: 0.1, 4: 2.0},
    ],
)
def test_what_is_near_no_similarity_is_refused(element: dict[int, float]) -> None:
    given = np.zeros(12)
    for place, value in element.items():
        given[place] = value
    with pytest.raises(ValueError, match="without a scale or turned inside out"):
        Similarity.normalize(given)
    with pytest.raises(ValueError, match="expected unit versors"):
        Similarity(given)


def test_parts_that_do_not_fit_are_refused() -> None:
    skew = np.array(Similarity.from_motor_scale(Motor.identity(), 2.0).coefficients)
    skew[5] = 0.1
    with pytest.raises(ValueError, match="expected unit versors"):
        Similarity(skew)
    with pytest.raises(ValueError, match="expected unit versors"):
        Similarity([1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1])


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_scales_must_be_positive_numbers(bad: float) -> None:
    with pytest.raises(ValueError, match="Similarity scale: expected"):
        Similarity.from_motor_scale(Motor.identity(), bad)


def test_scales_beyond_float64_are_refused() -> None:
    with pytest.raises(ValueError, match=r"exp\(log\): expected scales that float64 can hold"):
        Similarity.exp([0, 0, 0, 1e3, 0, 0, 0])


def test_matrices_that_are_no_similarities_are_refused() -> None:
    with pytest.raises(ValueError, match="expected a positive determinant"):
        Similarity.from_matrix(np.diag([1.0, 1.0, -1.0, 1.0]))
    with pytest.raises(ValueError, match=r"Rotor\.nearest gives the nearest rotation"):
        Similarity.from_matrix(np.diag([1.0, 1.0, 1.1, 1.0]))
    with pytest.raises(ValueError, match="expected the last row 0 0 0 1"):
        Similarity.from_matrix(2.0 * np.eye(4))


def test_dilator_rotor_and_translator_multiply_to_the_whole(rng: np.random.Generator) -> None:
    whole = Similarity.random(rng, (30,))
    rotor, translation, scale = whole.as_rotor_translation_scale()
    still = np.zeros(3)
    one = Rotor.identity((30,))
    growth = Similarity.from_rotor_translation_scale(one, still, scale)
    turn = Similarity.from_rotor_translation_scale(rotor, still, 1.0)
    shift = Similarity.from_rotor_translation_scale(one, translation, 1.0)
    assert off((shift @ turn @ growth).coefficients, whole.coefficients) < 1e-14


def test_the_rigid_part_is_the_same_turn_and_shift_at_scale_one(rng: np.random.Generator) -> None:
    grown = Similarity.random(rng, (20,))
    motor, _ = grown.as_motor_scale()
    np.testing.assert_array_equal(grown.rigid.coefficients, motor.coefficients)
    assert motor.rigid is motor
