"""Weighted mean on the group and linear blend: invariance, closed cases, witnesses, refusals."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.ga import Motor, Rotor, Similarity, Versor, blend, mean
from motorcade.ga.classical.dual_quaternion import dual_quaternion_blend

Distance = Callable[[Versor, Versor], float]
ROUNDING = 1e-12


def near(kind: type[Versor], rng: np.random.Generator, shape: tuple[int, ...]) -> Versor:
    """Versors scattered by up to half a turn in all around one that is anywhere."""
    log = rng.uniform(-0.4, 0.4, (*shape, *kind.identity().log().shape))
    return kind.random(rng) @ kind.exp(log)


@pytest.fixture
def scattered(kind: type[Versor], rng: np.random.Generator) -> Versor:
    return near(kind, rng, (6, 5))


@pytest.fixture
def weights(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(0.1, 2.0, (6, 5))


def test_mean_makes_the_weighted_logarithms_cancel(scattered: Versor, weights: np.ndarray) -> None:
    middle = mean(scattered, weights)
    logs = (middle[:, None].inverse() @ scattered).log()
    np.testing.assert_allclose(np.einsum("nk,nkc->nc", weights, logs), 0.0, atol=ROUNDING)


@pytest.mark.parametrize("combine", [mean, blend])
def test_moving_all_moves_the_middle(
    combine: Callable[..., Versor],
    scattered: Versor,
    weights: np.ndarray,
    rng: np.random.Generator,
    distance: Distance,
) -> None:
    left, right = (type(scattered).random(rng) for _ in range(2))
    moved = left @ combine(scattered, weights) @ right
    assert distance(combine(left @ scattered @ right, weights), moved) < ROUNDING


@pytest.mark.parametrize("combine", [mean, blend])
def test_inverting_all_inverts_the_middle(
    combine: Callable[..., Versor], scattered: Versor, weights: np.ndarray, distance: Distance
) -> None:
    inverted = combine(scattered.inverse(), weights)
    assert distance(inverted, combine(scattered, weights).inverse()) < ROUNDING


@pytest.mark.parametrize("combine", [mean, blend])
def test_signs_and_the_sum_of_weights_do_not_matter(
    combine: Callable[..., Versor],
    scattered: Versor,
    weights: np.ndarray,
    rng: np.random.Generator,
    distance: Distance,
) -> None:
    signs = rng.choice([-1.0, 1.0], (6, 5, 1))
    flipped = type(scattered)(signs * scattered.coefficients)
    assert distance(combine(flipped, 7.0 * weights), combine(scattered, weights)) < ROUNDING


def test_order_does_not_matter_to_the_mean(
    scattered: Versor, weights: np.ndarray, distance: Distance
) -> None:
    turned = mean(scattered[:, ::-1], weights[:, ::-1])
    assert distance(turned, mean(scattered, weights)) < ROUNDING


def test_mean_of_two_is_the_screw_between_them(versors: Versor, others: Versor) -> None:
    pair = type(versors)(np.stack([versors.coefficients, others.coefficients], axis=-2))
    turn = np.linalg.norm((versors.inverse() @ others).log()[..., :3], axis=-1)
    middle, screw = mean(pair, [0.7, 0.3]), versors.interpolate(others, 0.3)
    apart = np.max(np.abs(middle.as_matrix() - screw.as_matrix()), axis=(-1, -2))
    size = np.max(np.abs(screw.as_matrix()), axis=(-1, -2))
    # At half a turn both halves of the circle are as short.
    assert np.all((apart < 1e-10 * size) | (np.abs(2 * turn - np.pi) < 1e-6))


def test_halfway_the_blend_of_two_is_the_screw_between_them(
    kind: type[Versor], rng: np.random.Generator, distance: Distance
) -> None:
    if kind is Similarity:
        pytest.skip("with growth the two differ; the mean is the screw")
    pairs = near(kind, rng, (50, 2))
    halfway = pairs[:, 0].interpolate(pairs[:, 1], 0.5)
    assert distance(blend(pairs, [1.0, 1.0]), halfway) < ROUNDING


@pytest.mark.parametrize("combine", [mean, blend])
def test_one_versor_is_its_own_middle(
    combine: Callable[..., Versor], versors: Versor, distance: Distance
) -> None:
    thrice = type(versors)(np.repeat(versors.coefficients[..., None, :], 3, axis=-2))
    assert distance(combine(thrice, [0.2, 0.5, 0.3]), versors) < ROUNDING
    assert distance(combine(versors.reshape(*versors.shape, 1), [2.0]), versors) < ROUNDING


def test_scipy_finds_the_same_mean_of_rotations_close_together(rng: np.random.Generator) -> None:
    # scipy's is the chordal mean, which parts from Karcher's with the cube of the spread.
    rotors = Rotor.random(rng) @ Rotor.exp(1e-5 * rng.standard_normal((9, 3)))
    weights = rng.uniform(0.5, 1.5, 9)
    chordal = Rotation.from_quat(rotors.as_quaternion(), scalar_first=True).mean(weights)
    np.testing.assert_allclose(
        mean(rotors, weights).as_matrix(), chordal.as_matrix(), rtol=0, atol=1e-13
    )


def test_scipy_finds_the_same_chordal_mean(rng: np.random.Generator) -> None:
    # The blend is the chordal mean to first order only; of two with equal weights it is exact.
    rotors = near(Rotor, rng, (2,))
    assert isinstance(rotors, Rotor)
    chordal = Rotation.from_quat(rotors.as_quaternion(), scalar_first=True).mean()
    np.testing.assert_allclose(
        blend(rotors, [1, 1]).as_matrix(), chordal.as_matrix(), rtol=0, atol=1e-14
    )


def test_blend_of_motors_is_dual_quaternion_blending(rng: np.random.Generator) -> None:
    motors, weights = Motor.random(rng, (40, 4)), rng.dirichlet(np.ones(4), 40)
    witness = dual_quaternion_blend(motors.as_dual_quaternion(), weights)
    found = blend(motors, weights).as_dual_quaternion()
    np.testing.assert_allclose(found, witness, rtol=0, atol=1e-13)


def test_without_rotation_the_mean_is_that_of_the_points(rng: np.random.Generator) -> None:
    points, weights = rng.standard_normal((6, 3)), rng.dirichlet(np.ones(6))
    motors = Motor.from_rotor_translation(Rotor.identity((6,)), points)
    for combine in (mean, blend):
        middle = combine(motors, weights)
        np.testing.assert_allclose(middle.translation_m, weights @ points, rtol=0, atol=1e-14)


def test_scales_have_their_geometric_mean(rng: np.random.Generator) -> None:
    scales, weights = np.array([1e-3, 1.0, 1e3, 30.0]), np.array([0.1, 0.2, 0.3, 0.4])
    grown = Similarity.from_motor_scale(Motor.identity(), scales)
    expected = np.exp(weights @ np.log(scales))
    assert float(mean(grown, weights).scale) == pytest.approx(expected, rel=1e-12)


def test_versors_far_away_settle_too(kind: type[Versor], rng: np.random.Generator) -> None:
    if kind is Rotor:
        pytest.skip("rotations are never far away")
    far = Motor.random(rng, (6,), extent_m=1e6)
    turned = Motor.random(rng) @ Motor.exp(rng.uniform(-0.3, 0.3, (6, 6)))
    moved = far[:1] @ turned
    given = moved if kind is Motor else Similarity.from_motor_scale(moved, np.linspace(0.5, 2, 6))
    middle = mean(given)
    assert np.max(np.abs((middle.inverse() @ given).log().mean(axis=0))) < 1e-7


def test_one_set_of_weights_serves_a_whole_batch(
    scattered: Versor, rng: np.random.Generator
) -> None:
    weights = rng.uniform(0.5, 1.5, 5)
    for combine in (mean, blend):
        every = combine(scattered, weights)
        assert every.shape == (6,)
        one = combine(scattered[2], weights)
        np.testing.assert_allclose(every[2].coefficients, one.coefficients, rtol=0, atol=1e-13)
        many = combine(scattered[0], rng.uniform(0.5, 1.5, (3, 2, 5)))
        assert many.shape == (3, 2)
    assert mean(scattered).shape == (6,)


def test_empty_batches_have_empty_middles(kind: type[Versor]) -> None:
    assert mean(kind.identity((0, 3))).shape == (0,)
    assert blend(kind.identity((0, 3)), [1, 1, 1]).shape == (0,)


def test_a_mean_that_does_not_settle_is_refused(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    with pytest.raises(ValueError, match=r"expected rotations close enough .* 1e-300 was asked"):
        mean(near(kind, rng, (50, 7)), tolerance=1e-300)


def test_opposite_weights_cancel(kind: type[Versor], rng: np.random.Generator) -> None:
    pair = kind.stack([kind.random(rng)] * 2)
    for bad in ([1.0, -1.0], [0.0, 0.0]):
        with pytest.raises(ValueError, match="cancel"):
            blend(pair, bad)


def test_weights_that_do_not_fit_are_refused(kind: type[Versor], rng: np.random.Generator) -> None:
    three = kind.random(rng, (3,))
    for combine, name in ((mean, "mean"), (blend, "blend")):
        for bad in ([1.0, 1.0], 1.0, np.ones((3, 1))):
            with pytest.raises(ValueError, match=rf"{name}\(weights\): expected shape \(\*, 3\)"):
                combine(three, bad)
        with pytest.raises(ValueError, match="expected finite numbers"):
            combine(three, [1.0, np.nan, 1.0])
        with pytest.raises(ValueError, match="K >= 1"):
            combine(kind.identity(), [1.0])
        with pytest.raises(ValueError, match="K >= 1"):
            combine(kind.identity((4, 0)), np.ones(0))
        with pytest.raises(ValueError, match="broadcast together"):
            combine(kind.identity((4, 3)), np.ones((5, 3)))
    with pytest.raises(ValueError, match="expected weights >= 0"):
        mean(three, [1.0, -0.1, 1.0])
    with pytest.raises(ValueError, match="all zero"):
        mean(three, [0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="expected a number above 0"):
        mean(three, tolerance=0.0)
