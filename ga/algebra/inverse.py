"""Inverses of multivectors over any scalars, refused where there is none.

A versor, blade or other element with scalar ``x ~x`` is inverted by ``~x / (x ~x)``. Where
``x ~x = s + F`` and ``(s + F)(s - F)`` is a scalar, as for every even element of CGA, two factors
are enough. Anything else goes through the characteristic polynomial, which needs only products
and one division: Shirokov, "On computing the determinant, other characteristic polynomial
coefficients, and inverse in Clifford algebras of arbitrary dimension", 2021.
"""

from __future__ import annotations

from typing import Any

from motorcade.ga.algebra.multivector import Multivector
from motorcade.ga.algebra.scalars import is_zero_somewhere

__all__ = ["inverse"]


def inverse(x: Multivector) -> Multivector:
    """The multivector ``y`` with ``x y = y x = 1``.

    Raises:
        ValueError: not invertible, or one of a batch is not.
    """
    size = x.reverse_product()
    if _is_scalar(size):
        return _divided(~x, size.scalar_part())
    scalar = size.scalar_part()
    rest = size._selected(bool)
    square = rest.square()
    if _is_scalar(square):
        return _divided(~x * (scalar - rest), scalar * scalar - square.scalar_part())
    return _by_characteristic_polynomial(x)


def _by_characteristic_polynomial(x: Multivector) -> Multivector:
    degree = 2 ** ((x.algebra.dimension + 1) // 2)
    power, before = x, x
    for k in range(1, degree):
        before = power - degree / k * power.scalar_part()
        power = x * before
    return _divided(before, power.scalar_part())


def _is_scalar(x: Multivector) -> bool:
    return not any(x.masks)


def _divided(x: Multivector, divisor: Any) -> Multivector:
    if is_zero_somewhere(divisor):
        raise ValueError("inverse: expected an invertible multivector, got one without an inverse")
    return x._divided(divisor)
