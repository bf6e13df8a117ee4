"""Blends of motors: along the screw, linear, and n-way; also straight to matrices.

Weighted averages of several versors, which take one of them after the other.

A blend is the sum of `add_weighted`, projected; a mean moves by the sum of `add_local` until that
vanishes. See ``ga/versors/averages.py``.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import casadi as ca

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.conversions import matrix_rows
from motorcade.ga.kernels.definitions.functions import angle_over_sine, select, sinc_of_square
from motorcade.ga.kernels.definitions.parts.rotors import largest
from motorcade.ga.kernels.definitions.versors import Versors

Numbers = list[Any]


def linear(a: Numbers, b: Numbers, fraction: Any) -> Numbers:
    """``(1 - f) a ± f b`` with the sign that goes the short way round; not unit."""
    scalar = sum(x * y for x, y in zip(a[:4], b[:4], strict=True))
    signed = select(scalar < 0, -fraction, fraction)
    return [(1 - fraction) * x + signed * y for x, y in zip(a, b, strict=True)]


def screw(precision: Precision, a: Numbers, b: Numbers, fraction: Any) -> Multivector:
    """``(sin (1 - f)Θ a ± sin fΘ b) / sin Θ`` with the dual angle Θ between a and b.

    The same motor as ``a exp(f log(~a b))`` for fractions in [0, 1], in half the operations.
    With ``Θ² = y`` and ``Θ / sin Θ = p`` the weight of b is ``f p sin(√(f² y)) / √(f² y)``.
    """
    first, second = on.MOTOR.of(a), on.MOTOR.of(b)
    c, d = on.DUAL.numbers(~first * second)
    sign = select(c < 0, -1, 1)
    c, d = sign * c, sign * d
    p, slope = angle_over_sine(precision, c)
    square = p * p * (1 - c * c)
    weights = []
    for part in (1 - fraction, fraction):
        sinc, sinc_slope = sinc_of_square(precision, part * part * square)
        # By x = 1 - c: the derivative of y is 2 p, and d enters with the opposite sign.
        derivative = sinc * slope + 2 * part * part * sinc_slope * p * p
        weights.append((part * sinc * p, -part * derivative * d))
    (u, du), (v, dv) = weights
    return on.DUAL.of((u, du)) * first + on.DUAL.of((sign * v, sign * dv)) * second


def _blend(precision: Precision, a: Numbers, b: Numbers, fraction: Numbers) -> list[Numbers]:
    """Linear blend of two motors, the short way round, made unit."""
    return [on.MOTOR.numbers(projected(on.MOTOR.of(linear(a, b, fraction[0]))))]


def _blend_matrix(precision: Precision, a: Numbers, b: Numbers, fraction: Numbers) -> list[Numbers]:
    """Linear blend of two motors as a 3×4 matrix."""
    return [matrix_rows(linear(a, b, fraction[0]), unit=False)]


def _screw(precision: Precision, a: Numbers, b: Numbers, fraction: Numbers) -> list[Numbers]:
    """Screw interpolation for fractions in [0, 1]."""
    return [on.MOTOR.numbers(screw(precision, a, b, fraction[0]))]


def _screw_matrix(precision: Precision, a: Numbers, b: Numbers, fraction: Numbers) -> list[Numbers]:
    """Screw interpolation for fractions in [0, 1] as a 3×4 matrix."""
    return [matrix_rows(on.MOTOR.numbers(screw(precision, a, b, fraction[0])), unit=True)]


def projected(m: Multivector) -> Multivector:
    """The motor nearest to an even element: ``m α^(-½) (1 - β J / 2α)`` of ``m ~m = α + β J``."""
    alpha, beta = on.DUAL.numbers(m * ~m)
    root = 1 / ca.sqrt(alpha)
    return on.DUAL.of((root, -0.5 * beta / alpha * root)) * m


def _normalize(precision: Precision, m: Numbers) -> list[Numbers]:
    """The motor nearest to an even element."""
    return [on.MOTOR.numbers(projected(on.MOTOR.of(m)))]


def _normalize_matrix(precision: Precision, m: Numbers) -> list[Numbers]:
    """3×4 matrix of the motor nearest to an even element."""
    return [matrix_rows(m, unit=False)]


def _accumulate(
    precision: Precision, total: Numbers, pivot: Numbers, m: Numbers, weight: Numbers
) -> list[Numbers]:
    """Sum total ± weight m, signed as m beside the pivot."""
    scalar = sum(x * y for x, y in zip(pivot[:4], m[:4], strict=True))
    signed = select(scalar < 0, -weight[0], weight[0])
    return [[x + signed * y for x, y in zip(total, m, strict=True)]]


_A, _B, _M, _OUT = (
    on.MOTOR.operand("a"),
    on.MOTOR.operand("b"),
    on.MOTOR.operand("m"),
    on.MOTOR.operand("out"),
)
_F, _ROWS = on.numbers("fraction"), on.components("out", 3, 4)

KERNELS = (
    Kernel("blend", "linear_blends", (_A, _B, _F), (_OUT,), _blend),
    Kernel("blend_matrix", "linear_blends", (_A, _B, _F), (_ROWS,), _blend_matrix),
    Kernel("screw_blend", "screw_blends", (_A, _B, _F), (_OUT,), _screw),
    Kernel("screw_blend_matrix", "screw_blends", (_A, _B, _F), (_ROWS,), _screw_matrix),
    Kernel(
        "accumulate",
        "linear_blends",
        (on.MOTOR.operand("total"), on.MOTOR.operand("pivot"), _M, on.numbers("weight")),
        (_OUT,),
        _accumulate,
    ),
    Kernel("normalize", "linear_blends", (_M,), (_OUT,), _normalize),
    Kernel("normalize_matrix", "linear_blends", (_M,), (_ROWS,), _normalize_matrix),
)


# How long the terms are together, beside which a sum that cancels is told.
BULK = "bulk"


def _add_weighted(
    precision: Precision, total: Numbers, pivot: Numbers, m: Numbers, weight: Numbers
) -> list[Numbers]:
    scalar = sum(x * y for x, y in zip(pivot[:4], m[:4], strict=True))
    signed = select(scalar < 0, -weight[0], weight[0])
    bulk = total[-1] + ca.fabs(weight[0]) * largest([ca.fabs(x) for x in m[:4]])
    return [[*(x + signed * y for x, y in zip(total[:-1], m, strict=True)), bulk]]


def _add_local(
    of: Versors, precision: Precision, total: Numbers, a: Numbers, b: Numbers, weight: Numbers
) -> list[Numbers]:
    twist = of.as_twist(of.log(precision, ~of.read(a) * of.read(b), True))
    return [[x + weight[0] * y for x, y in zip(total, twist, strict=True)]]


def average_kernels(of: Versors) -> tuple[Kernel, Kernel]:
    """The two of one kind of versor."""
    group, weight = f"{of.prefix}averages", on.numbers("weight")
    a, b, m, pivot = (Operand(name, of.versor) for name in ("a", "b", "m", "pivot"))
    total, out = (Operand(name, (*of.versor, BULK)) for name in ("s", "out"))
    return (
        Kernel(
            f"{of.prefix}add_weighted",
            group,
            (total, pivot, m, weight),
            (out,),
            _add_weighted,
            f"A sum of {of.plural} with one more, signed as it is beside the pivot",
        ),
        Kernel(
            f"{of.prefix}add_local",
            group,
            (on.twist("s", of.twist_size), a, b, weight),
            (on.twist("out", of.twist_size),),
            partial(_add_local, of),
            f"A sum of twists with that from {of.name} a to b, which turns by at most π",
        ),
    )
