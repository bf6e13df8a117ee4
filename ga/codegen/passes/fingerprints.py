"""Exact values of all nodes of a tape at random points of a finite field.

Inputs take random values in GF(p), p = 2^61 - 150993, and all that is rational is computed exactly.
Two rational functions that differ, ``a/b`` and ``c/d`` with ``ad - cb`` of degree D at most, agree
at a random point with a probability of at most D / (p - 1) (Schwartz 1980, Zippel 1979), and up to
a factor at all three points with at most the square of 4 D / p. Nodes whose degree may exceed 2^16
count as unknown, so that one comparison errs with less than 2^-83, and all pairs of a tape of
100,000 nodes with less than 2^-50.

Operations that are not rational become unknowns that are told apart by their operation and the
values of their arguments, but for what is known of them: sin and cos of one argument are a random
rational point of the unit circle, tan is their quotient, exp(-x) is 1/exp(x), sin, tan, asin and
atan are odd, cos and abs even, a square root is a root in GF(p²). The last two leave a sign open,
which is that of a fair coin that multiplies as signs do (`finite_field.magnitude`):
``sqrt(x²)`` and ``|x|`` have the value of x or of -x. Nodes that depend on such a choice are
`uncertain`: their agreement at few points is a guess. A claim that is wrong for half of the signs
passes at all of `MANY_POINTS` with 2^-48. Where a value is never negative there is no choice.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from motorcade.ga.codegen.passes import finite_field
from motorcade.ga.codegen.passes.finite_field import Element
from motorcade.ga.codegen.tape import Node, Tape

_ALWAYS = frozenset({"abs", "sqrt", "exp", "acos", "lt", "le", "eq", "ne", "and", "or", "not"})
POINTS = 3
MANY_POINTS = 48
_SEED = 20170214
_HIGHEST_DEGREE = 1 << 16
_TRIES = 8
Fingerprint = tuple[Element, ...]


def nonnegative_nodes(tape: Tape) -> list[bool]:
    """For each node whether its value is at least 0 wherever it is a number, rounding included."""
    known: list[bool] = []
    for node in tape.nodes:
        known.append(_nonnegative(node, [known[k] for k in node.args], tape))
    return known


def _nonnegative(node: Node, args: list[bool], tape: Tape) -> bool:
    if node.op == "const":
        return node.value >= 0.0
    if node.op == "mul":
        return all(args) or _is_square(node, tape)
    if node.op in ("add", "div", "min", "floor", "ceil", "keep"):
        return all(args)
    if node.op == "max":
        return any(args)
    if node.op == "select":
        return all(args[1:])
    return node.op in _ALWAYS


def _is_square(node: Node, tape: Tape) -> bool:
    """``x x``, and ``(c x) x`` for a number c that is not negative."""
    left, right = node.args
    if left == right:
        return True
    for product, factor in ((left, right), (right, left)):
        inner = tape.nodes[product]
        if inner.op == "mul" and factor in inner.args:
            rest = inner.args[0] if inner.args[1] == factor else inner.args[1]
            if tape.nodes[rest].op == "const" and tape.nodes[rest].value >= 0.0:
                return True
    return False


@dataclass(frozen=True)
class Fingerprints:
    """For each node its values at the points, and whether a sign was guessed on the way to it."""

    values: tuple[Fingerprint, ...]
    uncertain: tuple[bool, ...]


def fingerprints(tape: Tape, points: int = POINTS) -> Fingerprints:
    """The values of all nodes at this many points; the same for the same tape."""
    nonnegative = nonnegative_nodes(tape)
    unbounded = _of_high_degree(tape)
    random = np.random.default_rng(_SEED)
    columns = []
    for _ in range(points):
        for left in reversed(range(_TRIES)):
            point = _Point(tape, nonnegative, unbounded, random)
            if point.computed(strict=left > 0):
                break
        columns.append(point.values)
    uncertain: list[bool] = []
    for node in tape.nodes:
        guessed = node.op == "sqrt" or (node.op == "abs" and not nonnegative[node.args[0]])
        uncertain.append(guessed or any(uncertain[k] for k in node.args))
    return Fingerprints(tuple(zip(*columns, strict=True)), tuple(uncertain))


def _of_high_degree(tape: Tape) -> list[bool]:
    """Which nodes count as unknown because their degree may be too high."""
    degrees: list[tuple[int, int]] = []
    high_degree: list[bool] = []
    for node in tape.nodes:
        above, below = _degrees(node, [degrees[k] for k in node.args])
        high_degree.append(max(above, below) > _HIGHEST_DEGREE)
        degrees.append((1, 0) if high_degree[-1] else (above, below))
    return high_degree


def _degrees(node: Node, args: list[tuple[int, int]]) -> tuple[int, int]:
    """Bounds of the degrees of numerator and denominator; a root's norm has twice its degree."""
    if node.op == "const":
        return 0, 0
    if node.op in ("add", "sub"):
        (a, b), (c, d) = args
        return max(a + d, c + b), b + d
    if node.op in ("mul", "div"):
        (a, b), (c, d) = args
        return (a + c, b + d) if node.op == "mul" else (a + d, b + c)
    if node.op in ("neg", "abs"):
        return args[0]
    if node.op == "sqrt":
        return 2 * args[0][0], 2 * args[0][1]
    # Random points of the unit circle have degree 2, all other unknowns 1.
    return (2, 2) if node.op in ("sin", "cos", "tan") else (1, 0)


class _Point:
    """One random point; computing fails where a root is asked for that GF(p²) does not have."""

    def __init__(
        self,
        tape: Tape,
        nonnegative: list[bool],
        unbounded: list[bool],
        random: np.random.Generator,
    ) -> None:
        self.values: list[Element] = []
        self._tape = tape
        self._nonnegative = nonnegative
        self._unbounded = unbounded
        self._random = random
        self._unknowns: dict[tuple[object, ...], Element] = {}
        self._strict = True
        self._rational: dict[str, Callable[[Element, Element], Element]] = {
            "add": finite_field.add,
            "sub": finite_field.subtract,
            "mul": finite_field.multiply,
        }

    def computed(self, *, strict: bool) -> bool:
        self._strict = strict
        values = self.values
        for index, node in enumerate(self._tape.nodes):
            rational = self._rational.get(node.op)
            if self._unbounded[index]:
                value: Element | None = self._unknown(node.op, *(values[k] for k in node.args))
            elif rational is not None:
                left, right = node.args
                value = rational(values[left], values[right])
            else:
                value = self._other(node)
            if value is None:
                return False
            values.append(value)
        return True

    def _unknown(self, *key: object) -> Element:
        unknown = self._unknowns.get(key)
        if unknown is None:
            unknown = self._unknowns[key] = (int(self._random.integers(1, finite_field.PRIME)), 0)
        return unknown

    def _other(self, node: Node) -> Element | None:
        args = [self.values[k] for k in node.args]
        if node.op == "const":
            return finite_field.constant(node.value)
        if node.op == "input":
            return self._unknown("input", node.source)
        if node.op == "neg":
            return finite_field.negative(args[0])
        if node.op == "div":
            return self._quotient(args[0], args[1])
        if node.op == "sqrt":
            return self._root(args[0])
        if node.op == "abs":
            return args[0] if self._nonnegative[node.args[0]] else finite_field.magnitude(args[0])
        if node.op in ("sin", "cos", "tan", "asin", "atan", "exp"):
            return self._symmetric(node.op, args[0])
        if node.op == "log" and args[0] == finite_field.ONE:
            return finite_field.ZERO
        if node.op == "ceil":
            return finite_field.negative(self._unknown("floor", finite_field.negative(args[0])))
        if node.op in ("min", "max", "and", "or", "eq", "ne"):
            args.sort()
        return self._unknown(node.op, *args)

    def _quotient(self, above: Element, below: Element) -> Element:
        if below == finite_field.ZERO:
            return self._unknown("div", above, below)
        return finite_field.divide(above, below)

    def _root(self, square: Element) -> Element | None:
        value = finite_field.root(square)
        return self._unknown("sqrt", square) if value is None and not self._strict else value

    def _symmetric(self, op: str, x: Element) -> Element:
        """A function of x by its value at one of x and -x."""
        if x == finite_field.ZERO:
            return finite_field.ONE if op in ("cos", "exp") else finite_field.ZERO
        least = finite_field.canonical(x)
        if op in ("asin", "atan"):
            value = self._unknown(op, least)
            return value if x == least else finite_field.negative(value)
        if op == "exp":
            value = self._unknown(op, least)
            return value if x == least else finite_field.inverse(value)
        half = self._unknown("half-angle", least)
        square = finite_field.multiply(half, half)
        cosine, size = (
            finite_field.subtract(finite_field.ONE, square),
            finite_field.add(finite_field.ONE, square),
        )
        sine = (
            finite_field.add(half, half)
            if x == least
            else finite_field.negative(finite_field.add(half, half))
        )
        if op == "tan":
            return finite_field.divide(sine, cosine)
        return finite_field.divide(cosine if op == "cos" else sine, size)
