"""Elementary functions without branches and calls, of which compilers make SIMD code in loops.

An argument is reduced, a polynomial evaluated, and the result put together again, as in Cody and
Waite, "Software Manual for the Elementary Functions" (1980); the polynomials are fitted here. All
stay within two roundings where the reduction does: sines, cosines and tangents lose no more than
the rounding of their own argument up to 1e8 (float64) or 6e3 (float32). Of NaN all give NaN.
``atan2`` takes a zero of either sign for the positive one.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Any

import casadi as ca
import mpmath as mp

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.library_kernels.powers_of_two import exponent, power_of_two
from motorcade.ga.codegen.precision import SINGLE, Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions.functions import polynomial, select

Numbers = list[Any]

_SLOPE_1, _SLOPE_3 = 2**0.5 - 1, 2**0.5 + 1  # of angles of π/8 and 3π/8
_LOG_2 = 0.6931471805599453


def _sin(precision: Precision, x: Numbers) -> list[Numbers]:
    """Sine of x."""
    odd, flipped, sine, cosine = _sine_and_cosine(precision, x[0])
    value = select(odd > 0.5, cosine, sine)
    return [[value * (1 - 2 * flipped)]]


def _cos(precision: Precision, x: Numbers) -> list[Numbers]:
    """Cosine of x."""
    odd, flipped, sine, cosine = _sine_and_cosine(precision, x[0])
    value = select(odd > 0.5, sine, cosine)
    return [[value * (1 - 2 * odd) * (1 - 2 * flipped)]]


def _tan(precision: Precision, x: Numbers) -> list[Numbers]:
    """Tangent of x."""
    odd, _, sine, cosine = _sine_and_cosine(precision, x[0])
    return [[select(odd > 0.5, -cosine, sine) / select(odd > 0.5, sine, cosine)]]


def _sine_and_cosine(precision: Precision, x: Any) -> tuple[Any, Any, Any, Any]:
    """The quarter of the turn, 0 to 3, as its lower and its higher bit, and both functions of what
    is left, within π/4.
    """
    turns = ca.floor(x * (2 / pi) + 0.5)
    half = ca.floor(0.5 * turns)
    r = x
    for part in _parts(mp.pi, precision.bits // 2, 3):
        r = r - turns * (part / 2)
    z = r * r
    last = (pi / 4 + 1e-3) ** 2
    sine = r + r * z * polynomial(precision, _sine_rest, last, z)
    cosine = 1 - 0.5 * z + z * z * polynomial(precision, _cosine_rest, last, z)
    return turns - 2 * half, half - 2 * ca.floor(0.5 * half), sine, cosine


def _exp(precision: Precision, x: Numbers) -> list[Numbers]:
    """Exponential of x."""
    single = precision.bits == SINGLE.bits
    least, largest = (-105, 90) if single else (-746, 711)
    lifted = select(x[0] < least, least, x[0])
    clipped = select(lifted > largest, largest, lifted)
    n = ca.floor(clipped * (1 / _LOG_2) + 0.5)
    high, low = _parts(mp.ln2, precision.bits - 11, 2)
    r = clipped - n * high - n * low
    value = 1 + (r + r * r * polynomial(precision, _exp_rest, 0.348, r, -0.348))
    # In two steps, as one would be too large or too small on its own.
    half = ca.floor(0.5 * n)
    return [[value * power_of_two(half) * power_of_two(n - half)]]


def _log(precision: Precision, x: Numbers) -> list[Numbers]:
    """Natural logarithm of x; minus infinity of 0, NaN of less."""
    single = precision.bits == SINGLE.bits
    tiny, shift = (2.0**-100, 64) if single else (2.0**-960, 128)
    lifted = x[0] < tiny
    normal = select(lifted, x[0] * 2.0**shift, x[0])
    # Of x / √2, so that what is left lies around 1; no power of two is out of range.
    below = exponent(0.5**0.5 * normal)
    f = 0.25 * normal * power_of_two(1 - below) - 1
    power = below + select(lifted, 1 - shift, 1)
    high, low = _parts(mp.ln2, precision.bits - 11, 2)
    largest = (2 - precision.epsilon) * 2.0 ** (127 if single else 1023)
    square = 0.5 * f * f
    if single:
        rest = f * f * f * polynomial(precision, _log_rest, 0.4143, f, -0.2929)
        value = power * high + (rest - square + power * low + f)
    else:
        s = f / (2 + f)
        z = s * s
        rest = z * polynomial(precision, _log_quotient_rest, 0.0296, z)
        value = power * high - ((square - (s * (square + rest) + power * low)) - f)
    value = select(x[0] > largest, x[0], value)
    # Infinity as a product that overflows, NaN as its difference from itself.
    root = select(x[0] <= 0, largest, 1)
    infinity = root * root
    return [[select(x[0] <= 0, select(x[0] < 0, infinity, 0) - infinity, value)]]


def _atan2(precision: Precision, y: Numbers, x: Numbers) -> list[Numbers]:
    """Angle of the point (x, y), from -π to π."""
    return [[_angle(precision, y[0], x[0])]]


def _atan(precision: Precision, x: Numbers) -> list[Numbers]:
    """Angle from -π/2 to π/2 whose tangent is x."""
    value = _first_quarter(precision, ca.fabs(x[0]), 1)
    return [[select(x[0] < 0, -value, value)]]


def _asin(precision: Precision, x: Numbers) -> list[Numbers]:
    """Angle from -π/2 to π/2 whose sine is x."""
    value = _first_quarter(precision, ca.fabs(x[0]), _other_leg(x[0]))
    return [[select(x[0] < 0, -value, value)]]


def _acos(precision: Precision, x: Numbers) -> list[Numbers]:
    """Angle from 0 to π whose cosine is x."""
    return [[_angle(precision, _other_leg(x[0]), x[0], positive=True)]]


def _other_leg(x: Any) -> Any:
    return ca.sqrt((1 - x) * (1 + x))


def _angle(precision: Precision, y: Any, x: Any, positive: bool = False) -> Any:
    value = _first_half(precision, y if positive else ca.fabs(y), x)
    return value if positive else select(y < 0, -value, value)


def _first_half(precision: Precision, y: Any, x: Any) -> Any:
    """Angle of the point (x, y) whose y is not negative."""
    high, low = _parts(mp.pi, precision.bits, 2)
    if precision.bits != SINGLE.bits:
        value = _first_quarter(precision, y, ca.fabs(x))
        return select(x < 0, (high - value) + low, value)
    # One polynomial up to π/4 is short enough.
    steep, left = y > ca.fabs(x), x < 0
    value = _up_to_eighth(precision, select(steep, ca.fabs(x), y), select(steep, y, ca.fabs(x)))
    around = select(steep, high / 2, select(left, high, 0))
    return around + (around * (low / high) + select(steep != left, -value, value))


def _up_to_eighth(precision: Precision, top: Any, bottom: Any) -> Any:
    """The angle whose tangent is a quotient of at most 1; 0 is that of two zeros."""
    t = top / select(bottom == 0, 1, bottom)
    z = t * t
    return t + t * z * polynomial(precision, _atan_rest, 1 + 1e-3, z)


def _first_quarter(precision: Precision, y: Any, x: Any) -> Any:
    """Angle of the point (x, y) of numbers that are not negative."""
    high, low = _parts(mp.pi, precision.bits, 2)
    if precision.bits == SINGLE.bits:
        return _first_half(precision, y, x)
    flat, steeper = y > _SLOPE_1 * x, y > _SLOPE_3 * x
    top = select(steeper, -x, select(flat, y - x, y))
    bottom = select(steeper, y, select(flat, y + x, x))
    t = top / select(bottom == 0, 1, bottom)
    z = t * t
    around = select(steeper, high / 2, select(flat, high / 4, 0))
    series = t * z * polynomial(precision, _atan_rest, _SLOPE_1**2 + 1e-3, z)
    return around + (around * (low / high) + series + t)


def _parts(value: Any, bits: int, count: int) -> list[float]:
    """A number in parts, all but the last with so many bits."""
    parts: list[float] = []
    with mp.workdps(60):
        rest = +value
        for _ in range(count - 1):
            scale = mp.mpf(2) ** (bits - 1 - mp.floor(mp.log(rest, 2)))
            part = mp.floor(rest * scale) / scale
            parts.append(float(part))
            rest -= part
        parts.append(float(rest))
    return parts


def _sine_rest(z: Any) -> Any:
    with mp.extradps(30):
        root = mp.sqrt(z)
        return (mp.sin(root) / root - 1) / z


def _cosine_rest(z: Any) -> Any:
    with mp.extradps(30):
        return (mp.cos(mp.sqrt(z)) - 1 + z / 2) / z**2


def _exp_rest(r: Any) -> Any:
    with mp.extradps(30):
        return (mp.exp(r) - 1 - r) / r**2 if r else mp.mpf(1) / 2


def _log_rest(f: Any) -> Any:
    with mp.extradps(30):
        return (mp.log1p(f) - f + f**2 / 2) / f**3 if f else mp.mpf(1) / 3


def _log_quotient_rest(z: Any) -> Any:
    with mp.extradps(30):
        root = mp.sqrt(z)
        return (2 * mp.atanh(root) / root - 2) / z


def _atan_rest(z: Any) -> Any:
    with mp.extradps(30):
        root = mp.sqrt(z)
        return (mp.atan(root) / root - 1) / z


def _function(name: str, define: Callable[..., Any], *names: str) -> Kernel:
    inputs = tuple(Operand(one, ("1",)) for one in names)
    return Kernel(name, "elementary", inputs, (Operand("result", ("1",)),), define)


FUNCTIONS = (
    _function("sin", _sin, "x"),
    _function("cos", _cos, "x"),
    _function("tan", _tan, "x"),
    _function("asin", _asin, "x"),
    _function("acos", _acos, "x"),
    _function("atan", _atan, "x"),
    _function("atan2", _atan2, "y", "x"),
    _function("exp", _exp, "x"),
    _function("log", _log, "x"),
)
