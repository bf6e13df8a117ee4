"""Inverses of multivectors over any scalars, refused where there is none.

A versor, blade or other element with scalar ``x ~x`` is inverted by ``~x / (x ~x)``. Where
``x ~x = s + F`` with ``F²`` a scalar, as for every even element of CGA, ``~x (s - F) / (s² - F²)``
is enough. Anything else goes through the characteristic polynomial, which needs only products
and one division: Shirokov, "On computing the determinant, other characteristic polynomial
coefficients, and inverse in Clifford algebras of arbitrary dimension", 2021. It loses digits where
the inverse is large beside the multivector.

A divisor no larger than what rounding may have left of its terms counts as zero. Symbols cannot be
looked at: for them the caller answers for the divisor.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from motorcade.ga.algebra.blade_sum import BladeSum
from motorcade.ga.algebra.products import Plan, apply_plan, majorant
from motorcade.ga.algebra.scalars import is_numeric, is_zero_somewhere, scaled

# Roundings that a divisor may have gone through, in units of its largest intermediate terms.
_ROUNDINGS = 16.0


class _Bounded:
    """A multivector and, where its scalars are numbers, the sizes of the terms that made it."""

    def __init__(self, exact: BladeSum, sizes: BladeSum | None) -> None:
        self.exact = exact
        self.sizes = sizes

    @classmethod
    def given(cls, x: BladeSum) -> _Bounded:
        numeric = all(map(is_numeric, x.values))
        return cls(x, x._with(map(abs, x.values)) if numeric else None)

    def made_by(self, plan: Plan, other: _Bounded) -> _Bounded:
        exact = apply_plan(plan, self.exact.values, other.exact.values)
        product = self.exact._wrap(plan.masks, exact)
        if self.sizes is None or other.sizes is None:
            return _Bounded(product, None)
        sizes = apply_plan(majorant(plan), self.sizes.values, other.sizes.values)
        return _Bounded(product, product._wrap(plan.masks, sizes))

    def __mul__(self, other: _Bounded) -> _Bounded:
        x = self.exact
        return self.made_by(x.algebra.plan("geometric", x.masks, other.exact.masks), other)

    def plus_scalar(self, factor: Fraction) -> _Bounded:
        """Add `factor` times its own scalar part."""
        exact = self.exact + scaled(factor, self.exact.scalar_part())
        if self.sizes is None:
            return _Bounded(exact, None)
        return _Bounded(exact, self.sizes + float(abs(factor)) * self.sizes.scalar_part())

    def mirrored(self) -> _Bounded:
        """``s - F`` of ``s + F``."""
        sizes = None if self.sizes is None else self.sizes + 0.0
        return _Bounded(2 * self.exact.scalar_part() - self.exact, sizes)

    @property
    def is_scalar(self) -> bool:
        return not any(self.exact.masks)


def inverse(x: BladeSum) -> BladeSum:
    """The multivector ``y`` with ``x y = y x = 1``.

    Raises ValueError: not invertible to rounding, or one of a batch is not.
    """
    bounded = _Bounded.given(x)
    size = _reverse_product(bounded)
    if size.is_scalar:
        return _divided(~x, size)
    rest = size.exact._selected(bool)
    if not any(rest.square().masks):
        mirrored = size.mirrored()
        return _divided(~x * mirrored.exact, _mirrored_product(size, mirrored))
    degree = 2 ** ((x.algebra.dimension + 1) // 2)
    power = before = bounded
    for k in range(1, degree):
        before = power.plus_scalar(Fraction(-degree, k))
        power = bounded * before
    return _divided(before.exact, power)


def norm_squared_with_bound(x: BladeSum) -> tuple[Any, Any]:
    """``⟨x ~x⟩₀`` and what rounding may have left of its terms; None where not numbers."""
    product = _reverse_product(_Bounded.given(x))
    return product.exact.scalar_part(), _bound(product)


def _reverse_product(x: _Bounded) -> _Bounded:
    return x.made_by(x.exact._reverse_plan(), x)


def _mirrored_product(size: _Bounded, mirrored: _Bounded) -> _Bounded:
    """``(s + F)(s - F)``, a scalar: only that part is made."""
    masks = size.exact.masks
    plan = size.exact.algebra.plan("geometric", masks, mirrored.exact.masks, frozenset({0}))
    return size.made_by(plan, mirrored)


def _bound(divisor: _Bounded) -> Any:
    if divisor.sizes is None:
        return None
    size = np.asarray(divisor.sizes.scalar_part())
    kind = size.dtype if size.dtype.kind == "f" else np.dtype(np.float64)
    return _ROUNDINGS * float(np.finfo(kind).eps) * size


def _divided(x: BladeSum, divisor: _Bounded) -> BladeSum:
    value, bound = divisor.exact.scalar_part(), _bound(divisor)
    zero = is_zero_somewhere(value) if bound is None else bool(np.any(np.abs(value) <= bound))
    if zero:
        raise ValueError(
            "inverse: expected an invertible multivector, got one whose divisor is zero to rounding"
        )
    return x._divided(value)
