"""Real points as witnesses: which claims about a tape hold there, to the rounding of its nodes."""

from collections.abc import Callable
from typing import Any

import pytest

from motorcade.ga.codegen.passes.merge import Witness
from motorcade.ga.codegen.passes.optimize import PASSES, optimized

MakeNodes = Callable[..., Any]
X, Y = 0, 1


def test_claims_hold_to_the_factor_and_at_every_point(nodes: MakeNodes) -> None:
    op = nodes("x", "y")
    product, size = op("mul", X, Y), op("abs", X)
    triple = op("mul", op.constant(3.0), op("mul", Y, X))
    quotient = op("div", X, X)
    witness = Witness(op.tape())
    assert witness.holds(triple, 3.0, product)
    assert not witness.holds(triple, 3.0 + 1e-12, product)
    assert not witness.holds(triple, -3.0, product)
    assert witness.holds(quotient, 1.0, None)
    assert not witness.holds(quotient, -1.0, None)
    assert not witness.holds(size, 1.0, X), "it holds where x is positive"


def test_points_count_where_both_are_real_numbers(nodes: MakeNodes) -> None:
    op = nodes("x", "y")
    whole = op("log", op("mul", X, X))
    half = op("log", X)
    nowhere = op("log", op("neg", op("exp", X)))
    witness = Witness(op.tape())
    assert witness.holds(whole, 2.0, half)
    assert witness.holds(half, 0.5, whole)
    assert not witness.holds(half, 0.6, whole)
    assert not witness.holds(nowhere, 1.0, nowhere)


def test_the_rounding_of_both_sides_counts(nodes: MakeNodes) -> None:
    op = nodes("x", "y")
    far = op.constant(1e8)
    lossy = op("sub", op("add", X, far), far)
    witness = Witness(op.tape())
    assert witness.holds(lossy, 1.0, X)
    assert witness.holds(X, 1.0, lossy)
    assert not witness.holds(X, 1.0 + 1e-3, lossy)


def test_the_longest_tape_that_is_searched_is_searched(
    nodes: MakeNodes, monkeypatch: pytest.MonkeyPatch
) -> None:
    op = nodes("x", "y")
    total = op("add", op("mul", X, Y), op("mul", X, X))
    op("sin", total)
    tape = op.tape()
    before = tape
    for _, apply in PASSES[:4]:
        before = apply(before)
    for longest, skipped in ((len(before.nodes), False), (len(before.nodes) - 1, True)):
        monkeypatch.setattr("motorcade.ga.codegen.passes.optimize.LONGEST_SEARCHED", longest)
        _, passes = optimized(tape)
        assert passes[4].name == "collect like terms"
        assert passes[4].skipped is skipped
