"""Motors: products, exponential and logarithm, interpolation along the screw."""

from __future__ import annotations

from typing import Any

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import (
    angle_over_sine,
    angle_over_sine_beyond,
    cosine_sinc,
    select,
)

__all__ = ["KERNELS", "exponential", "flipped", "logarithm"]

Numbers = list[Any]


def exponential(precision: Precision, bivector: Multivector) -> Multivector:
    """``exp B = cos √Y + (sin √Y / √Y) B`` with the dual number ``Y = -B²``."""
    y, dual_y = on.dual_numbers(-(bivector * bivector))
    cosine, sinc, slope = cosine_sinc(precision, y)
    # The derivative of cos √y by y is -½ sin √y / √y.
    scalar = on.dual_of((cosine, -0.5 * sinc * dual_y))
    return scalar + on.dual_of((sinc, slope * dual_y)) * bivector


def flipped(m: Multivector) -> Multivector:
    """The versor of the same motion that turns by at most π; a scalar of zero stays as it is."""
    w = m.coefficient("1")
    return on.scaled(m, select(w < 0, -1, 1))


def logarithm(precision: Precision, m: Multivector, short_way: bool) -> Multivector:
    """``log M = (θ / sin θ) V`` with the bivector part V and the dual ``cos θ`` of M."""
    m = flipped(m) if short_way else m
    w, dual_w = on.dual_numbers(m)
    bivector = on.bivector_of(on.bivector_numbers(m))
    if short_way:
        value, slope = angle_over_sine(precision, w)
    else:
        sine_squared = on.angle_norm_squared(m)
        value, slope = angle_over_sine_beyond(precision, w, sine_squared)
    return on.dual_of((value, -slope * dual_w)) * bivector


def _compose(precision: Precision, a: Numbers, b: Numbers) -> list[Numbers]:
    """Geometric product a b of motors."""
    return [on.motor_numbers(on.motor_of(a) * on.motor_of(b))]


def _inverse(precision: Precision, m: Numbers) -> list[Numbers]:
    """Reverse of a motor: its inverse."""
    return [on.motor_numbers(~on.motor_of(m))]


def _exp(precision: Precision, log: Numbers) -> list[Numbers]:
    """Motor of a bivector of any size."""
    return [on.motor_numbers(exponential(precision, on.bivector_of(log)))]


def _log(precision: Precision, m: Numbers) -> list[Numbers]:
    """Bivector of a motor, by the sign that turns by at most π."""
    return [on.bivector_numbers(logarithm(precision, on.motor_of(m), True))]


def _log_long(precision: Precision, m: Numbers) -> list[Numbers]:
    """Bivector of a motor by its own sign, turning by up to 2π."""
    return [on.bivector_numbers(logarithm(precision, on.motor_of(m), False))]


def _between(
    precision: Precision, a: Numbers, b: Numbers, fraction: Numbers, short_way: bool
) -> list[Numbers]:
    first, second = on.motor_of(a), on.motor_of(b)
    step = logarithm(precision, ~first * second, short_way) * fraction[0]
    return [on.motor_numbers(first * exponential(precision, step))]


def _interpolate(precision: Precision, a: Numbers, b: Numbers, f: Numbers) -> list[Numbers]:
    """Screw a exp(fraction log(~a b)), the short way round."""
    return _between(precision, a, b, f, True)


def _interpolate_long(precision: Precision, a: Numbers, b: Numbers, f: Numbers) -> list[Numbers]:
    """Screw a exp(fraction log(~a b)), by the signs of a and b."""
    return _between(precision, a, b, f, False)


_A, _B, _M, _OUT = on.motor("a"), on.motor("b"), on.motor("m"), on.motor("out")
_LOG, _F = on.bivector("log"), on.numbers("fraction")
_LOG_OUT = on.bivector("out")

KERNELS = (
    Kernel("compose", "products", (_A, _B), (_OUT,), _compose),
    Kernel("inverse", "products", (_M,), (_OUT,), _inverse),
    Kernel("exp", "exponentials", (_LOG,), (_OUT,), _exp),
    Kernel("log", "exponentials", (_M,), (_LOG_OUT,), _log),
    Kernel("log_long", "exponentials", (_M,), (_LOG_OUT,), _log_long),
    Kernel("interpolate", "screws", (_A, _B, _F), (_OUT,), _interpolate),
    Kernel("interpolate_long", "screws", (_A, _B, _F), (_OUT,), _interpolate_long),
)
