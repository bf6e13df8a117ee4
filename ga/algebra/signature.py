"""Signature: named basis vectors with their squares, blades by name, and plans of products.

The order of the basis is: p vectors that square to 1, q to -1, r to 0; a null pair comes last. A
blade's name joins its vectors with ``^``; the scalar is ``"1"``. `Algebra` makes multivectors.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import combinations
from typing import Any

from motorcade.ga.algebra.basis import Basis, Terms, indices_of, order_of, reorder_sign
from motorcade.ga.algebra.products import Masks, Plan, plan_product, symmetric

MAX_DIMENSION = 10
_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")


class Signature:
    """What multivectors need to know of their algebra, which is the subclass `Algebra`."""

    __slots__ = ("_bits", "_plans", "basis", "names", "null_pair", "signature")

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
        given = tuple(names) if names is not None else _default_names(p + q + r, null_pair)
        _check_names(given, p + q + r, null_pair)
        squares = (1,) * p + (-1,) * q + (0,) * r
        self.signature = (p, q, r)
        self.names = given
        self.null_pair = null_pair
        self.basis = Basis(squares, null_pair)
        self._bits = {name: 1 << k for k, name in enumerate(given)}
        self._plans: dict[Any, Plan] = {}

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
        """The same on its orthogonal basis: itself, or the one that ends in ep, em."""
        if not self.null_pair:
            return self
        return type(self)(*self.signature, (*self.names[:-2], "ep", "em"))

    @property
    def pseudoscalar_sign(self) -> int:
        """Of the unit pseudoscalar on the blade of all vectors in their order."""
        return -1 if self.null_pair else 1

    def masks_of(self, name: str) -> Terms:
        """A named blade as basis blades with signs; more than one where ep or em occurs.

        Raises:
            ValueError: a name that is not in this algebra, or a vector that occurs twice.
        """
        if not isinstance(name, str):
            raise ValueError(f"{self}: expected the name of a blade, got {name!r}")
        total: dict[int, float] = {0: 1.0}
        for factor in [] if name == "1" else name.split("^"):
            total = _wedged(total, self._factor(factor.strip(), name))
            if not total:
                raise ValueError(f"{self}: expected a blade that is not zero, got {name!r}")
        return tuple((mask, total[mask]) for mask in sorted(total, key=order_of))

    def _factor(self, factor: str, name: str) -> Terms:
        bit = self._bits.get(factor)
        if bit is not None:
            return ((bit, 1.0),)
        if self.null_pair and factor in ("ep", "em"):
            shift = self.dimension - (2 if factor == "ep" else 1)
            return self.basis.from_orthogonal(1 << shift)
        known = " ".join(self.names) + (" ep em" if self.null_pair else "")
        raise ValueError(f"{self}: expected a blade of {known} joined by '^', got {name!r}")

    def plan(
        self, kind: str, left: Masks, right: Masks, grades: frozenset[int] | None = None
    ) -> Plan:
        """The terms of a product of two blade sets, found once (see `products`)."""
        key = (kind, left, right, grades)
        made = self._plans.get(key)
        if made is None:
            made = self._plans[key] = plan_product(self.basis, kind, left, right, grades)
        return made

    def symmetric_plan(self, masks: Masks, signs: tuple[int, ...]) -> Plan:
        """The terms of ``x`` times ``x`` with signs, those that cancel by symmetry left out."""
        key = ("symmetric", masks, signs, None)
        made = self._plans.get(key)
        if made is None:
            plan = self.plan("geometric", masks, masks)
            made = self._plans[key] = symmetric(plan, signs)
        return made

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Signature):
            return NotImplemented
        return self.basis == other.basis and self.names == other.names

    def __hash__(self) -> int:
        return hash((self.basis.squares, self.null_pair, self.names))

    def __repr__(self) -> str:
        return f"Algebra{self.signature}[{' '.join(self.names)}]"


def _wedged(total: dict[int, float], factor: Terms) -> dict[int, float]:
    made: dict[int, float] = {}
    for mask, coefficient in total.items():
        for bit, weight in factor:
            if not mask & bit:
                signed = reorder_sign(mask, bit) * coefficient * weight
                made[mask | bit] = made.get(mask | bit, 0.0) + signed
    return {mask: value for mask, value in made.items() if value != 0.0}


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


def _check_names(names: tuple[str, ...], dimension: int, null_pair: bool) -> None:
    if len(names) != dimension or len(set(names)) != dimension:
        raise ValueError(f"Algebra.names: expected {dimension} distinct names, got {names}")
    for name in names:
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            raise ValueError(f"Algebra.names: expected identifiers, got {name!r}")
    if null_pair and {"ep", "em"} & set(names):
        raise ValueError(f"Algebra.names: expected no ep or em beside a null pair, got {names}")
