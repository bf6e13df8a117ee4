"""GF(p²) against Python's integers: roots, signs, and the fractions that elements stand for."""

from fractions import Fraction

import numpy as np
import pytest

from motorcade.ga.codegen.passes import finite_field
from motorcade.ga.codegen.passes.finite_field import PRIME, Element

LARGEST = 1 << 29


def is_square(a: int) -> bool:
    return pow(a, (PRIME - 1) // 2, PRIME) == 1


@pytest.fixture
def elements(rng: np.random.Generator) -> list[Element]:
    return [(int(x), int(y)) for x, y in rng.integers(1, PRIME, (200, 2))]


def test_products_are_those_of_complex_numbers_modulo_p(elements: list[Element]) -> None:
    for (a, b), (c, d) in zip(elements[::2], elements[1::2], strict=True):
        expected = ((a * c - b * d) % PRIME, (a * d + b * c) % PRIME)
        assert finite_field.multiply((a, b), (c, d)) == expected
        assert finite_field.add((a, b), (c, d)) == ((a + c) % PRIME, (b + d) % PRIME)
        assert finite_field.subtract((a, b), (c, d)) == ((a - c) % PRIME, (b - d) % PRIME)
        assert finite_field.add((a, b), finite_field.negative((a, b))) == finite_field.ZERO
    assert finite_field.multiply((0, 1), (0, 1)) == finite_field.constant(-1.0)


def test_half_of_the_elements_have_roots_and_these_are_their_own_magnitude(
    elements: list[Element],
) -> None:
    roots = [(x, finite_field.root(x)) for x in elements]
    found = [(x, root) for x, root in roots if root is not None]
    assert 70 < len(found) < 130
    for x, root in found:
        assert finite_field.multiply(root, root) == x
        assert finite_field.magnitude(root) == root == finite_field.canonical(root)
    # x is a square where its norm is one.
    assert {x for x, _ in found} == {(a, b) for a, b in elements if is_square(a * a + b * b)}


def test_all_plain_numbers_have_roots(elements: list[Element]) -> None:
    for a, _ in elements:
        root = finite_field.root((a, 0))
        assert root is not None
        assert finite_field.multiply(root, root) == (a, 0)
        assert root[1] == 0 if is_square(a) else root[0] == 0
        assert finite_field.magnitude(root) == root or not is_square(a)
    assert finite_field.root(finite_field.ZERO) == finite_field.ZERO


def test_magnitudes_of_plain_numbers_are_squares_and_multiply(elements: list[Element]) -> None:
    sizes = [finite_field.magnitude((a, 0)) for a, _ in elements]
    for (a, _), size in zip(elements, sizes, strict=True):
        assert size in ((a, 0), (PRIME - a, 0))
        assert is_square(size[0])
    for k in range(0, 200, 2):
        product = finite_field.multiply((elements[k][0], 0), (elements[k + 1][0], 0))
        assert finite_field.magnitude(product) == finite_field.multiply(sizes[k], sizes[k + 1])
    assert finite_field.magnitude(finite_field.ZERO) == finite_field.ZERO


def test_elements_with_an_imaginary_part_are_no_fractions() -> None:
    assert finite_field.rational((3, 1), LARGEST) is None
    assert finite_field.rational((3, 0), LARGEST) == 3


@pytest.mark.parametrize(
    "value",
    [
        Fraction(LARGEST, LARGEST - 1),
        Fraction(-LARGEST, LARGEST - 1),
        Fraction(1, LARGEST),
        Fraction(-1),
        Fraction(LARGEST),
        Fraction(0),
    ],
)
def test_fractions_up_to_the_largest_come_back(value: Fraction) -> None:
    assert finite_field.rational(finite_field.fraction(value), LARGEST) == value


@pytest.mark.parametrize("value", [Fraction(1, 1025), Fraction(1025), Fraction(-1025, 7)])
def test_fractions_above_the_largest_do_not(value: Fraction) -> None:
    assert finite_field.rational(finite_field.fraction(value), 1024) is None


@pytest.mark.parametrize("value", [0.1, -2.5, 3.0, 2.0**-1074, 1.7e308])
def test_floats_are_the_fractions_that_they_are(value: float) -> None:
    top, bottom = value.as_integer_ratio()
    assert finite_field.multiply(finite_field.constant(value), (bottom % PRIME, 0)) == (
        top % PRIME,
        0,
    )


def test_the_field_is_a_field(rng: np.random.Generator) -> None:
    half = (finite_field.PRIME - 1) // 2
    assert pow(3, half - 1, half) == 1, "no power of 2 below this one is 1"
    assert all(
        pow(square, half, finite_field.PRIME) == 1 for square in (2, 3, 5, 7, 11, 13, 17, 19)
    )
    for _ in range(50):
        a, b = ((int(x), int(y)) for x, y in rng.integers(1, finite_field.PRIME, (2, 2)))
        assert finite_field.multiply(a, finite_field.inverse(a)) == finite_field.ONE
        assert finite_field.multiply(finite_field.divide(a, b), b) == a
        assert finite_field.subtract(finite_field.add(a, b), b) == a
        square = finite_field.multiply(a, a)
        root = finite_field.root(square)
        assert root in (a, finite_field.negative(a))
        assert finite_field.magnitude(a) == finite_field.magnitude(finite_field.negative(a))
        plain = finite_field.root((a[0], 0))
        assert plain is not None
        assert finite_field.multiply(plain, plain) == (a[0], 0)
    for fraction in (Fraction(3, 8), Fraction(-7, 5), Fraction(0), Fraction(1000)):
        below = pow(fraction.denominator, -1, finite_field.PRIME)
        assert (
            finite_field.rational((fraction.numerator * below % finite_field.PRIME, 0), 1024)
            == fraction
        )
    assert finite_field.rational(finite_field.constant(0.1), 1024) is None
