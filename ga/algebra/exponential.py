"""The exponential of multivectors, and the closed forms that it and the logarithm share.

Closed forms hold for elements whose square is ``s + F`` with ``F²`` a scalar: then ``1, F, y, Fy``
span a commutative algebra, in which every analytic function of ``y`` lies. So it is for simple
elements (no ``F``), and for bivectors and even elements in at most five dimensions, where ``F`` is
of grade 4: two commuting simple parts of squares ``P + Q = s`` and ``4 P Q = F²``. The sign of a
scalar is often known from the blades alone: -1, 1, or 0 where it is not.

With ``C(s) = cosh √s`` and ``S(s) = sinh √s / √s``, which are analytic (cosine and sine for
negative ``s``), ``exp y = C + S y`` where ``y² = s``. Where ``y = y₁ + y₂`` with commuting parts of
squares ``P`` and ``Q``, ``exp y = (C(P) + S(P) y₁) (C(Q) + S(Q) y₂)``, written here so that nothing
is lost where they are small, equal or zero. Anything else needs numbers: a Taylor series of
``y / 2ᵏ``, then k squarings (Higham, "Functions of Matrices", chapter 10), good to about ``2ᵏ``
roundings.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from motorcade.ga.algebra.blade_sum import BladeSum
from motorcade.ga.algebra.scalars import (
    apply,
    is_numeric,
    larger,
    magnitude,
    power_series,
    signed,
    where,
)


class Square(NamedTuple):
    """``y² = scalar + rest`` and ``rest² = rest_squared``, None where that is zero by structure."""

    scalar: Any
    sign: int
    rest: BladeSum
    rest_squared: Any
    rest_sign: int

    @property
    def is_scalar(self) -> bool:
        """Whether the square is a scalar by structure."""
        return not self.rest.masks


def without_scalar(x: BladeSum) -> BladeSum:
    """The parts of all grades but 0."""
    return x._selected(bool)


def square_of(y: BladeSum) -> Square | None:
    """The square of an element; None where it is not of the form above."""
    whole = y.square()
    rest = without_scalar(whole)
    above = rest.square()
    if any(above.masks):
        return None
    squared = above.scalar_part() if above.masks else None
    return Square(whole.scalar_part(), _sign_of_square(y), rest, squared, _sign_of_square(rest))


def _sign_of_square(y: BladeSum) -> int:
    """The sign of ``⟨y²⟩₀`` if the blades fix it: all its terms are squares of one sign."""
    plan = y.algebra.symmetric_plan(y.masks, (1,) * len(y.masks))
    if not plan.masks or plan.masks[0] != 0:
        return 0
    signs = {0 if i != j else 1 if factor > 0 else -1 for factor, i, j in plan.terms[0]}
    return signs.pop() if len(signs) == 1 else 0


def commuting_product(rest: BladeSum, y: BladeSum) -> BladeSum:
    """``F y`` for ``y² = s + F``: only the grades that do not cancel.

    It has the reverse and the parity of `y`, where all of `y` has one.
    """
    kinds = {(grade % 4 in (2, 3), grade % 2) for grade in y.grades}
    grades = range(y.algebra.dimension + 1)
    kept = frozenset(g for g in grades if (g % 4 in (2, 3), g % 2) in kinds)
    return rest._product("geometric", y, kept if len(kinds) == 1 else None)


def parts_of_sum(total: Any, four_product: Any, sign: int) -> tuple[Any, Any]:
    """The two real numbers with this sum and this fourfold product.

    With `sign` -1 they are of opposite signs, the first at least 0; otherwise the first is the one
    of larger size. Where there are none, which is where the product is larger than the square of
    the sum, they are the nearest.
    """
    root = apply("sqrt", larger(total * total - four_product, 0.0))
    big = (magnitude(total) + root) / 2
    if sign < 0:
        small = -four_product / (4 * nonzero(big))
        return where(total >= 0, big, small), -where(total >= 0, small, big)
    first = where(total >= 0, big, -big)
    return first, four_product / (4 * nonzero(first))


def weights(p: Any, q: Any) -> tuple[Any, Any]:
    """``p / (p - q)`` and ``-q / (p - q)``, which add up to 1 and lose no digits; 0 and 1 at 0."""
    divisor = nonzero(p - q)
    return p / divisor, where(p == q, 1.0, -q / divisor)


def plus(scalar: Any, *parts: BladeSum) -> BladeSum:
    """A scalar and at least one multivector, added up; a scalar that overflowed stays infinite."""
    total = parts[0]._wrap((0,), (scalar,))
    for part in parts:
        total = total + part
    return total


def nonzero(value: Any) -> Any:
    """A divisor: 1 where the value is 0."""
    return where(value == 0, 1.0, value)


def any_holds(condition: Any) -> bool:
    """Whether a comparison of numbers holds somewhere; one of symbols counts as not."""
    return isinstance(condition, bool | np.bool_ | np.ndarray) and bool(np.any(condition))


def numeric(x: BladeSum) -> bool:
    """Whether all coefficients are numbers."""
    return all(map(is_numeric, x.values))


def roundings(x: BladeSum, count: float) -> float:
    """So many roundings of 1, in the coarsest of the coefficients' types."""
    kinds = [np.asarray(value).dtype for value in x.values if is_numeric(value)]
    steps = [float(np.finfo(kind).eps) for kind in kinds if kind.kind == "f"]
    return count * max(steps, default=float(np.finfo(np.float64).eps))


# Of a multivector without closed form, as the sum of its coefficients' sizes.
LARGEST_NORM = 2.0**20
_TAYLOR = 16

_NEAR_ZERO = 0.01
_COSINE = tuple(1 / math.factorial(2 * n) for n in range(6))
_SINE = tuple(1 / math.factorial(2 * n + 1) for n in range(6))
# The derivative of S loses digits sooner.
_NEAR = 0.5
_SLOPE = tuple((n + 1) / math.factorial(2 * n + 3) for n in range(9))


def exp(x: BladeSum) -> BladeSum:
    """``1 + x + x²/2! + …``, coefficients over their batch.

    Raises:
        ValueError: no closed form (see `commuting`), and symbols or a norm above `LARGEST_NORM`.
    """
    with np.errstate(all="ignore"):
        rest = without_scalar(x)
        if not rest.masks:
            return plus(apply("exp", x.scalar_part()), rest)
        square = square_of(rest)
        exponential = _summed(rest) if square is None else _closed(rest, square)
        return exponential._scaled(apply("exp", x.values[0])) if x.masks[0] == 0 else exponential


def _closed(y: BladeSum, square: Square) -> BladeSum:
    s, rest, f = square.scalar, square.rest, square.rest_squared
    if square.is_scalar:
        cosine, sine, _ = _circular(s, square.sign)
        return plus(cosine, y._scaled(sine))
    if f is None:
        cosine, sine, reciprocal = _circular(s, square.sign)
        parts = cosine, sine / 2, sine, _slope(s, cosine, sine, reciprocal)
    else:
        parts = _of_parts(s, f, square.rest_sign)
        if square.rest_sign >= 0:
            # P and Q are no good where they are nearly equal, nor where they are not real.
            equal = 2 * f > s * s
            others = _split(s, where(equal, f, 1.0))
            parts = tuple(where(equal, b, a) for a, b in zip(parts, others, strict=True))
    once, twice, linear, cubic = parts
    product = commuting_product(rest, y)
    return plus(once, rest._scaled(twice), y._scaled(linear), product._scaled(cubic))


def _of_parts(s: Any, f: Any, sign: int) -> tuple[Any, Any, Any, Any]:
    """Coefficients of ``1, F, y, Fy`` from the squares P and Q of the commuting parts."""
    p, q = parts_of_sum(s, f, sign)
    opposite = sign < 0
    cosine_p, sine_p, reciprocal_p = _circular(p, 1 if opposite else 0)
    cosine_q, sine_q, reciprocal_q = _circular(q, -1 if opposite else 0)
    slope_p = _slope(p, cosine_p, sine_p, reciprocal_p)
    slope_q = _slope(q, cosine_q, sine_q, reciprocal_q)
    weight_p, other = weights(p, q)
    linear = weight_p * sine_p * cosine_q + other * cosine_p * sine_q
    cubic = weight_p * slope_p * sine_q + other * sine_p * slope_q
    return cosine_p * cosine_q, sine_p * sine_q / 2, linear, cubic


def _split(s: Any, f: Any) -> tuple[Any, Any, Any, Any]:
    """Coefficients of ``1, F, y, Fy`` from the values ``s ± √f`` of the square, for ``f > 0``."""
    root = apply("sqrt", larger(f, 0.0))
    divisor = 2 * nonzero(root)
    more, less = _circular(s + root, 0)[:2], _circular(s - root, 0)[:2]
    means = [(a + b) / 2 for a, b in zip(more, less, strict=True)]
    slopes = [(a - b) / divisor for a, b in zip(more, less, strict=True)]
    return means[0], slopes[0], means[1], slopes[1]


def _circular(s: Any, sign: int) -> tuple[Any, Any, Any]:
    """``C(s)``, ``S(s)``, and ``1 / s`` where that is not near zero.

    `sign` is that of `s` where it is known.
    """
    near = magnitude(s) < _NEAR_ZERO
    root = apply("sqrt", larger(magnitude(s), _NEAR_ZERO))
    inverse = 1 / root
    reciprocal = inverse * inverse
    cosine: Any = 0.0
    sine: Any = 0.0
    if sign <= 0:
        cosine, sine = apply("cos", root), apply("sin", root) * inverse
    if sign >= 0:
        grown = apply("exp", root)
        hyperbolic = (grown + 1 / grown) / 2, (grown - 1 / grown) / 2 * inverse
        cosine = where(s < 0, cosine, hyperbolic[0]) if sign == 0 else hyperbolic[0]
        sine = where(s < 0, sine, hyperbolic[1]) if sign == 0 else hyperbolic[1]
    small = where(near, s, 0.0)
    return (
        where(near, power_series(small, _COSINE), cosine),
        where(near, power_series(small, _SINE), sine),
        signed(reciprocal, s, sign),
    )


def _slope(s: Any, cosine: Any, sine: Any, reciprocal: Any) -> Any:
    """``S′(s) = (C - S) / 2s``."""
    near = magnitude(s) < _NEAR
    small = where(near, s, 0.0)
    return where(near, power_series(small, _SLOPE), (cosine - sine) / 2 * reciprocal)


def _summed(y: BladeSum) -> BladeSum:
    """By scaling and squaring, for numbers."""
    if not numeric(y):
        raise ValueError(
            "exp: expected symbols with a closed form, whose square is s + F with F² a scalar, "
            f"got blades {' '.join(y.blades[:6])}"
        )
    sizes: Any = sum(np.abs(value) for value in y.as_orthogonal().values)
    size = float(np.max(sizes))
    if not size <= LARGEST_NORM:
        raise ValueError(
            f"exp: expected coefficients whose sizes add up to at most {LARGEST_NORM:g} where "
            f"there is no closed form, got {size:g}"
        )
    halvings = max(0, math.ceil(math.log2(size)) + 1) if size > 0 else 0
    scaled = y._scaled(2.0**-halvings)
    total: BladeSum = y._lifted(1.0)
    for k in range(_TAYLOR, 0, -1):
        total = 1.0 + (scaled * total)._scaled(1.0 / k)
    for _ in range(halvings):
        total = total.square()
    return total
