"""Rotors, motors and similarities are the multivectors that their coefficients name."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor
from motorcade.ga.algebra import CGA3, EGA3
from motorcade.ga.algebra.conformal import (
    as_motor,
    as_rotor,
    as_similarity,
    coordinates,
    of_versor,
    point,
)

READ = {Rotor: as_rotor, Motor: as_motor, Similarity: as_similarity}


@pytest.mark.parametrize("kind", READ)
def test_there_and_back(kind: type[Versor], rng: np.random.Generator) -> None:
    given = kind.random(rng, (3, 4))  # type: ignore[attr-defined]
    np.testing.assert_array_equal(READ[kind](of_versor(given)).coefficients, given.coefficients)


@pytest.mark.parametrize("kind", READ)
def test_sandwich_is_apply(kind: type[Versor], rng: np.random.Generator) -> None:
    given, x = kind.random(rng, (50,)), rng.standard_normal((50, 3))  # type: ignore[attr-defined]
    moved = coordinates(of_versor(given).sandwich(point(x)))
    np.testing.assert_allclose(moved, given.apply(x), rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", READ)
def test_products_are_compose_and_reverse_is_inverse(
    kind: type[Versor], rng: np.random.Generator
) -> None:
    a, b = kind.random(rng, (50,)), kind.random(rng, (50,))  # type: ignore[attr-defined]
    product = READ[kind](of_versor(a) * of_versor(b))
    size = max(1.0, float(np.max(np.abs((a @ b).coefficients))))
    np.testing.assert_allclose(
        product.coefficients, (a @ b).coefficients, rtol=0, atol=1e-13 * size
    )
    reverse = READ[kind](~of_versor(a))
    np.testing.assert_allclose(reverse.coefficients, a.inverse().coefficients, rtol=0, atol=1e-13)
    inverse = of_versor(a).inverse()
    np.testing.assert_allclose(
        READ[kind](inverse).coefficients, a.inverse().coefficients, rtol=0, atol=1e-12 * size
    )


def test_other_multivectors_are_refused(rng: np.random.Generator) -> None:
    with pytest.raises(ValueError, match="blades of a Motor, got e1"):
        as_motor(CGA3.blade("e1") + 1.0)
    with pytest.raises(ValueError, match="blades of a Rotor"):
        as_rotor(of_versor(Motor.random(rng)))
    with pytest.raises(ValueError, match="unit"):
        as_rotor(CGA3.scalar(2.0))
    with pytest.raises(ValueError, match="multivector of Algebra"):
        as_rotor(EGA3.scalar(1.0))
    with pytest.raises(ValueError, match="Rotor, Motor or Similarity"):
        of_versor(CGA3.scalar(1.0))  # type: ignore[arg-type]
