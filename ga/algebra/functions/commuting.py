"""What makes closed forms possible: elements whose square is ``s + F`` with ``F²`` a scalar.

Then ``1, F, y, Fy`` span a commutative algebra, in which every analytic function of ``y`` lies. So
it is for simple elements (no ``F``), and for all bivectors and even elements in at most five
dimensions, where ``F`` is of grade 4. A bivector there is the sum of two commuting simple ones
whose squares ``P`` and ``Q`` have ``P + Q = s`` and ``4 P Q = F²``. The sign of a scalar is often
known from the blades alone: -1, 1, or 0 where it is not.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from motorcade.ga.algebra.blade_sum import BladeSum
from motorcade.ga.algebra.functions.elementary import apply, larger, where
from motorcade.ga.algebra.scalars import is_numeric, magnitude


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
