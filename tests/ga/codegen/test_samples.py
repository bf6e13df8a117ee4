"""What is known of a tape's values: at sample points, with bounds of errors, and by their signs."""

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from motorcade.ga.codegen.passes.fingerprints import nonnegative_nodes
from motorcade.ga.codegen.passes.merge import POINTS, sampled

MakeNodes = Callable[..., Any]
EPSILON = float(np.finfo(np.float64).eps)
FUNCTIONS = ["sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan"]


@pytest.mark.parametrize("function", FUNCTIONS)
def test_errors_pass_by_the_derivative(function: str, nodes: MakeNodes) -> None:
    """At least so much as mpmath's derivative lets through, and little more than that."""
    op = nodes("x")
    inner = op("mul", 0, op.constant(0.1))
    found = op(function, inner)
    values, errors = sampled(op.tape())
    there = np.isfinite(values[found])
    assert np.count_nonzero(there) >= POINTS // 4
    for u, before, value, error in zip(
        values[inner][there],
        errors[inner][there],
        values[found][there],
        errors[found][there],
        strict=True,
    ):
        slope = abs(float(mpmath.diff(getattr(mpmath, function), mpmath.mpf(float(u)))))
        least = slope * before + EPSILON * abs(value)
        most = least if function not in ("sin", "cos") else before + EPSILON * abs(value)
        assert least * (1 - 1e-9) <= error <= most * (1 + 1e-9)
        assert abs(float(getattr(mpmath, function)(mpmath.mpf(float(u)))) - value) <= 2 * error


def test_sums_products_and_quotients_bound_their_errors(nodes: MakeNodes) -> None:
    op = nodes("x", "y")
    a, b = op("mul", 0, op.constant(0.1)), op("mul", 1, op.constant(0.7))
    made = [op(name, a, b) for name in ("add", "sub", "mul", "div", "atan2")]
    chosen = op("select", op("lt", a, b), a, b)
    values, errors = sampled(op.tape())
    left, right = values[a], values[b]
    rounded = abs(left) + abs(right)
    bounds = [
        rounded + abs(left + right),
        rounded + abs(left - right),
        3 * abs(left * right),
        3 * abs(left / right),
        2 * abs(left * right) / (left**2 + right**2) + abs(np.arctan2(left, right)),
    ]
    for k, bound in zip(made, bounds, strict=True):
        np.testing.assert_allclose(errors[k], EPSILON * bound, rtol=1e-9)
    np.testing.assert_allclose(errors[chosen], 2 * EPSILON * abs(np.minimum(left, right)))


def test_samples_have_both_signs_and_sizes_and_some_are_positive_throughout(
    nodes: MakeNodes,
) -> None:
    op = nodes("x", "y")
    op("mul", 0, 1)
    values, _ = sampled(op.tape())
    for row in values[:2]:
        assert np.all(row[: POINTS // 2] > 0.0)
        assert np.any(row < 0.0)
        assert np.any(np.abs(row) > 1.0)
        assert np.any(np.abs(row) < 1.0)


def test_what_is_never_negative_is_known(nodes: MakeNodes) -> None:
    op, x, y = nodes("x", "y"), 0, 1
    zero, two, minus = (op.constant(value) for value in (0.0, 2.0, -3.0))
    square = op("mul", x, x)
    condition = op("lt", x, y)
    never_negative = [
        zero,
        two,
        square,
        op("mul", op("mul", two, x), x),
        op("mul", y, op("mul", y, two)),
        op("add", square, two),
        op("div", square, two),
        op("max", x, zero),
        op("max", two, y),
        op("min", square, two),
        op("select", condition, square, two),
        op("abs", x),
        op("sqrt", square),
        op("exp", x),
        op("acos", x),
        condition,
        op("floor", square),
        op("ceil", square),
        op("mul", two, op("abs", y)),
    ]
    unknown = [
        x,
        minus,
        op("mul", x, y),
        op("mul", op("mul", minus, x), x),
        op("sub", square, two),
        op("min", square, x),
        op("max", minus, x),
        op("select", condition, x, two),
        op("select", condition, two, x),
        op("sin", x),
        op("neg", square),
        op("add", square, minus),
        op("mul", op("mul", two, x), y),
        op("log", two),
    ]
    known = nonnegative_nodes(op.tape())
    assert [op.nodes[k] for k in never_negative if not known[k]] == []
    assert [op.nodes[k] for k in unknown if known[k]] == []
