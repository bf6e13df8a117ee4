"""Hyperbolic functions of the logarithm of a scale and back, without a library's functions.

A number ``h`` is ``n ln 2 + r`` with a whole n and ``|r| ≤ ½ ln 2``. Polynomials give functions of
``r``; what a dilator by ``2^n`` needs besides, ``½ (2^n ± 2^-n)``, is exact. For n = 0 everything
is as exact relative to ``h`` as ``h`` is, however small.
"""

from __future__ import annotations

from math import log
from typing import Any

import casadi as ca
import mpmath as mp

from motorcade.ga.codegen.library_kernels.powers_of_two import exponent, power_of_two
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions.functions import polynomial, select

# Where the polynomials end, with room for rounding: squares of ½ ln 2 and of sinh ½ ln 2 = √⅛.
_HALF_OCTAVE = 0.5 * log(2) + 1e-3
_LOG_SQUARED = (0.5 * log(2)) ** 2 + 1e-3
_SINE_SQUARED = 0.125 + 1e-3
# Logarithms of scales up to which what is left of e^x without its first terms is a polynomial.
_NEAR = 1.0


def hyperbolic(precision: Precision, h: Any) -> tuple[Any, Any, Any]:
    """``cosh h``, ``sinh h`` and ``sinh h / h``; infinite or NaN where ``e^|h|`` is too large."""
    n = ca.floor(h * (1 / log(2)) + 0.5)
    high, low = _parts_of_log_two(precision)
    r = h - n * high - n * low
    square = r * r
    near = polynomial(precision, _sinh_over, _LOG_SQUARED, square)
    cosine, sine = polynomial(precision, _cosh, _LOG_SQUARED, square), r * near
    grown, shrunk = power_of_two(n), power_of_two(-n)
    even, odd = 0.5 * (grown + shrunk), 0.5 * (grown - shrunk)
    cosh, sinh = even * cosine + odd * sine, odd * cosine + even * sine
    size = ca.fmax(ca.fabs(h), 0.25)
    over = select(ca.fabs(n) < 0.5, near, ca.fabs(sinh) / size)
    if not precision.branches:
        return cosh, sinh, over
    small = h * h < _LOG_SQUARED
    own = polynomial(precision, _sinh_over, _LOG_SQUARED, h * h)
    series = polynomial(precision, _cosh, _LOG_SQUARED, h * h), h * own, own
    a, b, c = map(select, [small] * 3, series, (cosh, sinh, over))
    return a, b, c


def inverse_hyperbolic(precision: Precision, cosh: Any, sinh: Any) -> tuple[Any, Any]:
    """``h`` and ``h / sinh h`` of ``cosh h`` and ``sinh h``.

    ``e^|h|`` is ``2^n e^r``, and ``r`` has the hyperbolic sine ``½ (e^r - e^-r)``.
    """
    size = ca.fabs(sinh)
    whole = cosh + size
    n = exponent(2**0.5 * whole)
    rest = whole * power_of_two(-n)
    still = n < 0.5
    sine = select(still, size, 0.5 * (rest - 1 / rest))
    near = polynomial(precision, _asinh_over, _SINE_SQUARED, sine * sine)
    high, low = _parts_of_log_two(precision)
    h = n * high + (n * low + sine * near)
    quotient = select(still, near, h / ca.fmax(size, 0.25))
    if precision.branches:
        small = sinh * sinh < _SINE_SQUARED
        own = polynomial(precision, _asinh_over, _SINE_SQUARED, sinh * sinh)
        quotient = select(small, own, quotient)
    return quotient * sinh, quotient


def growth_means(precision: Precision, x: Any) -> tuple[Any, Any, Any]:
    """``e^x``, ``(e^x - 1) / x`` and ``(e^x - 1 - x) / x²``."""
    n = ca.floor(x * (1 / log(2)) + 0.5)
    high, low = _parts_of_log_two(precision)
    r = x - n * high - n * low
    whole = power_of_two(n) * polynomial(precision, mp.exp, _HALF_OCTAVE, r, -_HALF_OCTAVE)
    near = ca.fmax(ca.fmin(x, _NEAR), -_NEAR)
    far = select(x < 0, ca.fmin(x, -_NEAR), ca.fmax(x, _NEAR))
    second_near = polynomial(precision, _exp_rest, _NEAR + 1e-3, near, -_NEAR - 1e-3)
    first_far = (whole - 1) / far
    small = ca.fabs(x) < _NEAR
    first = select(small, 1 + near * second_near, first_far)
    return whole, first, select(small, second_near, (first_far - 1) / far)


def _parts_of_log_two(precision: Precision) -> tuple[float, float]:
    """Two parts of ln 2, the first with so few bits that multiples of it are exact."""
    with mp.workdps(60):
        scale = mp.mpf(2) ** (precision.bits // 2)
        high = mp.floor(mp.log(2) * scale) / scale
        return float(high), float(mp.log(2) - high)


def _sinh_over(y: Any) -> Any:
    root = mp.sqrt(y)
    return mp.sinh(root) / root


def _cosh(y: Any) -> Any:
    return mp.cosh(mp.sqrt(y))


def _asinh_over(y: Any) -> Any:
    root = mp.sqrt(y)
    return mp.asinh(root) / root


def _exp_rest(x: Any) -> Any:
    with mp.extradps(40):
        return (mp.expm1(x) - x) / x**2 if x else mp.mpf(1) / 2
