"""Basis blades as bit masks: bit k stands for basis vector k, factors in ascending order.

`Basis` multiplies blades of any number of vectors that are orthogonal to each other, and of null
pairs ``o, i`` with ``o·i = -1``, orthogonal to all else. A pair of positions that holds the pair
holds ``ep, em`` in the orthogonal basis: ``o = ½ (em - ep)``, ``i = ep + em``, so
``o∧i = -ep∧em``. All coefficients are halves of whole numbers, hence exact. Only products that are
asked for are computed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

# A sum of blades: mask and coefficient.
Terms = tuple[tuple[int, float], ...]

# Products of the blades of one null pair: bit 0 is o, bit 1 is i, 3 is o∧i. By o·i = -1,
# o i = o∧i - 1, i o = -o∧i - 1, and so on; what is missing is zero.
_PAIR: dict[tuple[int, int], Terms] = {
    **{(0, b): ((b, 1.0),) for b in range(4)},
    **{(a, 0): ((a, 1.0),) for a in range(1, 4)},
    (1, 2): ((0, -1.0), (3, 1.0)),
    (2, 1): ((0, -1.0), (3, -1.0)),
    (1, 3): ((1, 1.0),),
    (3, 1): ((1, -1.0),),
    (2, 3): ((2, -1.0),),
    (3, 2): ((2, 1.0),),
    (3, 3): ((0, 1.0),),
}
_KEPT_PRODUCTS = 1 << 17


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
    # Bit k of `odd`: whether an odd number of the vectors of b come before vector k.
    odd = b << 1
    shift = 1
    while shift < a.bit_length():
        odd ^= odd << shift
        shift <<= 1
    return -1 if (a & odd).bit_count() & 1 else 1


@dataclass(frozen=True)
class Basis:
    """Basis vectors with squares 1, -1 or 0, some of whose positions hold null pairs.

    `squares` are those of the orthogonal basis, which has ep at the first and em at the second
    position of each of `pairs` (its vector ``o`` comes first, as given). Blades that go in and out
    are those of the basis with the pairs.
    """

    squares: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...]
    _products: dict[tuple[int, int], Terms] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @property
    def size(self) -> int:
        """Number of basis vectors."""
        return len(self.squares)

    def product(self, a: int, b: int) -> Terms:
        """Geometric product of two blades, in the order of the masks' grades."""
        terms = self._products.get((a, b))
        if terms is None:
            terms = self._multiplied(a, b) if self.pairs else self._orthogonal_product(a, b)
            if len(self._products) < _KEPT_PRODUCTS:
                self._products[a, b] = terms
        return terms

    def outer(self, a: int, b: int) -> Terms:
        """Outer product of two blades, which no metric changes."""
        return () if a & b else ((a | b, float(reorder_sign(a, b))),)

    def to_orthogonal(self, mask: int) -> Terms:
        """A blade of this basis in the orthogonal one."""
        return self._exchanged(mask, ((0, -0.5), (1, 0.5)), ((0, 1.0), (1, 1.0)))

    def from_orthogonal(self, mask: int) -> Terms:
        """A blade of the orthogonal basis in this one."""
        return self._exchanged(mask, ((0, -1.0), (1, 0.5)), ((0, 1.0), (1, 0.5)))

    def _exchanged(self, mask: int, first: Terms, second: Terms) -> Terms:
        """Replace the vectors of each pair by the given sums over the other basis' two."""
        total: dict[int, float] = {0: 1.0}
        for k in indices_of(mask):
            factor: Terms = ((1 << k, 1.0),)
            for pair in self.pairs:
                if k in pair:
                    said = first if k == pair[0] else second
                    factor = tuple((1 << pair[place], value) for place, value in said)
            total = wedged(total, factor)
        return _collected(total.items())

    def _orthogonal_product(self, a: int, b: int) -> Terms:
        factor = reorder_sign(a, b)
        for k in indices_of(a & b):
            factor *= self.squares[k]
        return ((a ^ b, float(factor)),) if factor else ()

    def _multiplied(self, a: int, b: int) -> Terms:
        """A product with null pairs.

        Vectors of different pairs anticommute. So the factors are sorted by their pairs, multiplied
        pair by pair, and sorted back; only the signs of sorting tell orders apart.
        """
        terms: list[tuple[int, float]] = [(0, 1.0)]
        bits = 0
        for o, i in self.pairs:
            bits |= 1 << o | 1 << i
            there = (a >> o & 1) + 2 * (a >> i & 1), (b >> o & 1) + 2 * (b >> i & 1)
            terms = [
                (mask | (part & 1) << o | (part >> 1) << i, c * f * turned)
                for part, f in _PAIR.get(there, ())
                for turned in [self._pair_sign(o, i, *there, part)]
                for mask, c in terms
            ]
        rest = (a ^ b) & ~bits
        factor = float(self._sorting_sign(a, b))
        for k in indices_of(a & b & ~bits):
            factor *= self.squares[k]
        return _collected(
            (mask | rest, c * factor * self._grouping_sign(mask | rest)) for mask, c in terms
        )

    @staticmethod
    def _pair_sign(o: int, i: int, *parts: int) -> int:
        """-1 where an odd number of the parts are o∧i, in a basis where `i` comes before `o`."""
        return -1 if i < o and parts.count(3) & 1 else 1

    def _sorting_sign(self, a: int, b: int) -> int:
        """Sign of sorting `a` followed by `b` by pairs, the vectors of a pair left in order."""
        swaps = 0
        for k in indices_of(b):
            swaps += (a & self._above[k]).bit_count()
        sign = self._grouping_sign(a) * self._grouping_sign(b)
        return -sign if swaps & 1 else sign

    def _grouping_sign(self, mask: int) -> int:
        """Sign of sorting a blade's vectors by pairs."""
        swaps = 0
        for k in indices_of(mask):
            swaps += (mask & self._above[k] & (1 << k) - 1).bit_count()
        return -1 if swaps & 1 else 1

    @cached_property
    def _above(self) -> tuple[int, ...]:
        """For each vector those of later groups, a pair being one group at its first vector."""
        group = list(range(self.size))
        for o, i in self.pairs:
            group[o] = group[i] = min(o, i)
        everything = range(self.size)
        return tuple(sum(1 << j for j in everything if group[j] > group[k]) for k in everything)


def wedged(total: dict[int, float], factor: Terms) -> dict[int, float]:
    """A sum of blades and the outer product of each with a vector, from the right."""
    sums: dict[int, float] = {}
    for mask, coefficient in total.items():
        for bit, weight in factor:
            if not mask & bit:
                signed = reorder_sign(mask, bit) * coefficient * weight
                sums[mask | bit] = sums.get(mask | bit, 0.0) + signed
    return {mask: value for mask, value in sums.items() if value != 0.0}


def _collected(terms: Iterable[tuple[int, float]]) -> Terms:
    """Add up equal blades and leave out what cancels."""
    total: dict[int, float] = {}
    for mask, factor in terms:
        total[mask] = total.get(mask, 0.0) + factor
    return tuple((m, total[m]) for m in sorted(total, key=order_of) if total[m] != 0.0)
