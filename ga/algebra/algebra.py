"""Algebra: a signature with named basis vectors, from which blades and multivectors are made.

The order of the basis is: p vectors that square to 1, q to -1, r to 0; a null pair comes last. In
CGA3 that is e1 < e2 < e3 < e0 < einf. `Algebra.of` takes any order, and any number of null pairs.
A blade's name joins its vectors with ``^``; the scalar
is ``"1"``. Grades, reverse and outer product do not depend on which basis is written.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from motorcade.ga.algebra.basis import Basis, Terms
from motorcade.ga.algebra.multivector import Multivector
from motorcade.ga.algebra.signature import Signature, checked_vectors


class Algebra(Signature):
    """The geometric algebra of `p` vectors that square to 1, `q` to -1 and `r` to 0.

    Args:
        p: how many basis vectors square to 1; likewise `q` and `r`. At most 16 in all.
        names: of the basis vectors in this order; e1, e2, … if none are given.
        null_pair: let the last positive vector ep and the one negative vector em be written as
            ``e0 = ½ (em - ep)`` and ``einf = ep + em``, as in conformal algebras. They come last
            in `names`; ``ep`` and ``em`` are understood wherever a blade is named.

    Raises:
        ValueError: counts that are negative or too large, names that are no distinct identifiers,
            a null pair in a signature that is not (p, 1, 0).

    Examples:
        >>> from motorcade.ga import Algebra
        >>> spacetime = Algebra(1, 3, names=("t", "x", "y", "z"))
        >>> event = spacetime.multivector({"t": 5.0, "x": 3.0})
        >>> (event * event)["1"]
        16.0
    """

    __slots__ = ()

    @classmethod
    def of(
        cls,
        squares: Mapping[str, int],
        null_pairs: Sequence[tuple[str, str]] = (),
        named: Mapping[str, Mapping[str, float]] | None = None,
    ) -> Algebra:
        """The algebra of these basis vectors, in this order.

        Args:
            squares: 1, -1 or 0 by the name of each basis vector.
            null_pairs: pairs ``(origin, infinity)`` of vectors, of square 0 above, whose inner
                product is -1. They are orthogonal to all others.
            named: names for sums of basis vectors, by their coefficients; a single null pair has
                ``ep`` and ``em`` where nothing is given.

        Raises:
            ValueError: no or too many vectors, names that are no distinct identifiers, squares
                that are not 1, -1 or 0, pairs that share a vector or name no vector of square 0.

        >>> from motorcade.ga import Algebra
        >>> double = Algebra.of({"o1": 0, "i1": 0, "o2": 0, "i2": 0}, [("o1", "i1"), ("o2", "i2")])
        >>> double.signature, (double.blade("o2") | double.blade("i2"))["1"]
        ((2, 2, 0), -1)
        """
        algebra: Algebra = object.__new__(cls)
        algebra._set(*checked_vectors(squares, null_pairs, named))
        return algebra

    def blade(self, name: str) -> Multivector:
        """The blade of this name: ``"1"``, ``"e1^e2"``, ``"e3^e1"`` (which is ``-e1^e3``).

        Raises:
            ValueError: a name that is not in this algebra, or a vector that occurs twice.
        """
        return self.multivector({name: 1})

    def scalar(self, value: Any) -> Multivector:
        """The multivector of one scalar."""
        return self.multivector({"1": value})

    def vector(self, coordinates: Sequence[Any]) -> Multivector:
        """The vector with one coordinate for each basis vector, in their order.

        Raises:
            ValueError: another number of coordinates.
        """
        if len(coordinates) != self.dimension:
            raise ValueError(
                f"{self}.vector(coordinates): expected {self.dimension}, got {len(coordinates)}"
            )
        return self.multivector(dict(zip(self.names, coordinates, strict=True)))

    def multivector(self, coefficients: Mapping[str, Any]) -> Multivector:
        """The multivector with these coefficients by blade name; blades not named are zero.

        Coefficients are real scalars of any kind that adds and multiplies: numbers, NumPy arrays
        (batches, which broadcast), CasADi SX, torch tensors. Two names of one blade add up.

        Raises:
            ValueError: a name that is not in this algebra, a coefficient that is no real scalar,
                NaN or infinity.
        """
        return Multivector(self, coefficients)

    @property
    def orthogonal(self) -> Algebra:
        """The same algebra on its orthogonal basis, with ep and em in the places of a null pair."""
        orthogonal_algebra: Any = super().orthogonal
        return orthogonal_algebra  # type: ignore[no-any-return]

    @property
    def pseudoscalar(self) -> Multivector:
        """``I = e1∧e2∧…``; with a null pair ``I = e1∧…∧einf∧e0``, so that ``I² = -1`` in CGA3."""
        return Multivector._trusted(self, ((1 << self.dimension) - 1,), (self.pseudoscalar_sign,))

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self.basis.squares, self.basis.pairs, self.names, self._named)


def _rebuilt(
    squares: tuple[int, ...],
    pairs: tuple[tuple[int, int], ...],
    names: tuple[str, ...],
    named: dict[str, Terms],
) -> Algebra:
    rebuilt: Algebra = object.__new__(Algebra)
    rebuilt._set(Basis(squares, pairs), names, named)
    return rebuilt


EGA3 = Algebra(3)
PGA3 = Algebra(3, 0, 1, ("e1", "e2", "e3", "e0"))
CGA3 = Algebra(4, 1, null_pair=True)
