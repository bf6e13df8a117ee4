"""Basis blades as bit masks: bit k stands for basis vector k, factors in ascending order.

`Basis` multiplies blades. Where two of its vectors are a null pair, it goes through the
orthogonal basis ep, em: ``e0 = ½ (em - ep)``, ``einf = ep + em``, so ``einf·e0 = -1`` and
``e0∧einf = -ep∧em``. All coefficients are halves of whole numbers, hence exact.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

# A sum of blades: mask and coefficient.
Terms = tuple[tuple[int, float], ...]


def grade_of(mask: int) -> int:
    """How many vectors a blade is the outer product of."""
    return mask.bit_count()


def indices_of(mask: int) -> tuple[int, ...]:
    """Positions of a blade's vectors, ascending."""
    return tuple(k for k in range(mask.bit_length()) if mask >> k & 1)


def order_of(mask: int) -> tuple[int, tuple[int, ...]]:
    """Key that sorts blades by grade, then as words over the basis vectors."""
    return grade_of(mask), indices_of(mask)


def reorder_sign(a: int, b: int) -> int:
    """Sign of sorting the vectors of blade `a` followed by those of blade `b`."""
    swaps = 0
    a >>= 1
    while a:
        swaps += (a & b).bit_count()
        a >>= 1
    return -1 if swaps & 1 else 1


@dataclass(frozen=True)
class Basis:
    """Basis vectors with squares 1, -1 or 0; the last two may stand for a null pair.

    With `null_pair` the squares are those of the orthogonal basis that ends in ep, em, while the
    blades that go in and come out are those of the basis that ends in e0, einf.
    """

    squares: tuple[int, ...]
    null_pair: bool
    _products: dict[tuple[int, int], Terms] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @property
    def size(self) -> int:
        """Number of basis vectors."""
        return len(self.squares)

    def product(self, a: int, b: int) -> Terms:
        """Geometric product of two blades, in the order of the masks' grades."""
        made = self._products.get((a, b))
        if made is None:
            made = self._products[a, b] = self._multiplied(a, b)
        return made

    def to_orthogonal(self, mask: int) -> Terms:
        """A blade of this basis in the orthogonal one."""
        return self._exchanged(mask, ((0, -0.5), (1, 0.5)), ((0, 1.0), (1, 1.0)))

    def from_orthogonal(self, mask: int) -> Terms:
        """A blade of the orthogonal basis in this one."""
        return self._exchanged(mask, ((0, -1.0), (1, 0.5)), ((0, 1.0), (1, 0.5)))

    def _exchanged(self, mask: int, first: Terms, second: Terms) -> Terms:
        """Replace the last two vectors by the given sums over the other basis' last two."""
        low = self.size - 2
        pair = mask >> low if self.null_pair else 0
        rest = mask & ~(3 << low) if self.null_pair else mask
        if pair == 0:
            return ((mask, 1.0),)
        if pair == 3:
            return ((mask, -1.0),)
        return tuple(
            (rest | 1 << low + k, factor) for k, factor in (first if pair == 1 else second)
        )

    def _multiplied(self, a: int, b: int) -> Terms:
        if not self.null_pair:
            return _collected([self._orthogonal_product(a, b)])
        return _collected(
            (mask, one * two * factor * back)
            for left, one in self.to_orthogonal(a)
            for right, two in self.to_orthogonal(b)
            for product, factor in [self._orthogonal_product(left, right)]
            for mask, back in self.from_orthogonal(product)
        )

    def _orthogonal_product(self, a: int, b: int) -> tuple[int, float]:
        factor = reorder_sign(a, b)
        for k in indices_of(a & b):
            factor *= self.squares[k]
        return a ^ b, float(factor)


def _collected(terms: Iterable[tuple[int, float]]) -> Terms:
    """Add up equal blades and leave out what cancels."""
    total: dict[int, float] = {}
    for mask, factor in terms:
        total[mask] = total.get(mask, 0.0) + factor
    return tuple((m, total[m]) for m in sorted(total, key=order_of) if total[m] != 0.0)
