"""Polynomials that stand for smooth functions on an interval, as short as a precision allows."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

_MOST_TERMS = 40


@cache
def fitted(
    function: Callable[[Any], Any], first: float, last: float, error: float
) -> tuple[float, ...]:
    """Coefficients, lowest power first, of a polynomial within `error` on ``[first, last]``.

    A Chebyshev fit with the fewest terms, worked out at 50 digits. `function` takes and returns
    mpmath numbers and is not asked for at the ends of the interval.

    Raises:
        ValueError: 40 terms do not suffice: the function is not smooth enough there.
    """
    import mpmath as mp

    with mp.workdps(50):
        for terms in range(3, _MOST_TERMS + 1):
            made, off = mp.chebyfit(function, [first, last], terms, error=True)
            if off < error:
                return tuple(float(value) for value in reversed(made))
    raise ValueError(
        f"fitted: expected a function within {error:g} of a polynomial of {_MOST_TERMS} terms "
        f"on [{first:g}, {last:g}], got an error of {float(off):.3g}"
    )


def horner(coefficients: tuple[float, ...], x: Any) -> Any:
    """The polynomial at `x`, by Horner's rule."""
    value: Any = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        value = value * x + coefficient
    return value
