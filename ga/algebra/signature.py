"""Signature: named basis vectors with their squares, blades by name, and plans of products.

The order of the basis is: p vectors that square to 1, q to -1, r to 0; a null pair comes last. A
blade's name joins its vectors with ``^``; the scalar is ``"1"``. `Algebra` makes multivectors.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

from motorcade.ga.algebra.basis import Basis, Terms, indices_of, order_of, wedged
from motorcade.ga.algebra.products import Masks, Plan, plan_product, symmetric

MAX_DIMENSION = 16
MAX_NAMED = 64
_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")


class Signature:
    """What multivectors need to know of their algebra, which is the subclass `Algebra`."""

    __slots__ = ("_bits", "_named", "_plans", "basis", "names", "null_pair", "signature")

    basis: Basis
    names: tuple[str, ...]
    null_pair: bool
    signature: tuple[int, int, int]

    def __init__(
        self,
        p: int,
        q: int = 0,
        r: int = 0,
        names: Sequence[str] | None = None,
        *,
        null_pair: bool = False,
    ) -> None:
        _check_counts(p, q, r, null_pair)
        size = p + q + r
        chosen = tuple(names) if names is not None else _default_names(size, null_pair)
        _check_names(chosen, size)
        if null_pair and {"ep", "em"} & set(chosen):
            raise ValueError(
                f"Algebra.names: expected no ep or em beside a null pair, got {chosen}"
            )
        basis = Basis((1,) * p + (-1,) * q + (0,) * r, ((size - 2, size - 1),) if null_pair else ())
        self._set(basis, chosen, _of_pairs(basis, [("ep", "em")]) if null_pair else {})

    def _set(self, basis: Basis, names: tuple[str, ...], named: dict[str, Terms]) -> None:
        squares = basis.squares
        self.signature = (squares.count(1), squares.count(-1), squares.count(0))
        self.names = names
        self.basis = basis
        # Whether it is what `null_pair` makes: a pair at the end, ep and em.
        last = ((len(names) - 2, len(names) - 1),)
        self.null_pair = basis.pairs == last and set(named) == {"ep", "em"}
        self._bits = {name: 1 << k for k, name in enumerate(names)}
        self._named = named
        self._plans: dict[Any, Plan] = {}

    def _set_like(self, other: Signature) -> None:
        """Become the algebra that `other` is, with plans of its own."""
        self._set(other.basis, other.names, other._named)

    @property
    def named(self) -> tuple[str, ...]:
        """Names of the vectors that stand for sums of basis vectors, as ep and em do."""
        return tuple(self._named)

    @property
    def dimension(self) -> int:
        """Number of basis vectors."""
        return len(self.names)

    @property
    def blades(self) -> tuple[str, ...]:
        """Names of all basis blades, by grade, then in the order of the basis."""
        everything = range(self.dimension)
        return tuple(
            self.blade_name(sum(1 << k for k in chosen))
            for grade in range(self.dimension + 1)
            for chosen in combinations(everything, grade)
        )

    def blade_name(self, mask: int) -> str:
        """Name of the basis blade whose vectors are the bits of `mask`."""
        return "^".join(self.names[k] for k in indices_of(mask)) or "1"

    @property
    def orthogonal(self) -> Signature:
        """The same on its orthogonal basis, which has ep and em in the places of a null pair.

        With several pairs these are ep1, em1, ep2, …; an underscore follows names that are taken.
        """
        if not self.basis.pairs:
            return self
        names = list(self.names)
        for number, pair in enumerate(self.basis.pairs, 1):
            for place, name in zip(pair, ("ep", "em"), strict=True):
                wanted = name if len(self.basis.pairs) == 1 else f"{name}{number}"
                while wanted in names:
                    wanted += "_"
                names[place] = wanted
        signature: Signature = object.__new__(type(self))
        signature._set(Basis(self.basis.squares, ()), tuple(names), {})
        return signature

    @property
    def pseudoscalar_sign(self) -> int:
        """Of the unit pseudoscalar on the blade of all vectors in their order.

        It has ``einf∧e0`` of a null pair: a pair written the other way round turns the sign.
        """
        return -1 if sum(o < i for o, i in self.basis.pairs) & 1 else 1

    def masks_of(self, name: str) -> Terms:
        """A named blade as basis blades with signs; more than one where ep or em occurs.

        Raises ValueError: a name that is not in this algebra, or a vector that occurs twice.
        """
        if not isinstance(name, str):
            raise ValueError(f"{self}: expected the name of a blade, got {name!r}")
        total: dict[int, float] = {0: 1.0}
        for factor in [] if name == "1" else name.split("^"):
            total = wedged(total, self._factor(factor.strip(), name))
            if not total:
                raise ValueError(f"{self}: expected a blade that is not zero, got {name!r}")
        return tuple((mask, total[mask]) for mask in sorted(total, key=order_of))

    def _factor(self, factor: str, name: str) -> Terms:
        bit = self._bits.get(factor)
        if bit is not None:
            return ((bit, 1.0),)
        if factor in self._named:
            return self._named[factor]
        known = " ".join((*self.names, *self._named))
        raise ValueError(f"{self}: expected a blade of {known} joined by '^', got {name!r}")

    def plan(
        self, kind: str, left: Masks, right: Masks, grades: frozenset[int] | None = None
    ) -> Plan:
        """The terms of a product of two blade sets, found once (see `products`)."""
        key = (kind, left, right, grades)
        product_plan = self._plans.get(key)
        if product_plan is None:
            product_plan = self._plans[key] = plan_product(self.basis, kind, left, right, grades)
        return product_plan

    def symmetric_plan(self, masks: Masks, signs: tuple[int, ...]) -> Plan:
        """The terms of ``x`` times ``x`` with signs, those that cancel by symmetry left out."""
        key = ("symmetric", masks, signs, None)
        shared_plan = self._plans.get(key)
        if shared_plan is None:
            plan = self.plan("geometric", masks, masks)
            shared_plan = self._plans[key] = symmetric(plan, signs)
        return shared_plan

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Signature):
            return NotImplemented
        return (
            self.basis == other.basis and self.names == other.names and self._named == other._named
        )

    def __hash__(self) -> int:
        return hash((self.basis.squares, self.basis.pairs, self.names))

    def __repr__(self) -> str:
        return f"Algebra{self.signature}[{' '.join(self.names)}]"


def _default_names(dimension: int, null_pair: bool) -> tuple[str, ...]:
    plain = dimension - 2 if null_pair else dimension
    pair = ("e0", "einf") if null_pair else ()
    return (*(f"e{k + 1}" for k in range(plain)), *pair)


def _check_counts(p: int, q: int, r: int, null_pair: bool) -> None:
    for name, count in (("p", p), ("q", q), ("r", r)):
        if isinstance(count, bool) or not isinstance(count, int) or count < 0:
            raise ValueError(f"Algebra.{name}: expected a whole number from 0, got {count!r}")
    if not 1 <= p + q + r <= MAX_DIMENSION:
        raise ValueError(
            f"Algebra(p, q, r): expected 1 to {MAX_DIMENSION} basis vectors, got {p + q + r}"
        )
    if null_pair and (p == 0 or (q, r) != (1, 0)):
        raise ValueError(
            f"Algebra.null_pair: expected a signature (p, 1, 0) with p >= 1, got {(p, q, r)}"
        )


def _of_pairs(basis: Basis, names: Sequence[tuple[str, str]]) -> dict[str, Terms]:
    """The vectors ep and em of each null pair under these names."""
    return {
        name: basis.from_orthogonal(1 << place)
        for pair, said in zip(basis.pairs, names, strict=True)
        for place, name in zip(pair, said, strict=True)
    }


def _check_names(names: tuple[str, ...], dimension: int) -> None:
    if len(names) != dimension or len(set(names)) != dimension:
        raise ValueError(f"Algebra.names: expected {dimension} distinct names, got {names}")
    for name in names:
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            raise ValueError(f"Algebra.names: expected identifiers, got {name!r}")


def checked_vectors(
    squares: Mapping[str, int],
    null_pairs: Sequence[tuple[str, str]],
    named: Mapping[str, Mapping[str, float]] | None,
) -> tuple[Basis, tuple[str, ...], dict[str, Terms]]:
    """The basis, the names of its vectors, and what other names stand for; see `Algebra.of`.

    Raises ValueError: whatever `Algebra.of` refuses.
    """
    names = tuple(squares)
    if not 1 <= len(names) <= MAX_DIMENSION:
        raise ValueError(
            f"Algebra.of(squares): expected 1 to {MAX_DIMENSION} basis vectors, got {len(names)}"
        )
    _check_names(names, len(names))
    signs = list(squares.values())
    for name, square in squares.items():
        if isinstance(square, bool) or square not in (-1, 0, 1):
            raise ValueError(f"Algebra.of(squares): expected 1, -1 or 0 for {name}, got {square!r}")
    paired = [name for pair in null_pairs for name in pair]
    if len(set(paired)) != len(paired) or any(squares.get(name) != 0 for name in paired):
        raise ValueError(
            f"Algebra.of(null_pairs): expected pairs of different vectors of square 0, "
            f"got {list(null_pairs)}"
        )
    places = tuple((names.index(o), names.index(i)) for o, i in null_pairs)
    for o, i in places:
        signs[o], signs[i] = 1, -1
    basis = Basis(tuple(map(int, signs)), places)
    if named is None:
        alone = len(places) == 1 and not {"ep", "em"} & set(names)
        return basis, names, _of_pairs(basis, [("ep", "em")]) if alone else {}
    return basis, names, _checked_sums(names, named)


def _checked_sums(
    names: tuple[str, ...], named: Mapping[str, Mapping[str, float]]
) -> dict[str, Terms]:
    if len(named) > MAX_NAMED:
        raise ValueError(f"Algebra.of(named): expected at most {MAX_NAMED}, got {len(named)}")
    _check_names((*names, *named), len(names) + len(named))
    checked_sums: dict[str, Terms] = {}
    for name, parts in named.items():
        for part, value in parts.items():
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if part not in names or not number or not math.isfinite(value) or value == 0:
                raise ValueError(
                    f"Algebra.of(named): expected {name} as numbers by basis vectors, "
                    f"got {value!r} of {part!r}"
                )
        if not parts:
            raise ValueError(f"Algebra.of(named): expected a sum for {name}, got none")
        places = sorted((names.index(part), float(value)) for part, value in parts.items())
        checked_sums[name] = tuple((1 << place, value) for place, value in places)
    return checked_sums
