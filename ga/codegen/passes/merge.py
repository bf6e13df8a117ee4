"""Zero proofs, and one node for all that are equal up to a factor.

Nodes are compared by their `fingerprints`, at many points where a sign was guessed, and what these
say must also hold for the `witness`. A node is replaced only by one that is defined wherever it is:
all divisions, roots and other partial functions on the way to that are on the way to it too. Of
equal nodes the one that needs the fewest others stays, on very long tapes the first.

The second proof of what fingerprints claim: real points, in float64 with bounds of the errors.

It knows what a finite field does not: which numbers are large, and where functions are defined. The
points have values of both signs, below and above 1, and some are positive throughout, so that most
functions are defined at some of them. A value is NaN where it is not a real number.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from motorcade.ga.codegen.passes import finite_field
from motorcade.ga.codegen.passes.fingerprints import (
    MANY_POINTS,
    Fingerprint,
    Fingerprints,
    fingerprints,
)
from motorcade.ga.codegen.passes.rebuild import copied
from motorcade.ga.codegen.tape import BOOLEANS, NUMPY_OPERATIONS, Node, Tape, TapeBuilder

_PARTIAL = frozenset({"div", "sqrt", "log", "asin", "acos", "tan"})
_LARGEST_FACTOR = 1 << 10
_LARGEST_CONSTANT = 1 << 16
# What each node needs takes a bit a pair of nodes: on longer tapes the first of equal ones stays.
_LONGEST_COMPARED = 20_000


def merged(tape: Tape) -> Tape:
    """The tape with what is zero or constant written so, and equal nodes computed once.

    Raises ValueError: a divisor is zero whatever the inputs are.
    """
    return _Merger(tape).run()


class _Merger:
    def __init__(self, tape: Tape) -> None:
        self._tape = tape
        self._prints = fingerprints(tape)
        self._witness = Witness(tape)
        # For each node the partial functions on the way to it, a bit each, equal ones the same.
        self._partial: list[int] = []
        # For each node the first of its class and its factor to that; None stands for 1.
        self._first: list[int | None] = []
        self._factor: list[Fraction] = []
        self._classes: dict[tuple[object, ...], list[int]] = {}

    def run(self) -> Tape:
        bits: dict[int, int] = {}
        for index, node in enumerate(self._tape.nodes):
            if node.op in _PARTIAL:
                bits[index] = 1 << len(bits)
            partial = bits.get(index, 0)
            for k in node.args:
                partial |= self._partial[k]
            self._partial.append(partial)
            first, factor = self._classified(index)
            if node.op == "div" and self._is_zero(node.args[1]):
                raise ValueError("expected divisors that are not zero for all values, got one")
            if node.op in _PARTIAL and first is not None and first != index:
                own = self._partial[first] & bits.get(first, 0)
                self._partial[index] = (partial & ~bits[index]) | own
            self._first.append(first)
            self._factor.append(factor)
        return self._rebuilt(self._shortest())

    def _classified(self, index: int) -> tuple[int | None, Fraction]:
        """The class of a node: that of an earlier one, or a new one of its own."""
        node, value = self._tape.nodes[index], self._prints.values[index]
        if node.op in ("const", "input"):
            self._classes.setdefault(_ratios(value), []).append(index)
            return index, Fraction(1)
        if node.op in BOOLEANS:
            known = self._classes.setdefault((node.op, value), [index])
            return known[0], Fraction(1)
        if all(part == finite_field.ZERO for part in value):
            if self._sure(index, Fraction(0), None):
                return None, Fraction(0)
            return index, Fraction(1)
        key = _ratios(value)
        if key == (finite_field.ONE,) * len(value):
            constant = finite_field.rational(value[0], _LARGEST_CONSTANT)
            if constant is not None and self._sure(index, constant, None):
                return None, constant
        known = self._classes.setdefault(key, [])
        for other in known:
            pivot = _pivot(value)
            quotient = finite_field.divide(value[pivot], self._prints.values[other][pivot])
            factor = finite_field.rational(quotient, _LARGEST_FACTOR)
            if factor is None or factor.denominator & (factor.denominator - 1):
                continue
            if not self._partial[other] & ~self._partial[index] and self._sure(
                index, factor, other
            ):
                return other, factor
        known.append(index)
        return index, Fraction(1)

    def _is_zero(self, index: int) -> bool:
        return self._first[index] is None and self._factor[index] == 0

    def _sure(self, index: int, factor: Fraction, other: int | None) -> bool:
        """Whether a node is so many times another one, 1 where that is None."""
        uncertain = self._prints.uncertain
        guessed = uncertain[index] or (other is not None and uncertain[other])
        if guessed and not self._agrees_everywhere(index, factor, other):
            return False
        return self._witness.holds(index, float(factor), other)

    def _agrees_everywhere(self, index: int, factor: Fraction, other: int | None) -> bool:
        values = self._many_prints.values
        scale = finite_field.fraction(factor)
        if other is None:
            return all(value == scale for value in values[index])
        return all(
            value == finite_field.multiply(scale, known)
            for value, known in zip(values[index], values[other], strict=True)
        )

    @cached_property
    def _many_prints(self) -> Fingerprints:
        return fingerprints(self._tape, MANY_POINTS)

    def _shortest(self) -> dict[int, int]:
        """For the first node of each class the one of its nodes that needs the fewest others."""
        if len(self._tape.nodes) > _LONGEST_COMPARED:
            return {first: first for first in self._first if first is not None}
        needs: list[int] = []
        for index, node in enumerate(self._tape.nodes):
            below = 1 << index
            for k in node.args:
                below |= needs[k]
            needs.append(below)
        best: dict[int, int] = {}
        for index, first in enumerate(self._first):
            if first is None:
                continue
            kept = best.setdefault(first, index)
            shorter = needs[index].bit_count() < needs[kept].bit_count()
            if shorter and not self._partial[index] & ~self._partial[first]:
                best[first] = index
        return best

    def _rebuilt(self, best: dict[int, int]) -> Tape:
        tape, builder = self._tape, TapeBuilder()
        place: dict[int, int] = {}
        waiting = [k for row in reversed(tape.results) for k in reversed(row)]
        while waiting:
            index = waiting[-1]
            first = self._first[index]
            if first is None:
                place[index] = builder.constant(float(self._factor[index]))
            if index in place:
                waiting.pop()
                continue
            assert first is not None
            chosen = best[first]
            needed = tape.nodes[chosen].args if chosen == index else (chosen,)
            missing = [k for k in needed if k not in place]
            if missing:
                waiting.extend(reversed(missing))
            elif chosen == index:
                place[index] = copied(tape, index, tuple(place[k] for k in needed), builder)
            else:
                factor = self._factor[index] / self._factor[chosen]
                number = builder.constant(float(factor))
                boolean = tape.nodes[index].op in BOOLEANS
                place[index] = place[chosen]
                if not boolean:
                    place[index] = builder.operation("mul", number, place[chosen])
        results = [[place[k] for k in row] for row in tape.results]
        return builder.finished(tape.inputs, tape.outputs, results)


def _pivot(value: Fingerprint) -> int:
    """The first point at which the value is not zero, the first of all where there is none.

    A guessed sign makes ``sqrt(x²) - x`` zero at every other point.
    """
    return next((k for k, part in enumerate(value) if part != finite_field.ZERO), 0)


def _ratios(value: Fingerprint) -> tuple[object, ...]:
    """What a fingerprint shares with its multiples: its ratios to its first value but zero."""
    pivot = _pivot(value)
    if value[pivot] == finite_field.ZERO:
        return (finite_field.ZERO,) * len(value)
    below = finite_field.inverse(value[pivot])
    return tuple([finite_field.multiply(part, below) for part in value])


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
    samples = {}
    for operand in tape.inputs:
        for component in range(operand.width):
            row = random.uniform(0.1, 1.0, POINTS)
            row[1::2] = row[1::2] ** -1.5
            row[POINTS // 2 :] *= random.choice([-1.0, 1.0], POINTS // 2)
            samples[operand.name, component] = row
    return samples


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
