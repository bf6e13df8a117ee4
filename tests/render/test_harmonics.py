"""Spherical harmonics turned by rotors, with SciPy's functions and sampled fits as witnesses."""

import numpy as np
import pytest
from scipy.special import sph_harm_y

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.render.light.estimate import (
    band_of,
    harmonics,
    irradiance_factors,
    rotate_harmonics,
)


def directions(rng: np.random.Generator, count: int) -> FloatArray:
    given = rng.normal(size=(count, 3))
    return np.asarray(given / np.linalg.norm(given, axis=1, keepdims=True))


def turns(rng: np.random.Generator) -> list[Rotor]:
    axis = directions(rng, 1)[0]
    angles = (0.0, 1e-9, 1e-4, 1.0, np.pi - 1e-9, np.pi, np.pi + 1e-9, 2.0 * np.pi - 1e-6)
    return [Rotor.from_rotation_vector(angle * axis) for angle in angles] + [
        Rotor.random(rng) for _ in range(20)
    ]


def test_the_basis_is_scipys(rng: np.random.Generator) -> None:
    v = np.concatenate([directions(rng, 300), np.eye(3), -np.eye(3)])
    polar, azimuth = np.arccos(v[:, 2]), np.arctan2(v[:, 1], v[:, 0])
    values = harmonics(v, 6)
    for degree in range(7):
        for m in range(-degree, degree + 1):
            there = (-1.0) ** m * sph_harm_y(degree, abs(m), polar, azimuth)
            expected = there.real if m == 0 else np.sqrt(2.0) * (there.real, there.imag)[m < 0]
            got = values[:, degree * degree + degree + m]
            np.testing.assert_allclose(got, expected, atol=1e-12)


def test_turned_coefficients_are_those_of_turned_samples_up_to_band_4(
    rng: np.random.Generator,
) -> None:
    v = directions(rng, 300)
    coefficients = rng.normal(size=25)
    samples = harmonics(v, 4) @ coefficients
    for rotor in turns(rng):
        fitted = np.linalg.lstsq(harmonics(rotor.apply(v), 4), samples, rcond=None)[0]
        np.testing.assert_allclose(rotate_harmonics(coefficients, rotor), fitted, atol=1e-10)


def test_turns_compose_keep_lengths_and_do_not_know_the_rotors_sign(
    rng: np.random.Generator,
) -> None:
    coefficients = rng.normal(size=(5, 1, 25))
    first, second = Rotor.random(rng, (3,)), Rotor.random(rng, (3,))
    once = rotate_harmonics(coefficients, second @ first)
    assert once.shape == (5, 3, 25)
    twice = rotate_harmonics(rotate_harmonics(coefficients, first), second)
    np.testing.assert_allclose(once, twice, atol=1e-12)
    given = np.broadcast_to(np.sum(coefficients**2, axis=-1), (5, 3))
    np.testing.assert_allclose(np.sum(once**2, axis=-1), given, rtol=1e-12)
    opposite = Rotor(-first.coefficients)
    np.testing.assert_allclose(
        rotate_harmonics(coefficients, opposite), rotate_harmonics(coefficients, first), atol=1e-13
    )


def test_irradiance_factors_are_integrals_of_the_clamped_cosine(rng: np.random.Generator) -> None:
    nodes, weights = np.polynomial.legendre.leggauss(200)
    z, factors = 0.5 * (nodes + 1.0), irradiance_factors(8)
    up = harmonics(np.stack([np.sqrt(1.0 - z * z), 0.0 * z, z], axis=-1), 8)
    for degree in range(9):
        middle = degree * degree + degree
        integral = np.pi * np.sum(weights * z * up[:, middle])
        at_pole = np.sqrt((2 * degree + 1) / (4.0 * np.pi))
        np.testing.assert_allclose(factors[middle] * at_pole, integral, atol=1e-12)


def test_what_is_no_row_of_bands_is_refused(rng: np.random.Generator) -> None:
    with pytest.raises(ValueError, match="expected 1, 4, 9, 16, 25"):
        band_of(np.zeros(10))
    with pytest.raises(ValueError, match="band: expected 0 to 12, got 13"):
        rotate_harmonics(np.zeros(196), Rotor.identity())
    with pytest.raises(ValueError, match="expected unit vectors"):
        harmonics([[0.0, 0.0, 2.0]], 2)
    with pytest.raises(ValueError, match="finite"):
        rotate_harmonics([np.nan], Rotor.identity())
