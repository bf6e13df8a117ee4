"""Functions of dual numbers ``c + d J``, ``J = e123∞``, ``J² = 0``, without special cases.

A smooth function goes over to dual numbers by its derivative, ``f(c + d J) = f(c) + d f'(c) J``.
With ``θ`` the angle of a motor's rotor (half of what it turns by) and ``w = cos θ``, these are
smooth in ``x = 1 - w`` for ``θ ≤ π/2`` and free of roots, quotients and special cases there:

    ``θ / sin θ``  angle_over_sine,      its derivative by x        (at x = 1 it is π/2)
    ``θ²``         ``(θ / sin θ)² x (2 - x)``

and ``sin √y / √y`` and its derivative are smooth in ``y`` everywhere.

Functions are written as polynomials on an interval, as short as a precision allows.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import pi
from typing import Any

import casadi as ca
import mpmath as mp

from motorcade.ga.codegen.precision import Precision

_MOST_TERMS = 40
Dual = tuple[Any, Any]
# A fit may be off by this part of the spacing of numbers, so that rounding decides.
_SHARE = 1 / 16
_QUARTER_TURN_SQUARED = (pi / 2) ** 2 + 1e-3
# `1 - cos θ` up to which code that may branch has shorter polynomials: turns by 37°.
_SMALL = 0.05


@cache
def fitted(
    function: Callable[[Any], Any], first: float, last: float, error: float
) -> tuple[float, ...]:
    """Coefficients, lowest power first, of a polynomial within `error` on ``[first, last]``.

    A Chebyshev fit with the fewest terms, worked out at 50 digits. `function` takes and returns
    mpmath numbers and is not asked for at the ends of the interval.

    Raises ValueError: 40 terms do not suffice: the function is not smooth enough there.
    """
    import mpmath as mp

    with mp.workdps(50):
        for terms in range(3, _MOST_TERMS + 1):
            coefficients, off = mp.chebyfit(function, [first, last], terms, error=True)
            if off < error:
                return tuple(float(value) for value in reversed(coefficients))
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


def polynomial(
    precision: Precision, function: Callable[[Any], Any], last: float, x: Any, first: float = 0.0
) -> Any:
    """A function at `x` in ``[first, last]``, as a polynomial that fits it to the precision."""
    return horner(fitted(function, first, last, precision.epsilon * _SHARE), x)


def select(condition: Any, chosen: Any, otherwise: Any) -> Any:
    """One of two values, both computed."""
    return ca.if_else(condition, chosen, otherwise)


def angle_over_sine(precision: Precision, w: Any) -> Dual:
    """``θ / sin θ`` and its derivative by ``1 - w``, for ``w = cos θ`` in [0, 1]."""
    x = 1 - w

    def up_to(last: float) -> Dual:
        value = polynomial(precision, _angle_over_sine, last, x)
        return value, polynomial(precision, _angle_over_sine_slope, last, x)

    if not precision.branches:
        return up_to(1)
    near, far = up_to(_SMALL), up_to(1)
    return select(x < _SMALL, near[0], far[0]), select(x < _SMALL, near[1], far[1])


def angle_over_sine_beyond(precision: Precision, w: Any, sine_squared: Any) -> Dual:
    """``θ / sin θ`` and its derivative by ``1 - w`` for ``w`` in [-1, 1], the angle up to π.

    Beyond a quarter turn ``θ`` is ``π`` less the angle of ``-w``. At ``w = -1`` the axis is lost;
    the value there is large and finite.
    """
    value, slope = angle_over_sine(precision, ca.fabs(w))
    square = ca.fmax(sine_squared, precision.epsilon**3)
    from_pi = pi / ca.sqrt(square)
    beyond = w < 0
    return select(beyond, from_pi - value, value), select(
        beyond, slope - w / square * from_pi, slope
    )


def sinc_of_square(precision: Precision, y: Any) -> Dual:
    """``sin √y / √y`` and its derivative by ``y``, for ``√y`` in [0, π/2]."""
    value = polynomial(precision, _sinc, _QUARTER_TURN_SQUARED, y)
    return value, polynomial(precision, _sinc_slope, _QUARTER_TURN_SQUARED, y)


def cosine_sinc(precision: Precision, y: Any) -> tuple[Any, Any, Any]:
    """``cos √y``, ``sin √y / √y`` and the derivative of the latter by ``y``, for any ``y ≥ 0``.

    The angle is brought to [-π/2, π/2] by a multiple of π that is subtracted in parts. Up to
    2^26 turns in float64 and 2^11 in float32 nothing is lost beyond the angle's own rounding.
    """
    h = ca.sqrt(y)
    turns = ca.floor(h * (1 / pi) + 0.5)
    for part in _parts_of_pi(precision):
        h = h - turns * part
    sign = 1 - 2 * (turns - 2 * ca.floor(0.5 * turns))
    cosine, near, near_slope = _series(precision, h * h)
    cosine, beyond = sign * cosine, sign * h * near / ca.fmax(ca.sqrt(y), 1)
    if precision.branches:
        far = cosine, beyond, (cosine - beyond) / (2 * y)
        chosen = map(select, [y < _QUARTER_TURN_SQUARED] * 3, _series(precision, y), far)
        cosine, sinc, slope = chosen
        return cosine, sinc, slope
    # From a quarter turn on nothing cancels in the closed forms.
    reduced = turns < 0.5
    sinc = select(reduced, near, beyond)
    slope = select(reduced, near_slope, (cosine - sinc) / (2 * ca.fmax(y, 1)))
    return cosine, sinc, slope


def _series(precision: Precision, z: Any) -> list[Any]:
    """``cos √z``, ``sin √z / √z`` and its derivative for ``√z`` in [0, π/2]."""
    functions = (_cosine, _sinc, _sinc_slope)
    return [polynomial(precision, each, _QUARTER_TURN_SQUARED, z) for each in functions]


def _parts_of_pi(precision: Precision) -> list[float]:
    """π in four parts, all but the last with half the bits, so that their products are exact."""
    bits = precision.bits // 2
    parts: list[float] = []
    with mp.workdps(60):
        rest = +mp.pi
        for k in range(3):
            scale = mp.mpf(2) ** (bits * (k + 1) - 2)
            part = mp.floor(rest * scale) / scale
            parts.append(float(part))
            rest -= part
        parts.append(float(rest))
    return parts


def _angle_over_sine(x: Any) -> Any:
    angle = mp.acos(1 - x)
    return angle / mp.sin(angle)


def _angle_over_sine_slope(x: Any) -> Any:
    with mp.extradps(30):
        angle = mp.acos(1 - x)
        sine = mp.sin(angle)
        return (1 - angle * (1 - x) / sine) / sine**2


def _cosine(y: Any) -> Any:
    return mp.cos(mp.sqrt(y))


def _sinc(y: Any) -> Any:
    root = mp.sqrt(y)
    return mp.sin(root) / root


def _sinc_slope(y: Any) -> Any:
    with mp.extradps(30):
        root = mp.sqrt(y)
        return (mp.cos(root) - mp.sin(root) / root) / (2 * y)
