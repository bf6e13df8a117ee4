"""What steps of a script cost: as many terms as scalars are multiplied, or a bound of that."""

from __future__ import annotations

from typing import Any

import pytest

from motorcade.ga.algebra import CGA3, Multivector
from motorcade.ga.script import parse
from motorcade.ga.script.run import MAX_STEPS, MAX_TERMS, Budget
from motorcade.ga.script.syntax import Assignment, Expression


class Counted:
    """A number that counts the products of its kind."""

    products = 0

    def __init__(self, value: float) -> None:
        self.value = value

    def __mul__(self, other: Any) -> Counted:
        if isinstance(other, Multivector):
            return NotImplemented
        if isinstance(other, Counted):
            Counted.products += 1
        return Counted(self.value * number(other))

    def __add__(self, other: Any) -> Counted:
        if isinstance(other, Multivector):
            return NotImplemented
        return Counted(self.value + number(other))

    def __sub__(self, other: Any) -> Counted:
        if isinstance(other, Multivector):
            return NotImplemented
        return Counted(self.value - number(other))

    def __rsub__(self, other: Any) -> Counted:
        if isinstance(other, Multivector):
            return NotImplemented
        return Counted(number(other) - self.value)

    def __neg__(self) -> Counted:
        return Counted(-self.value)

    def __truediv__(self, other: Any) -> Counted:
        if isinstance(other, Multivector):
            return NotImplemented
        return Counted(self.value / number(other))

    def is_zero(self) -> bool:
        return self.value == 0.0

    __rmul__, __radd__ = __mul__, __add__


def number(value: Any) -> float:
    return value.value if isinstance(value, Counted) else float(value)


def counted(size: int, *, first: int = 0) -> Multivector:
    names = [CGA3.blade_name(mask) for mask in range(32)][first : first + size]
    return CGA3.multivector({name: Counted(k + 1.5) for k, name in enumerate(names)})


def node_of(expression: str) -> Expression:
    (statement,) = parse(f"?y = {expression};").statements
    assert isinstance(statement, Assignment)
    return statement.value


def done_at_most(expression: str, *operands: Multivector) -> int:
    """How often a step can be done within the terms."""
    budget, node, done = Budget(), node_of(expression), 0
    while not (message := budget.spend(node, list(operands))):
        done += 1
    assert message == f"expected products of at most {MAX_TERMS} terms in all"
    return done


def test_steps_are_counted_one_by_one() -> None:
    budget, node = Budget(), node_of("x")
    assert [budget.spend(node, []) for _ in range(MAX_STEPS)] == [""] * MAX_STEPS
    assert budget.spend(node, []) == f"expected at most {MAX_STEPS} steps"


@pytest.mark.parametrize("operator", ["*", "^", "."])
def test_products_cost_their_pairs_of_blades(operator: str) -> None:
    assert done_at_most(f"a {operator} b", counted(20), counted(25)) == MAX_TERMS // (500)
    assert done_at_most(f"a {operator} b", counted(25), counted(16)) == MAX_TERMS // (400)
    Counted.products = 0
    assert counted(20) * counted(25) is not None
    assert Counted.products == 500


def test_sums_cost_the_blades_that_they_read() -> None:
    assert done_at_most("a + b", counted(5), counted(20)) == MAX_TERMS // (25)
    assert done_at_most("a - b", counted(20), counted(12)) == MAX_TERMS // (32)
    assert done_at_most("-a", counted(10)) == MAX_TERMS // (10)
    assert done_at_most("~a", counted(16)) == MAX_TERMS // (16)


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (counted(9), counted(2, first=1)),
        (counted(2), counted(5, first=1)),
        (counted(32), counted(3, first=1)),
        (counted(4), counted(20)),
    ],
    ids=["blade", "mixed", "few", "many"],
)
def test_divisions_and_inverses_cost_no_less_than_they_multiply(
    left: Multivector, right: Multivector
) -> None:
    Counted.products = 0
    inverse = right.inverse()
    done = done_at_most("invert(a)", right)
    assert MAX_TERMS // (64 * Counted.products) < done <= MAX_TERMS // Counted.products
    assert left * inverse is not None
    done = done_at_most("a / b", left, right)
    assert MAX_TERMS // (64 * Counted.products) < done <= MAX_TERMS // Counted.products


def test_functions_cost_their_products() -> None:
    bivector = CGA3.multivector({"e1^e2": 0.3, "e1^e3": 0.1, "e2^e3": -0.2})
    assert done_at_most("abs(a)", counted(20)) == MAX_TERMS // 400
    for name in ("log", "sqrt", "versor"):
        assert done_at_most(f"{name}(a)", counted(20)) == MAX_TERMS // (12 * 400)
    assert done_at_most("exp(a)", bivector) == MAX_TERMS // (12 * 3 * 3)
    assert done_at_most("exp(a)", counted(7, first=3)) == MAX_TERMS // (40 * 7 * 32)
