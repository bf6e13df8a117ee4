"""The second proof of what fingerprints claim: real points, in float64 with bounds of the errors.

It knows what a finite field does not: which numbers are large, and where functions are defined.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from motorcade.ga.codegen.passes.equality.samples import sampled
from motorcade.ga.codegen.tape import Tape

__all__ = ["Witness"]

_LEAST_POINTS = 3
_ROUNDINGS = 64.0


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
