"""The kernels of similarities on arrays ``(*, n)``, as `batches` has those of motors.

Coefficients ``(*, 12)`` stand on ``1, e23, e31, e12, E, e23E, e31E, e12E, e1∞, e2∞, e3∞, e123∞``
with ``E = e0∧e∞``. A scale ``ρ`` leaves the difference of the first two quadruples with a relative
error of ``max(ρ, 1/ρ)`` roundings, so scales are meant to lie in 1e-12 … 1e12 (float64) or
1e-5 … 1e5 (float32).
"""

from __future__ import annotations

from typing import Any

from motorcade.ga.kernels.backend import function
from motorcade.ga.kernels.batches import Array, matrices, of_fraction, of_one, of_two

__all__ = [
    "rotor_translation_scale", "similarity_apply", "similarity_blend", "similarity_compose",
    "similarity_exp", "similarity_interpolate", "similarity_inverse", "similarity_log",
    "similarity_matrix34", "similarity_matrix44", "similarity_normalize", "similarity_of_motor",
]  # fmt: skip

_compose, _inverse = function("similarity_compose"), function("similarity_inverse")
_apply, _exp, _log = (function(f"similarity_{name}") for name in ("apply", "exp", "log"))
_log_long = function("similarity_log_long")
_interpolate = function("similarity_interpolate")
_interpolate_long = function("similarity_interpolate_long")
_normalize, _blend = function("similarity_normalize"), function("similarity_blend")
_matrix34, _matrix44 = function("similarity_matrix34"), function("similarity_matrix44")
_parts, _of_motor = function("rotor_translation_scale"), function("similarity_of_motor")


def similarity_compose(a: Array, b: Array) -> Array:
    """Geometric product ``a b`` of similarities, ``(*, 12)``."""
    return of_two(_compose, a, b, 12)


def similarity_inverse(m: Array) -> Array:
    """Reverse of similarities, ``(*, 12)``: the inverse where they are unit."""
    return of_one(_inverse, m, 12)


def similarity_apply(m: Array, points: Array) -> Array:
    """Points ``(*, 3)`` moved by similarities ``(*, 12)``."""
    return of_two(_apply, m, points, 3)


def similarity_exp(log: Array) -> Array:
    """Similarities ``(*, 12)`` from bivectors ``(*, 7)`` on ``e23, e31, e12, E, e1∞, e2∞, e3∞``.

    Angles as for `exp`; where ``e^|E|`` is too large, the result is not finite.
    """
    return of_one(_exp, log, 12)


def similarity_log(m: Array, short_way: bool = True) -> Array:
    """Bivectors ``(*, 7)`` of unit similarities ``(*, 12)``; the sign rule of `log`."""
    return of_one(_log if short_way else _log_long, m, 7)


def similarity_interpolate(
    a: Array, b: Array, fraction: Array | float, short_way: bool = True
) -> Array:
    """Spirals ``a exp(fraction log(~a b))``; ``fraction`` is any number."""
    return of_fraction(_interpolate if short_way else _interpolate_long, a, b, fraction, 12)


def similarity_blend(a: Array, b: Array, fraction: Array | float) -> Array:
    """Linear blend of similarities the short way round, projected to similarities ``(*, 12)``.

    Where both cancel there is no blend and the result is no similarity.
    """
    return of_fraction(_blend, a, b, fraction, 12)


def similarity_normalize(m: Array) -> tuple[Array, Array]:
    """The similarities nearest to even elements ``(*, 12)``, and how well defined they are ``(*)``.

    The second is 1 for a versor and 0 for an element that has no scale or is turned inside out;
    there the first means nothing.
    """
    made = of_one(_normalize, m, 13)
    return made[..., :12], made[..., 12]


def similarity_matrix34(m: Array) -> Array:
    """Matrices ``(*, 3, 4)`` of similarities."""
    return matrices(of_one(_matrix34, m, 12), 3)


def similarity_matrix44(m: Array) -> Array:
    """Homogeneous matrices ``(*, 4, 4)`` of similarities."""
    return matrices(of_one(_matrix44, m, 16), 4)


def rotor_translation_scale(m: Array) -> tuple[Array, Array, Array]:
    """Rotors ``(*, 4)``, translations ``(*, 3)`` and scales ``(*)`` of similarities."""
    made: Any = of_one(_parts, m, 8)
    return made[..., :4], made[..., 4:7], made[..., 7]


def similarity_of_motor(m: Array, scale: Array) -> Array:
    """Similarities ``(*, 12)`` that grow by ``scale (*)`` and then move by motors ``(*, 8)``."""
    return of_two(_of_motor, m, scale[..., None], 12)
