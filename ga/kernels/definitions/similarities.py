"""Similarities: products, exponential and logarithm, interpolation, projection, linear blend.

With ``E = e0∧e∞`` a similarity is ``S = A + B E + M``: two rotor-like elements and one of multiples
of ``e∞``. ``E`` commutes with rotors, ``E² = 1``, ``E M = M = -M E``. A unit versor of scale
``ρ = e^2h`` has ``A = R cosh h`` and ``B = R sinh h``, so that ``A + B = √ρ R`` and
``A - B = R / √ρ``, and ``M = -½ t∞ (A - B)`` with the translation ``t``.

Hyperbolic functions of the logarithm of a scale and back, without a library's functions.

A number ``h`` is ``n ln 2 + r`` with a whole n and ``|r| ≤ ½ ln 2``. Polynomials give functions of
``r``; what a dilator by ``2^n`` needs besides, ``½ (2^n ± 2^-n)``, is exact. For n = 0 everything
is as exact relative to ``h`` as ``h`` is, however small.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from math import log
from typing import Any

import casadi as ca
import mpmath as mp
import numpy as np

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.library_kernels.powers_of_two import exponent, power_of_two
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.blends import linear
from motorcade.ga.kernels.definitions.functions import (
    angle_over_sine,
    angle_over_sine_beyond,
    cosine_sinc,
    polynomial,
    select,
)

Numbers = list[Any]

_LIFT = "e1^e2^e3^einf"


@dataclass(frozen=True)
class Parts:
    """``S = turned + grown E + moved``; the reverse of ``B E`` is ``-~B E``."""

    turned: Multivector
    grown: Multivector
    moved: Multivector

    def __mul__(self, b: Parts) -> Parts:
        return Parts(
            self.turned * b.turned + self.grown * b.grown,
            self.turned * b.grown + self.grown * b.turned,
            (self.turned + self.grown) * b.moved + self.moved * (b.turned - b.grown),
        )

    def __invert__(self) -> Parts:
        return Parts(~self.turned, -(~self.grown), ~self.moved)

    def scaled(self, factor: Any) -> Parts:
        """Every coefficient times a number."""
        return Parts(*(on.scaled(part, factor) for part in (self.turned, self.grown, self.moved)))


def split(m: Numbers) -> Parts:
    """The parts of twelve coefficients."""
    return Parts(on.ROTOR.of(m[:4]), on.ROTOR.of(m[4:8]), on.MOVED.of(m[8:]))


def joined(s: Parts) -> Numbers:
    """The twelve coefficients."""
    moved = on.MOVED.numbers(s.moved)
    return [*on.ROTOR.numbers(s.turned), *on.ROTOR.numbers(s.grown), *moved]


def scalar(element: Multivector) -> Any:
    """The scalar part."""
    return element.coefficient("1")


def exponential(precision: Precision, log: Numbers) -> Parts:
    """``exp(V + h E + U)`` with an angle bivector V, ``V² = -φ²``, and ``U = -½ u∞``.

    The part of U across V anticommutes with ``G = V + h E`` and becomes ``(sinh G / G) U``, the
    part along V commutes with V and becomes ``(sinh h / h) e^V U``. Written with commutators, so
    that nothing is divided by φ; what is divided by ``h² + φ²`` is that small itself.
    """
    angles, h, push = on.ANGLES.of(log[:3]), log[3], on.MOVED.of(log[4:])
    square = on.angle_norm_squared(angles)
    cosine, sinc, _ = cosine_sinc(precision, square)
    cosh, sinh, over = hyperbolic(precision, h)
    rotor = cosine + sinc * angles
    across = angles.commutator(push)
    rest = (cosh * sinc - over * cosine) / ca.fmax(h * h + square, precision.epsilon**3)
    moved = (
        over * cosine * push
        + rest * (h * across - angles.commutator(across))
        + over * sinc * (angles ^ push)
    )
    return Parts(cosh * rotor, sinh * rotor, moved)


def logarithm(precision: Precision, s: Parts, short_way: bool) -> Numbers:
    """The bivector ``V + h E + U``, undoing `exponential` part by part.

    With ``σ = sin φ`` what is divided by ``σ² + sinh² h`` vanishes with that where ``φ ≤ ½ π``.
    """
    if short_way:
        sign = select(scalar(s.turned) < 0, -1, 1)
        s = s.scaled(sign)
    cosh = ca.sqrt(scalar(s.turned * ~s.turned))
    rotor = s.turned * (1 / cosh)
    sinh = scalar(s.grown * ~rotor)
    w, bivector = scalar(rotor), on.ANGLES.of(on.ANGLES.numbers(rotor))
    square = on.angle_norm_squared(rotor)
    if short_way:
        turn, _ = angle_over_sine(precision, w)
    else:
        turn, _ = angle_over_sine_beyond(precision, w, square)
    h, growth = inverse_hyperbolic(precision, cosh, sinh)
    numbers = on.MOVED.numbers(s.moved)
    shift, lift = on.MOVED.of(numbers[:3]), on.MOVED.of([0, 0, 0, numbers[3]])
    across = bivector.commutator(shift)
    share = 1 / ca.fmax(square + sinh * sinh, precision.epsilon**3)
    push = (
        growth * (w * shift - bivector * lift)
        + (growth * w - turn * cosh) * share * bivector.commutator(across)
        + sinh * (turn * w - growth * cosh) * share * across
    )
    return [*(turn * v for v in on.ANGLES.numbers(bivector)), h, *on.MOVED.numbers(push)[:3]]


def projected(precision: Precision, s: Parts) -> tuple[Parts, Any]:
    """The similarity nearest to an even element, and how well it is defined, from 0 to 1.

    With ``m ~m = s + F``, ``F² = f`` and ``ν = √(s² - f)`` it is ``((s + ν) - F) m /
    (ν √(2 (s + ν)))``. Here ``ν = |P| |N|`` with ``P = A + B`` and ``N = A - B``, so that its rotor
    is half-way between the directions of P and N and its scale is ``|P| / |N|``. Nothing is defined
    where P or N vanish (no scale) or are opposite (``s = -ν``).
    """
    s = _of_size_two(precision, s)
    a, b, moved = s.turned, s.grown, s.moved
    (grown, p), (shrunk, n) = (_direction(precision, part) for part in (a + b, a - b))
    both, rotor = _direction(precision, p + n)
    least = 2 * precision.epsilon * ca.fmax(grown, shrunk)
    lesser = ca.fmin(grown, shrunk)
    root = 1 / ca.sqrt(ca.fmax(grown, least) * ca.fmax(shrunk, least))
    cosh = 0.5 * (grown + shrunk) * root
    sinh = 2 * scalar(a * ~b) / (grown + shrunk) * root
    moved = rotor * ~p * moved * root
    # What is left of ``S ~S`` on e123∞ is taken away along N.
    off = 2 * (moved * ~rotor).coefficient(_LIFT) / ca.fmax(both, precision.epsilon)
    moved = moved - off * (n * on.MOVED.of([0, 0, 0, 1]))
    defined = select(lesser > least, 0.5 * both, 0)
    return Parts(cosh * rotor, sinh * rotor, moved), defined


def _of_size_two(precision: Precision, s: Parts) -> Parts:
    """The element times a power of two, so that nothing is rounded and its squares are numbers."""
    sizes = [ca.fabs(value) for part in (s.turned, s.grown) for value in on.ROTOR.numbers(part)]
    highest = float(np.finfo(precision.numpy).maxexp - 1)
    factor = power_of_two(ca.fmin(1 - exponent(reduce(ca.fmax, sizes)), highest))
    return s.scaled(factor)


def _direction(precision: Precision, rotor: Multivector) -> tuple[Any, Multivector]:
    """Length, and the element divided by it."""
    length = ca.sqrt(scalar(rotor * ~rotor))
    return length, rotor * (1 / ca.fmax(length, precision.epsilon**2))


def _normalize(precision: Precision, m: Numbers) -> list[Numbers]:
    """The similarity nearest to an even element, and how well it is defined."""
    unit, defined = projected(precision, split(m))
    return [[*joined(unit), defined]]


def _blend(precision: Precision, a: Numbers, b: Numbers, fraction: Numbers) -> list[Numbers]:
    """Linear blend of two similarities, the short way round, made unit."""
    unit, _ = projected(precision, split(linear(a, b, fraction[0])))
    return [joined(unit)]


_A, _B, _M, _OUT = (Operand(name, on.SIMILARITY) for name in ("a", "b", "m", "out"))
_DEFINED, _BLENDS = Operand("out", on.DEFINED_SIMILARITY), "similarity_blends"

KERNELS = (
    Kernel("similarity_normalize", _BLENDS, (_M,), (_DEFINED,), _normalize),
    Kernel("similarity_blend", _BLENDS, (_A, _B, on.numbers("fraction")), (_OUT,), _blend),
)


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
