"""The second proof of what fingerprints claim: real points, in float64 with bounds of the errors.

It knows what a finite field does not: which numbers are large, and where functions are defined. The
points have values of both signs, below and above 1, and some are positive throughout, so that most
functions are defined at some of them. A value is NaN where it is not a real number.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from motorcade.ga.codegen.runtime.interpret import NUMPY_OPERATIONS
from motorcade.ga.codegen.tape import Node, Tape

POINTS = 16
_SEED = 20170215
_EPSILON = float(np.finfo(np.float64).eps)
_Row = npt.NDArray[np.float64]
# Factors by which functions pass on the errors of their argument.
_SLOPES: dict[str, Callable[[_Row, _Row], _Row]] = {
    "sqrt": lambda x, y: 0.5 / y,
    "exp": lambda x, y: y,
    "log": lambda x, y: 1.0 / np.abs(x),
    "sin": lambda x, y: np.ones_like(x),
    "cos": lambda x, y: np.ones_like(x),
    "tan": lambda x, y: 1.0 + y * y,
    "asin": lambda x, y: 1.0 / np.sqrt(1.0 - x * x),
    "acos": lambda x, y: 1.0 / np.sqrt(1.0 - x * x),
    "atan": lambda x, y: 1.0 / (1.0 + x * x),
}
_LEAST_POINTS = 3
_ROUNDINGS = 64.0


def sample_inputs(tape: Tape) -> dict[tuple[str, int], _Row]:
    """A row of `POINTS` values for each component of each input; the same for the same tape."""
    random = np.random.default_rng(_SEED)
    made = {}
    for operand in tape.inputs:
        for component in range(operand.width):
            row = random.uniform(0.1, 1.0, POINTS)
            row[1::2] = row[1::2] ** -1.5
            row[POINTS // 2 :] *= random.choice([-1.0, 1.0], POINTS // 2)
            made[operand.name, component] = row
    return made


def sampled(tape: Tape) -> tuple[list[_Row], list[_Row]]:
    """Values of all nodes at all points, and bounds of what rounding did to them."""
    inputs = sample_inputs(tape)
    values: list[_Row] = []
    errors: list[_Row] = []
    with np.errstate(all="ignore"):
        for node in tape.nodes:
            if node.op == "input":
                value = inputs[node.source]
                error = np.zeros(POINTS)
            elif node.op == "const":
                value, error = np.full(POINTS, node.value), np.zeros(POINTS)
            else:
                args = [values[k] for k in node.args]
                value = np.asarray(NUMPY_OPERATIONS[node.op](*args), dtype=np.float64)
                passed = _passed_on(node, args, [errors[k] for k in node.args], value)
                error = passed + _EPSILON * np.abs(value)
            values.append(value)
            errors.append(error)
    return values, errors


def _passed_on(node: Node, args: list[_Row], errors: list[_Row], value: _Row) -> _Row:
    """What the errors of the arguments may do to the value, to first order."""
    if node.op in ("add", "sub"):
        return errors[0] + errors[1]
    if node.op == "mul":
        return np.abs(args[0]) * errors[1] + np.abs(args[1]) * errors[0]
    if node.op == "div":
        return (errors[0] + np.abs(value) * errors[1]) / np.abs(args[1])
    if node.op in _SLOPES:
        return errors[0] * _SLOPES[node.op](args[0], value)
    if node.op == "atan2":
        y, x = args
        return (np.abs(x) * errors[0] + np.abs(y) * errors[1]) / (x * x + y * y)
    if node.op == "select":
        return np.where(args[0] != 0.0, errors[1], errors[2])
    return np.asarray(sum(errors[1:], errors[0]))


class Witness:
    """Checks claims about the nodes of one tape; works only where it is asked."""

    def __init__(self, tape: Tape) -> None:
        self._tape = tape

    @cached_property
    def _sampled(self) -> tuple[list[Any], list[Any], list[Any]]:
        values, errors = sampled(self._tape)
        return values, errors, [np.isfinite(value) for value in values]

    def holds(self, node: int, factor: float, other: int | None) -> bool:
        """Whether ``node = factor · other`` to rounding; `other` is 1 where it is None.

        It must hold at every point at which both are real numbers, and there must be some.
        """
        values, errors, defined = self._sampled
        claimed, bound, known = 1.0, 0.0, True
        if other is not None:
            claimed, bound, known = values[other], errors[other], defined[other]
        both = defined[node] & known
        if np.count_nonzero(both) < _LEAST_POINTS:
            return False
        with np.errstate(invalid="ignore", over="ignore"):
            off = np.abs(values[node] - factor * claimed)
            within = off <= _ROUNDINGS * (errors[node] + abs(factor) * bound)
        return bool(np.all(within | ~both))
