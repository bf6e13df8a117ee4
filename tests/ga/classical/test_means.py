"""Means of quaternions and dual quaternions: those of the versors, found in another way."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.ga import Motor, Rotor, mean
from motorcade.ga.classical.dual_quaternion import (
    dual_quaternion_apply,
    dual_quaternion_from_quaternion_translation,
    dual_quaternion_mean,
    dual_quaternion_screw,
)
from motorcade.ga.classical.quaternion import (
    quaternion_as_matrix,
    quaternion_mean,
    quaternion_slerp,
)


def near(rng: np.random.Generator, shape: tuple[int, ...], size: float = 0.4) -> Motor:
    """Motions around one, so that they have a single mean."""
    twists = rng.uniform(-size, size, (*shape, 6))
    return Motor.random(rng) @ Motor.from_twist(twists)


def shares(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    weights: np.ndarray = rng.uniform(0.1, 1.0, shape)
    return weights / weights.sum(axis=-1, keepdims=True)


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_means_are_those_of_rotors_and_motors(count: int, rng: np.random.Generator) -> None:
    motions, weights = near(rng, (4, count)), shares(rng, (4, count))
    wxyz = motions.rotor.as_quaternion()
    rotors = mean(motions.rotor, weights)
    np.testing.assert_allclose(
        quaternion_as_matrix(quaternion_mean(wxyz, weights)), rotors.as_matrix(), rtol=0, atol=1e-11
    )
    duals = dual_quaternion_from_quaternion_translation(wxyz, motions.translation_m)
    points = rng.standard_normal((4, 3))
    np.testing.assert_allclose(
        dual_quaternion_apply(dual_quaternion_mean(duals, weights), points),
        mean(motions, weights).apply(points),
        rtol=0,
        atol=1e-11,
    )


def test_the_mean_leaves_rotation_vectors_that_cancel(rng: np.random.Generator) -> None:
    rotors, weights = near(rng, (5,)).rotor, shares(rng, (5,))
    middle = Rotation.from_quat(quaternion_mean(rotors.as_quaternion(), weights), scalar_first=True)
    others = Rotation.from_quat(rotors.as_quaternion(), scalar_first=True)
    left = weights @ (middle.inv() * others).as_rotvec()
    np.testing.assert_allclose(left, np.zeros(3), rtol=0, atol=1e-11)


def test_of_two_the_mean_is_the_interpolation(rng: np.random.Generator) -> None:
    pair = near(rng, (2,))
    wxyz = pair.rotor.as_quaternion()
    duals = dual_quaternion_from_quaternion_translation(wxyz, pair.translation_m)
    np.testing.assert_array_equal(
        quaternion_mean(wxyz, [0.3, 0.7]), quaternion_slerp(wxyz[0], wxyz[1], 0.7)
    )
    np.testing.assert_array_equal(
        dual_quaternion_mean(duals, [0.3, 0.7]), dual_quaternion_screw(duals[0], duals[1], 0.7)
    )


def test_rotations_too_far_apart_are_refused() -> None:
    """Steps by shares that do not sum to one grow, and never settle."""
    wxyz = Rotor.from_euler([[0.0, 0.0, 0.0], [2.0, 0.5, 0.0], [0.0, 2.5, 1.0]]).as_quaternion()
    with pytest.raises(ValueError, match=r"q: expected rotations close enough .* after 100 rounds"):
        quaternion_mean(wxyz, [2.0, 2.0, 3.0])
    duals = dual_quaternion_from_quaternion_translation(wxyz, np.zeros((3, 3)))
    with pytest.raises(ValueError, match=r"q: expected rotations close enough .* after 100 rounds"):
        dual_quaternion_mean(duals, [2.0, 2.0, 3.0])
