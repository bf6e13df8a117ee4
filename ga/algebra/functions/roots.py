"""Square roots, unit size, and the versor near an element.

An element with ``x ~x = s + F``, ``F² = f`` a scalar, is a versor times what commutes with it:
``[((s + ν) - F) / (ν √(2 (s + ν)))] x`` with ``ν = √(s² - f)`` takes that away. It is so for all
even elements in at most five dimensions. ``(1 + R) ~(1 + R)`` is of this form for a versor, and
``√R`` is the versor of ``1 + R``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga.algebra.blade_sum import BladeSum
from motorcade.ga.algebra.functions.commuting import (
    Square,
    any_holds,
    numeric,
    plus,
    without_scalar,
)
from motorcade.ga.algebra.functions.elementary import apply, where
from motorcade.ga.algebra.functions.logarithm import (
    EvenParts,
    by_structure,
    check_versor,
    without_rounding,
)
from motorcade.ga.algebra.scalars import magnitude


def normalize(x: BladeSum) -> BladeSum:
    """``x / √|⟨x ~x⟩₀|``.

    Raises:
        ValueError: a size of zero to rounding.
    """
    with np.errstate(all="ignore"):
        size = apply("sqrt", magnitude(x.norm_squared()))
        largest: Any = sum(np.abs(value) for value in x.values) if numeric(x) else 0.0
        if numeric(x) and any_holds(size <= 1e-12 * largest):
            raise ValueError("normalize: expected a size, got x ~x with a scalar part of zero")
        return x._divided(size)


def versor(x: BladeSum) -> BladeSum:
    """The unit versor that `x` is a disturbed multiple of, as after a linear blend.

    Raises:
        ValueError: ``x ~x`` not of the form ``s + F`` above, or none nearby: ``s² <= F²``, or
            ``s + ν <= 0``.
    """
    with np.errstate(all="ignore"):
        whole = x.reverse_product()
        s, rest = whole.scalar_part(), without_scalar(whole)
        above = rest.square()
        if any(above.masks):
            kept = without_rounding(x)
            if kept.masks != x.masks:
                return versor(kept)
            raise ValueError(
                "versor: expected an even element in at most five dimensions, "
                f"got blades {' '.join(x.blades[:6])}"
            )
        return _corrected(x, s, rest, above.scalar_part() if above.masks else None)


def _corrected(x: BladeSum, s: Any, rest: BladeSum, f: Any) -> BladeSum:
    """The versor of `x` with ``x ~x = s + rest``, `f` the square of the rest; None: zero."""
    inside = s * s if f is None else s * s - f
    if any_holds(inside <= 0):
        raise ValueError("versor: expected an element with a versor nearby, got none")
    size = magnitude(s) if f is None else apply("sqrt", inside)
    # s + size, where nothing cancels for negative s.
    below = -(0.0 if f is None else f) / where(s < 0, size - s, 1.0)
    total = where(s < 0, below, s + size)
    if any_holds(total <= 0):
        raise ValueError("versor: expected an element with a versor nearby, got none")
    divisor = size * apply("sqrt", 2 * total)
    left = plus(total, -rest)._divided(divisor)
    return left._product("geometric", x, _kept(x))


def _kept(x: BladeSum) -> frozenset[int] | None:
    """The grades of the versor of an even or of an odd element."""
    parities = {grade % 2 for grade in x.grades}
    grades = range(x.algebra.dimension + 1)
    return frozenset(g for g in grades if g % 2 in parities) if len(parities) == 1 else None


def sqrt(x: BladeSum) -> BladeSum:
    """The ``y`` with ``y y = x``, the angles of its planes at most π/2; coefficients over a batch.

    Raises:
        ValueError: no real root (a negative scalar, a norm below zero), a half turn in no plane,
            neither simple nor an even versor in at most five dimensions.
    """
    with np.errstate(all="ignore"):
        return by_structure("sqrt", x, _root, _root_of_simple, _root_of_versor)


def _root(value: Any) -> Any:
    if any_holds(value < 0):
        raise ValueError("sqrt: has no finite real value here")
    return apply("sqrt", value)


def _root_of_simple(x: BladeSum, y: BladeSum, square: Square) -> BladeSum:
    """``(√n + x) / √(2 (√n + c))`` with ``n = c² - s``, where nothing cancels for negative `c`."""
    c, s = x.scalar_part(), square.scalar
    size = _root(c * c - s)
    scalar = where(c < 0, -s / where(c < 0, size - c, 1.0), size + c)
    if any_holds(scalar <= 0):
        raise ValueError("sqrt: expected a real root, got a half turn in no plane")
    root = apply("sqrt", 2 * scalar)
    return plus(scalar / root, y._divided(root))


def _root_of_versor(x: BladeSum, parts: EvenParts) -> BladeSum:
    """The versor of ``1 + x``, whose reverse product is ``2 (1 + c) + 2 H`` for a unit `x`."""
    n = parts.norm_squared
    size = _root(n)
    if numeric(x):
        if any_holds(size <= 0):
            raise ValueError("sqrt: expected a versor, got a norm of zero")
        check_versor(x, "sqrt")
    c, f = parts.scalar / size, parts.volume_squared
    h = 0.0 if f is None else f / n
    # 1 + c from the squared sines, where 1 and c cancel.
    below = parts.plane_squared / n * (c - 1) - 2 * c * h
    one_more = where(c < 0, below / where(c < 0, (c - 1) * (c - 1) - h, 1.0), 1 + c)
    beside = plus(one_more, without_scalar(x)._divided(size))
    volume = parts.volume._divided(size)._scaled(2.0)
    made = _corrected(beside, 2 * one_more, volume, None if f is None else 4 * h)
    return made._scaled(apply("sqrt", size))
