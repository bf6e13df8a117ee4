"""Arithmetic in GF(p²), p = 2^61 - 150993: pairs ``(a, b)`` stand for ``a + b i``, ``i² = -1``.

As p leaves 3 on division by 4, -1 has no root in GF(p) and every element of GF(p) has one in
GF(p²). Half of the other elements have none. Floats are full of powers of two: modulo 2^61 - 1
these repeat after 61, modulo this p, as (p - 1) / 2 is a prime too, only after (p - 1) / 2.

As -1 is no square in GF(p), one of x and -x is. Squares stand for what is positive: they too are
closed under products, and 2, 3, 5, 7, 11, 13, 17 and 19 are squares.
"""

from __future__ import annotations

from fractions import Fraction

PRIME = (1 << 61) - 150993
Element = tuple[int, int]
ZERO: Element = (0, 0)
ONE: Element = (1, 0)
_HALF = (PRIME + 1) // 2


def add(x: Element, y: Element) -> Element:
    """Sum."""
    return (x[0] + y[0]) % PRIME, (x[1] + y[1]) % PRIME


def subtract(x: Element, y: Element) -> Element:
    """Difference."""
    return (x[0] - y[0]) % PRIME, (x[1] - y[1]) % PRIME


def negative(x: Element) -> Element:
    """``-x``."""
    return -x[0] % PRIME, -x[1] % PRIME


def multiply(x: Element, y: Element) -> Element:
    """Product."""
    a, b = x
    c, d = y
    if not b and not d:
        return a * c % PRIME, 0
    return (a * c - b * d) % PRIME, (a * d + b * c) % PRIME


def inverse(x: Element) -> Element:
    """``1 / x`` of anything but zero."""
    a, b = x
    if not b:
        return pow(a, -1, PRIME), 0
    size = pow(a * a + b * b, -1, PRIME)
    return a * size % PRIME, -b * size % PRIME


def divide(x: Element, y: Element) -> Element:
    """``x / y`` where y is not zero."""
    return multiply(x, inverse(y))


def canonical(x: Element) -> Element:
    """One of x and -x, the same for both."""
    return min(x, negative(x))


def magnitude(x: Element) -> Element:
    """What stands for ``|x|``: that of x and -x which is a square, `canonical` outside of GF(p)."""
    if x[1]:
        return canonical(x)
    return x if _is_square(x[0]) else negative(x)


def root(x: Element) -> Element | None:
    """A square root, None where there is none; `magnitude` of the two."""
    a, b = x
    if not b:
        # A power of a square is a square.
        candidate = pow(a if _is_square(a) else -a, (PRIME + 1) // 4, PRIME)
        return (candidate, 0) if candidate * candidate % PRIME == a else (0, candidate)
    size = _base_root((a * a + b * b) % PRIME)
    if size is None:
        return None
    for norm in (size, -size % PRIME):
        real = _base_root((a + norm) * _HALF % PRIME)
        if real:
            return canonical((real, b * pow(2 * real, -1, PRIME) % PRIME))
    return None


def _is_square(a: int) -> bool:
    return pow(a, (PRIME - 1) // 2, PRIME) <= 1


def _base_root(a: int) -> int | None:
    candidate = pow(a, (PRIME + 1) // 4, PRIME)
    return candidate if candidate * candidate % PRIME == a else None


def constant(value: float) -> Element:
    """A float as the dyadic fraction that it is."""
    return fraction(Fraction(value))


def fraction(value: Fraction) -> Element:
    """A fraction whose denominator is no multiple of p."""
    return value.numerator * pow(value.denominator, -1, PRIME) % PRIME, 0


def rational(x: Element, largest: int) -> Fraction | None:
    """The fraction with numerator and denominator up to `largest` that x stands for, if any.

    It is unique where ``2 largest² < p`` (Wang's reconstruction by Euclid's algorithm).
    """
    if x[1]:
        return None
    above, last, t, before = x[0], PRIME, 1, 0
    while above > largest:
        quotient = last // above
        last, above = above, last - quotient * above
        before, t = t, before - quotient * t
    return Fraction(above, t) if 0 < abs(t) <= largest else None
