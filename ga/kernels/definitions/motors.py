"""Motors and rotors: exponential and logarithm, and how twists act.

A twist is ``-2 log``: rotation vector (rad), then translational part (m). On a bivector ``Y`` the
adjoint is ``M Y ~M`` and the left Jacobian of exp at ``X`` is ``Y + b [X, Y] + d [X, [X, Y]]`` with
the coefficients of `jacobian_series`, dual numbers ``b + b' e123∞`` on motors. Both are linear, so
that they are the same on twists. The right Jacobian is the left one at ``-X``. Rotors are motors
without the part that moves.

Coefficients of the Jacobians of exp, as functions of ``z = (θ / 2)²`` for any angle ``θ``.

With ``ad`` the commutator with a twist that turns by ``θ``, ``ad³ = -θ² ad`` on rotations, so that

    ``Σ adⁿ / (n + 1)!   = 1 + b ad + d ad²``,  ``b = (1 - cos θ) / θ²``, ``d = (θ - sin θ) / θ³``,
    ``Σ Bₙ adⁿ / n!      = 1 - ½ ad + c ad²``,  ``c = (1 - ½ θ cot ½ θ) / θ²``,

with the Bernoulli numbers ``Bₙ``. On rigid motions the same holds of dual numbers, for which the
derivatives by ``z`` are here too. Up to half a turn they are polynomials, beyond closed forms, in
which nothing cancels there. The second is singular at full turns.
"""

from __future__ import annotations

from functools import partial
from math import pi
from typing import Any, NamedTuple

import casadi as ca
import mpmath as mp

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import (
    Dual,
    angle_over_sine,
    angle_over_sine_beyond,
    cosine_sinc,
    polynomial,
    select,
)
from motorcade.ga.kernels.definitions.versors import Versors, matrix_rows

Numbers = list[Any]


def exponential(precision: Precision, bivector: Multivector) -> Multivector:
    """``exp B = cos √Y + (sin √Y / √Y) B`` with the dual number ``Y = -B²``."""
    y, dual_y = on.DUAL.numbers(-(bivector * bivector))
    cosine, sinc, slope = cosine_sinc(precision, y)
    # The derivative of cos √y by y is -½ sin √y / √y.
    scalar = on.DUAL.of((cosine, -0.5 * sinc * dual_y))
    return scalar + on.DUAL.of((sinc, slope * dual_y)) * bivector


def flipped(m: Multivector) -> Multivector:
    """The versor of the same motion that turns by at most π; a scalar of zero stays as it is."""
    w = m.coefficient("1")
    return on.scaled(m, select(w < 0, -1, 1))


def logarithm(precision: Precision, m: Multivector, short_way: bool) -> Multivector:
    """``log M = (θ / sin θ) V`` with the bivector part V and the dual ``cos θ`` of M."""
    m = flipped(m) if short_way else m
    w, dual_w = on.DUAL.numbers(m)
    bivector = on.BIVECTOR.of(on.BIVECTOR.numbers(m))
    if short_way:
        value, slope = angle_over_sine(precision, w)
    else:
        sine_squared = on.angle_norm_squared(m)
        value, slope = angle_over_sine_beyond(precision, w, sine_squared)
    return on.DUAL.of((value, -slope * dual_w)) * bivector


def _transform_twist(bivector: on.Coefficients, versor: Multivector, twist: Numbers) -> Numbers:
    return bivector.numbers(versor * bivector.of(twist) * ~versor)


def _left_jacobian(bivector: on.Coefficients, precision: Precision, twist: Numbers) -> Numbers:
    x = bivector.of(_scaled(-0.5, twist))
    z, dual_z = on.DUAL.numbers(-(x * x))
    b, d = forward_series(precision, half_turn(precision, z))
    return _series_rows(bivector, x, _dual(b, dual_z), _dual(d, dual_z))


def _left_jacobian_inverse(
    bivector: on.Coefficients, precision: Precision, twist: Numbers
) -> Numbers:
    x = bivector.of(_scaled(-0.5, twist))
    z, dual_z = on.DUAL.numbers(-(x * x))
    c = inverse_series(precision, half_turn(precision, z))
    return _series_rows(bivector, x, on.DUAL.of((-0.5, 0)), _dual(c, dual_z))


def _series_rows(
    bivector: on.Coefficients, x: Multivector, first: Multivector, second: Multivector
) -> Numbers:
    """``1 + first ad + second ad²`` by rows; ``a.commutator(b)`` is ``½ [a, b]``."""

    def column(y: Numbers) -> Numbers:
        once = 2 * x.commutator(bivector.of(y))
        twice = 2 * x.commutator(once)
        return bivector.numbers(bivector.of(y) + first * once + second * twice)

    return matrix_rows(column, len(bivector.names))


def _dual(value: Dual, dual_z: Any) -> Multivector:
    return on.DUAL.of((value[0], value[1] * dual_z))


def _scaled(factor: float, numbers: Numbers) -> Numbers:
    return [factor * value for value in numbers]


def _versors(name: str, prefix: str, versor: on.Coefficients, bivector: on.Coefficients) -> Versors:
    return Versors(
        prefix,
        name,
        f"{name}s",
        "Screw",
        versor.names,
        bivector.names,
        len(bivector.names),
        versor.of,
        versor.numbers,
        lambda precision, log: exponential(precision, bivector.of(log)),
        lambda precision, m, short_way: bivector.numbers(logarithm(precision, m, short_way)),
        partial(_scaled, -0.5),
        partial(_scaled, -2),
        partial(_transform_twist, bivector),
        partial(_left_jacobian, bivector),
        partial(_left_jacobian_inverse, bivector),
    )


MOTORS = _versors("motor", "", on.MOTOR, on.BIVECTOR)
ROTORS = _versors("rotor", "rotor_", on.ROTOR, on.ANGLES)


_QUARTER_TURN_SQUARED = (pi / 2) ** 2
_FITTED_UP_TO = _QUARTER_TURN_SQUARED + 1e-3


class HalfTurn(NamedTuple):
    """Functions of the half angle ``√z``: cosine, ``sin √z / √z`` and the latter's slope by z."""

    z: Any
    cosine: Any
    sinc: Any
    slope: Any


def half_turn(precision: Precision, z: Any) -> HalfTurn:
    """The functions that the series are made of, at ``z ≥ 0``."""
    return HalfTurn(z, *cosine_sinc(precision, z))


def forward_series(precision: Precision, half: HalfTurn) -> tuple[Dual, Dual]:
    """``b`` and ``d``, each with its derivative by z."""
    z, cosine, sinc, slope = half
    far = _beyond_half_a_turn(z)
    value = (1 - sinc * cosine) / (4 * far)
    by_z = (3 * sinc * cosine - 1 - 2 * cosine * cosine) / (8 * far * far)
    d = _joined(precision, z, (_sine_rest, _sine_rest_slope), (value, by_z))
    return (0.5 * sinc * sinc, sinc * slope), d


def inverse_series(precision: Precision, half: HalfTurn) -> Dual:
    """``c`` and its derivative by z."""
    z, cosine, sinc, _ = half
    far = _beyond_half_a_turn(z)
    size = ca.fmax(ca.fabs(sinc), precision.epsilon**2)
    over = select(sinc < 0, -1, 1) / size
    cotangent = cosine * over
    value = (1 - cotangent) / (4 * far)
    by_z = (cotangent + over * over - 2) / (8 * far * far)
    return _joined(precision, z, (_cotangent_rest, _cotangent_rest_slope), (value, by_z))


def _beyond_half_a_turn(z: Any) -> Any:
    return ca.fmax(z, _QUARTER_TURN_SQUARED)


def _joined(precision: Precision, z: Any, functions: tuple[Any, Any], beyond: Dual) -> Dual:
    near = ca.fmin(z, _QUARTER_TURN_SQUARED)
    joined = [
        select(z < _QUARTER_TURN_SQUARED, polynomial(precision, f, _FITTED_UP_TO, near), far)
        for f, far in zip(functions, beyond, strict=True)
    ]
    return joined[0], joined[1]


def _sine_rest(z: Any) -> Any:
    with mp.extradps(40):
        angle = 2 * mp.sqrt(z)
        return (angle - mp.sin(angle)) / angle**3


def _sine_rest_slope(z: Any) -> Any:
    with mp.extradps(60):
        angle = 2 * mp.sqrt(z)
        return 2 * (3 * mp.sin(angle) / angle - 2 - mp.cos(angle)) / angle**4


def _cotangent_rest(z: Any) -> Any:
    with mp.extradps(40):
        half = mp.sqrt(z)
        return (1 - half * mp.cot(half)) / (4 * z)


def _cotangent_rest_slope(z: Any) -> Any:
    with mp.extradps(60):
        half = mp.sqrt(z)
        return (half * mp.cot(half) + (half / mp.sin(half)) ** 2 - 2) / (8 * z**2)
