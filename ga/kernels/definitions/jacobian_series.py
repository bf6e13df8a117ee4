"""Coefficients of the Jacobians of exp, as functions of ``z = (θ / 2)²`` for any angle ``θ``.

With ``ad`` the commutator with a twist that turns by ``θ``, ``ad³ = -θ² ad`` on rotations, so that

    ``Σ adⁿ / (n + 1)!   = 1 + b ad + d ad²``,  ``b = (1 - cos θ) / θ²``, ``d = (θ - sin θ) / θ³``,
    ``Σ Bₙ adⁿ / n!      = 1 - ½ ad + c ad²``,  ``c = (1 - ½ θ cot ½ θ) / θ²``,

with the Bernoulli numbers ``Bₙ``. On rigid motions the same holds of dual numbers, for which the
derivatives by ``z`` are here too. Up to half a turn they are polynomials, beyond closed forms, in
which nothing cancels there. The second is singular at full turns.
"""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

import casadi as ca
import mpmath as mp

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.kernels.definitions.functions import Dual, cosine_sinc, polynomial, select

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
    made = [
        select(z < _QUARTER_TURN_SQUARED, polynomial(precision, f, _FITTED_UP_TO, near), far)
        for f, far in zip(functions, beyond, strict=True)
    ]
    return made[0], made[1]


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
