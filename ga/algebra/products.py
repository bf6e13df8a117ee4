"""Which terms a product of two sparse multivectors has: found once for each pair of blade sets.

A plan lists for every blade of the result the terms ``factor · left[i] · right[j]``. Terms whose
factor is zero are left out, and so are blades without terms: structural zeros are never stored.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from motorcade.ga.algebra.basis import Basis, Terms, grade_of, order_of
from motorcade.ga.algebra.scalars import scaled

Masks = tuple[int, ...]


class Plan(NamedTuple):
    """Blades of a product, and for each the terms (factor, index left, index right)."""

    masks: Masks
    terms: tuple[tuple[tuple[float, int, int], ...], ...]


def _geometric(basis: Basis, a: int, b: int) -> Terms:
    return basis.product(a, b)


def _outer(basis: Basis, a: int, b: int) -> Terms:
    return basis.outer(a, b)


def _inner(basis: Basis, a: int, b: int) -> Terms:
    """Hestenes' inner product: the grade ``|r - s|`` of blades, zero where either is a scalar."""
    r, s = grade_of(a), grade_of(b)
    if r == 0 or s == 0:
        return ()
    return tuple(term for term in basis.product(a, b) if grade_of(term[0]) == abs(r - s))


def _left_contraction(basis: Basis, a: int, b: int) -> Terms:
    """The grade ``s - r``, zero where the left operand's grade r is above the right one's s."""
    wanted = grade_of(b) - grade_of(a)
    return tuple(term for term in basis.product(a, b) if grade_of(term[0]) == wanted)


def _right_contraction(basis: Basis, a: int, b: int) -> Terms:
    """The grade ``r - s``, zero where the right operand's grade s is above the left one's r."""
    wanted = grade_of(a) - grade_of(b)
    return tuple(term for term in basis.product(a, b) if grade_of(term[0]) == wanted)


def _commutator(basis: Basis, a: int, b: int) -> Terms:
    other = dict(basis.product(b, a))
    forward = dict(basis.product(a, b))
    halves = {m: 0.5 * (forward.get(m, 0.0) - other.get(m, 0.0)) for m in {**forward, **other}}
    return tuple((m, halves[m]) for m in sorted(halves, key=order_of) if halves[m] != 0.0)


PRODUCTS: dict[str, Callable[[Basis, int, int], Terms]] = {
    "geometric": _geometric,
    "outer": _outer,
    "inner": _inner,
    "left": _left_contraction,
    "right": _right_contraction,
    "commutator": _commutator,
}


def plan_product(
    basis: Basis, kind: str, left: Masks, right: Masks, grades: frozenset[int] | None = None
) -> Plan:
    """The terms of a product; `grades` keeps only these of the result."""
    multiply = PRODUCTS[kind]
    terms_of: dict[int, list[tuple[float, int, int]]] = {}
    for i, a in enumerate(left):
        for j, b in enumerate(right):
            for mask, factor in multiply(basis, a, b):
                if grades is None or grade_of(mask) in grades:
                    terms_of.setdefault(mask, []).append((factor, i, j))
    return _ordered(terms_of)


def symmetric(plan: Plan, signs: Sequence[int]) -> Plan:
    """The plan of ``x`` times ``x`` with signed coefficients: equal terms joined, zeros left out.

    The right operand of `plan` has the same blades as the left; `signs` are its signs.
    """
    terms_of: dict[int, list[tuple[float, int, int]]] = {}
    for mask, terms in zip(plan.masks, plan.terms, strict=True):
        joined: dict[tuple[int, int], float] = {}
        for factor, i, j in terms:
            pair = (min(i, j), max(i, j))
            joined[pair] = joined.get(pair, 0.0) + factor * signs[j]
        kept = [(factor, i, j) for (i, j), factor in joined.items() if factor != 0.0]
        if kept:
            terms_of[mask] = kept
    return _ordered(terms_of)


def _ordered(terms_of: dict[int, list[tuple[float, int, int]]]) -> Plan:
    """Blades in their order; positive terms first, so that sums need no sign in front."""
    masks = tuple(sorted(terms_of, key=order_of))
    return Plan(masks, tuple(tuple(sorted(terms_of[m], key=lambda t: t[0] < 0)) for m in masks))


def majorant(plan: Plan) -> Plan:
    """The plan with positive factors: on absolute values it bounds the sizes of all terms."""
    return Plan(
        plan.masks, tuple(tuple((abs(f), i, j) for f, i, j in terms) for terms in plan.terms)
    )


def apply_plan(plan: Plan, left: Sequence[Any], right: Sequence[Any]) -> tuple[Any, ...]:
    """The coefficients of a product, over any scalars that add and multiply."""
    coefficients = []
    for terms in plan.terms:
        factor, i, j = terms[0]
        total = scaled(factor, left[i] * right[j])
        for factor, i, j in terms[1:]:
            product = left[i] * right[j]
            if factor == 1.0:
                total = total + product
            elif factor == -1.0:
                total = total - product
            else:
                total = total + scaled(factor, product)
        coefficients.append(total)
    return tuple(coefficients)
