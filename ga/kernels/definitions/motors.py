"""Motors and rotors: exponential and logarithm, and how twists act.

A twist is ``-2 log``: rotation vector (rad), then translational part (m). On a bivector ``Y`` the
adjoint is ``M Y ~M`` and the left Jacobian of exp at ``X`` is ``Y + b [X, Y] + d [X, [X, Y]]`` with
the coefficients of `jacobian_series`, dual numbers ``b + b' e123∞`` on motors. Both are linear, so
that they are the same on twists. The right Jacobian is the left one at ``-X``. Rotors are motors
without the part that moves.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from motorcade.ga.algebra import Multivector
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions import elements as on
from motorcade.ga.kernels.definitions.functions import (
    Dual,
    angle_over_sine,
    angle_over_sine_beyond,
    cosine_sinc,
    select,
)
from motorcade.ga.kernels.definitions.jacobian_series import (
    forward_series,
    half_turn,
    inverse_series,
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


def _scaled(factor: float, given: Numbers) -> Numbers:
    return [factor * value for value in given]


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
