"""The second proof of what fingerprints claim: real points, in float64 and at 60 digits.

Fingerprints know neither the signs of roots nor where functions are defined. A claim ``u = c v``
holds here if it does at every point at which both are real numbers, if there are enough of these,
and if v is defined wherever u is.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from motorcade.ga.codegen.passes.samples import POINTS, sample_inputs, sampled
from motorcade.ga.codegen.tape import Node, Tape

__all__ = ["Witness"]

_LEAST_POINTS = 3
_ROUNDINGS = 64.0
_DIGITS = 60
# So many points of both halves, of positive values and of both signs, are looked at so closely.
_PRECISE = 3
_TOLERANCE = 1e-40
_SAME = {
    "sqrt": "sqrt", "exp": "exp", "log": "log", "sin": "sin", "cos": "cos", "tan": "tan",
    "asin": "asin", "acos": "acos", "atan": "atan", "atan2": "atan2", "floor": "floor",
    "ceil": "ceil",
}  # fmt: skip


class Witness:
    """Checks claims about the nodes of one tape; works only where it is asked."""

    def __init__(self, tape: Tape) -> None:
        self._tape = tape
        self._precise: dict[int, list[tuple[Any, Any] | None]] = {}

    @cached_property
    def _sampled(self) -> tuple[list[Any], list[Any], list[Any]]:
        values, errors = sampled(self._tape)
        return values, errors, [np.isfinite(value) for value in values]

    def holds(self, node: int, factor: float, other: int | None, *, precisely: bool) -> bool:
        """Whether ``node = factor · other``; `other` is 1 where it is None.

        With `precisely` also at 60 digits, in which no cancellation hides a wrong sign.
        """
        values, errors, defined = self._sampled
        claimed, bound, known = 1.0, 0.0, True
        if other is not None:
            claimed, bound, known = values[other], errors[other], defined[other]
        both = defined[node] & known
        if np.count_nonzero(both) < _LEAST_POINTS or np.any(defined[node] & ~both):
            return False
        with np.errstate(invalid="ignore", over="ignore"):
            off = np.abs(values[node] - factor * claimed)
            within = off <= _ROUNDINGS * (errors[node] + abs(factor) * bound)
        if not np.all(within | ~both):
            return False
        return not precisely or self._holds_precisely(node, factor, other)

    def as_defined(self, node: int, other: int) -> bool:
        """Whether a node is a real number wherever the other is."""
        defined = self._sampled[2]
        return not np.any(defined[other] & ~defined[node])

    def _holds_precisely(self, node: int, factor: float, other: int | None) -> bool:
        import mpmath as mp

        with mp.workdps(_DIGITS):
            one = [(mp.mpf(1), mp.mpf(1))] * 2 * _PRECISE
            pairs = zip(
                self._evaluated(node), one if other is None else self._evaluated(other), strict=True
            )
            known = [(x, y) for x, y in pairs if x is not None and y is not None]
            return len(known) >= _LEAST_POINTS and all(
                abs(x[0] - factor * y[0]) <= _TOLERANCE * (x[1] + abs(factor) * y[1])
                for x, y in known
            )

    def _evaluated(self, index: int) -> list[tuple[Any, Any] | None]:
        """The values of a node and the largest on the way to each, None where it is not real."""
        waiting = [index]
        while waiting:
            last = waiting[-1]
            node = self._tape.nodes[last]
            missing = [k for k in node.args if k not in self._precise]
            if missing:
                waiting.extend(missing)
                continue
            waiting.pop()
            if last not in self._precise:
                self._precise[last] = self._row(node)
        return self._precise[index]

    def _row(self, node: Node) -> list[tuple[Any, Any] | None]:
        import mpmath as mp

        if node.op == "const":
            number = (mp.mpf(node.value), mp.mpf(abs(node.value)))
            return [number for _ in range(2 * _PRECISE)]
        if node.op == "input":
            given = self._inputs[node.source]
            row: list[tuple[Any, Any] | None] = []
            for point in self._points:
                value = float(given[point])
                row.append((mp.mpf(value), mp.mpf(abs(value))))
            return row
        columns = zip(*(self._precise[k] for k in node.args), strict=True)
        return [_value(node.op, column) for column in columns]

    @cached_property
    def _points(self) -> list[int]:
        """The points of both halves at which most nodes are real numbers."""
        counts = np.sum(self._sampled[2], axis=0)
        order = sorted(range(POINTS), key=lambda point: -counts[point])
        positive = [point for point in order if point < POINTS // 2]
        return positive[:_PRECISE] + [p for p in order if p >= POINTS // 2][:_PRECISE]

    @cached_property
    def _inputs(self) -> dict[tuple[str, int], Any]:
        return sample_inputs(self._tape)


def _value(op: str, column: tuple[tuple[Any, Any] | None, ...]) -> tuple[Any, Any] | None:
    import mpmath as mp

    if op in ("select", "keep"):
        if column[0] is None:
            return None
        chosen = (*column, (mp.mpf(0), mp.mpf(0)))[1 if column[0][0] else 2]
        return chosen if op == "select" or column[0][0] else (mp.mpf(0), mp.mpf(0))
    if any(pair is None for pair in column):
        return None
    args = [pair[0] for pair in column if pair is not None]
    try:
        value = _applied(op, args)
    except (ArithmeticError, ValueError):
        return None
    if isinstance(value, mp.mpc) or not mp.isfinite(value):
        return None
    value = mp.mpf(value)
    return value, max([abs(value), *(pair[1] for pair in column if pair is not None)])


def _applied(op: str, args: list[Any]) -> Any:
    import mpmath as mp

    if op in _SAME:
        return getattr(mp, _SAME[op])(*args)
    x, y = (*args, None)[:2]
    if op in ("and", "or", "not"):
        truths = [bool(value) for value in args]
        return not truths[0] if op == "not" else all(truths) if op == "and" else any(truths)
    return {
        "add": lambda: x + y, "sub": lambda: x - y, "mul": lambda: x * y, "div": lambda: x / y,
        "neg": lambda: -x, "abs": lambda: abs(x), "min": lambda: min(x, y),
        "max": lambda: max(x, y), "lt": lambda: x < y, "le": lambda: x <= y,
        "eq": lambda: x == y, "ne": lambda: x != y,
    }[op]()  # fmt: skip
