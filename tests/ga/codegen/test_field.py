"""GF(p²) against Python's integers: roots, signs, and the fractions that elements stand for."""

from fractions import Fraction

import numpy as np
import pytest

from motorcade.ga.codegen.passes.equality import field
from motorcade.ga.codegen.passes.equality.field import PRIME, Element

LARGEST = 1 << 29


def is_square(a: int) -> bool:
    return pow(a, (PRIME - 1) // 2, PRIME) == 1


@pytest.fixture
def elements(rng: np.random.Generator) -> list[Element]:
    return [(int(x), int(y)) for x, y in rng.integers(1, PRIME, (200, 2))]


def test_products_are_those_of_complex_numbers_modulo_p(elements: list[Element]) -> None:
    for (a, b), (c, d) in zip(elements[::2], elements[1::2], strict=True):
        expected = ((a * c - b * d) % PRIME, (a * d + b * c) % PRIME)
        assert field.multiply((a, b), (c, d)) == expected
        assert field.add((a, b), (c, d)) == ((a + c) % PRIME, (b + d) % PRIME)
        assert field.subtract((a, b), (c, d)) == ((a - c) % PRIME, (b - d) % PRIME)
        assert field.add((a, b), field.negative((a, b))) == field.ZERO
    assert field.multiply((0, 1), (0, 1)) == field.constant(-1.0)


def test_half_of_the_elements_have_roots_and_these_are_their_own_magnitude(
    elements: list[Element],
) -> None:
    roots = [(x, field.root(x)) for x in elements]
    found = [(x, root) for x, root in roots if root is not None]
    assert 70 < len(found) < 130
    for x, root in found:
        assert field.multiply(root, root) == x
        assert field.magnitude(root) == root == field.canonical(root)
    # x is a square where its norm is one.
    assert {x for x, _ in found} == {(a, b) for a, b in elements if is_square(a * a + b * b)}


def test_all_plain_numbers_have_roots(elements: list[Element]) -> None:
    for a, _ in elements:
        root = field.root((a, 0))
        assert root is not None
        assert field.multiply(root, root) == (a, 0)
        assert root[1] == 0 if is_square(a) else root[0] == 0
        assert field.magnitude(root) == root or not is_square(a)
    assert field.root(field.ZERO) == field.ZERO


def test_magnitudes_of_plain_numbers_are_squares_and_multiply(elements: list[Element]) -> None:
    sizes = [field.magnitude((a, 0)) for a, _ in elements]
    for (a, _), size in zip(elements, sizes, strict=True):
        assert size in ((a, 0), (PRIME - a, 0))
        assert is_square(size[0])
    for k in range(0, 200, 2):
        product = field.multiply((elements[k][0], 0), (elements[k + 1][0], 0))
        assert field.magnitude(product) == field.multiply(sizes[k], sizes[k + 1])
    assert field.magnitude(field.ZERO) == field.ZERO


def test_elements_with_an_imaginary_part_are_no_fractions() -> None:
    assert field.rational((3, 1), LARGEST) is None
    assert field.rational((3, 0), LARGEST) == 3


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
    assert field.rational(field.fraction(value), LARGEST) == value


@pytest.mark.parametrize("value", [Fraction(1, 1025), Fraction(1025), Fraction(-1025, 7)])
def test_fractions_above_the_largest_do_not(value: Fraction) -> None:
    assert field.rational(field.fraction(value), 1024) is None


@pytest.mark.parametrize("value", [0.1, -2.5, 3.0, 2.0**-1074, 1.7e308])
def test_floats_are_the_fractions_that_they_are(value: float) -> None:
    top, bottom = value.as_integer_ratio()
    assert field.multiply(field.constant(value), (bottom % PRIME, 0)) == (top % PRIME, 0)


def test_the_field_is_a_field(rng: np.random.Generator) -> None:
    half = (field.PRIME - 1) // 2
    assert pow(3, half - 1, half) == 1, "no power of 2 below this one is 1"
    assert all(pow(square, half, field.PRIME) == 1 for square in (2, 3, 5, 7, 11, 13, 17, 19))
    for _ in range(50):
        a, b = ((int(x), int(y)) for x, y in rng.integers(1, field.PRIME, (2, 2)))
        assert field.multiply(a, field.inverse(a)) == field.ONE
        assert field.multiply(field.divide(a, b), b) == a
        assert field.subtract(field.add(a, b), b) == a
        square = field.multiply(a, a)
        root = field.root(square)
        assert root in (a, field.negative(a))
        assert field.magnitude(a) == field.magnitude(field.negative(a))
        plain = field.root((a[0], 0))
        assert plain is not None
        assert field.multiply(plain, plain) == (a[0], 0)
    for fraction in (Fraction(3, 8), Fraction(-7, 5), Fraction(0), Fraction(1000)):
        below = pow(fraction.denominator, -1, field.PRIME)
        assert field.rational((fraction.numerator * below % field.PRIME, 0), 1024) == fraction
    assert field.rational(field.constant(0.1), 1024) is None
