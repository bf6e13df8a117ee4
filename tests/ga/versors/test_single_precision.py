"""The laws of versors hold in float32 too, to its own rounding, and stay in float32."""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor

Distance = Callable[[Versor, Versor], float]
ROUNDING = 3e-6


@pytest.fixture(params=[Rotor, Motor, Similarity])
def kind(request: pytest.FixtureRequest) -> type[Versor]:
    return request.param


@pytest.fixture
def singles(versors: Versor) -> Versor:
    return versors.astype(np.float32)


@pytest.fixture
def other_singles(others: Versor) -> Versor:
    return others.astype(np.float32)


def test_nothing_leaves_the_precision(singles: Versor, other_singles: Versor) -> None:
    made = [
        singles @ other_singles,
        singles.inverse(),
        type(singles).exp(singles.log()),
        singles.interpolate(other_singles, 0.3),
    ]
    assert {versor.coefficients.dtype for versor in made} == {np.dtype(np.float32)}
    assert singles.log().dtype == np.float32


def test_exp_undoes_log(singles: Versor, distance: Distance) -> None:
    assert distance(type(singles).exp(singles.log()), singles) < ROUNDING


def test_composition_is_associative(
    singles: Versor, other_singles: Versor, distance: Distance
) -> None:
    left = (singles @ other_singles) @ singles
    assert distance(singles @ (other_singles @ singles), left) < ROUNDING


def test_inverse_cancels_on_both_sides(singles: Versor) -> None:
    scale = max(1.0, float(np.max(np.abs(singles.coefficients))))
    identity = type(singles).identity(singles.shape).coefficients
    for product in (singles @ singles.inverse(), singles.inverse() @ singles):
        assert np.max(np.abs(product.coefficients - identity)) < ROUNDING * scale


def test_action_is_the_matrix(singles: Versor, rng: np.random.Generator) -> None:
    points = rng.standard_normal((*singles.shape, 3)).astype(np.float32)
    matrix = np.asarray(singles.as_matrix(), dtype=np.float64)
    witness = (matrix[..., :3, :3] @ points[..., None].astype(np.float64))[..., 0]
    if matrix.shape[-1] == 4:
        witness += matrix[..., :3, 3]
    scale = max(1.0, float(np.max(np.abs(witness))))
    np.testing.assert_allclose(singles.apply(points), witness, rtol=0, atol=ROUNDING * scale)


def test_interpolation_begins_and_arrives(
    singles: Versor, other_singles: Versor, distance: Distance
) -> None:
    assert distance(singles.interpolate(other_singles, 0.0), singles) < ROUNDING
    # The way there is as long as the start is far: its rounding is what arrives.
    far = max(1.0, float(np.max(np.abs(singles.coefficients))))
    assert distance(singles.interpolate(other_singles, 1.0), other_singles) < ROUNDING * far


def test_interpolation_does_not_care_where_the_world_lies(
    singles: Versor, other_singles: Versor, distance: Distance
) -> None:
    moved = (other_singles @ singles).interpolate(other_singles @ other_singles, 0.3)
    still = other_singles @ singles.interpolate(other_singles, 0.3)
    assert distance(moved, still) < 10 * ROUNDING


def test_single_and_double_agree(versors: Versor, others: Versor, distance: Distance) -> None:
    double = versors @ others
    single = (versors.astype(np.float32) @ others.astype(np.float32)).astype(np.float64)
    assert distance(single, double) < ROUNDING
