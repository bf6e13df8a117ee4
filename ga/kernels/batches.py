"""The kernels on arrays ``(*, n)`` whose batches broadcast; results are new arrays.

Inputs are float32 or float64, all of one kind, and are read where they lie. Results of sixteen
rows and more are views ``(*, n)`` onto storage that holds one component after the other, so that
the next kernel reads them without copying; smaller ones are in C order.
"""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.kernels.backend import function

__all__ = [
    "apply", "blend", "blend_many", "blend_many_matrix", "blend_matrix", "compose",
    "dual_quaternion", "exp", "interpolate", "inverse", "log", "matrix34", "matrix44", "normalize",
    "rotor_compose", "rotor_exp", "rotor_interpolate", "rotor_inverse", "rotor_log", "screw_blend",
    "screw_blend_matrix",
]  # fmt: skip

_BLOCK = 16

# float32 or float64, one kind throughout a call.
Array = NDArray[Any]

_compose, _inverse, _apply = function("compose"), function("inverse"), function("apply")
_exp, _log, _log_long = function("exp"), function("log"), function("log_long")
_interpolate, _interpolate_long = function("interpolate"), function("interpolate_long")
_blend, _blend_matrix = function("blend"), function("blend_matrix")
_screw_blend, _screw_blend_matrix = function("screw_blend"), function("screw_blend_matrix")
_accumulate = function("accumulate")
_normalize, _normalize_matrix = function("normalize"), function("normalize_matrix")
_matrix34, _matrix44 = function("matrix34"), function("matrix44")
_dual_quaternion = function("dual_quaternion")
_rotor_compose, _rotor_inverse = function("rotor_compose"), function("rotor_inverse")
_rotor_exp, _rotor_log = function("rotor_exp"), function("rotor_log")
_rotor_log_long, _rotor_interpolate = function("rotor_log_long"), function("rotor_interpolate")
_rotor_interpolate_long = function("rotor_interpolate_long")


def empty(shape: tuple[int, ...], width: int, dtype: np.dtype[Any]) -> Array:
    """An array ``(*shape, width)`` for a kernel to write into, see the top of this module."""
    count = prod(shape)
    if count < _BLOCK:
        return np.empty((*shape, width), dtype)
    rows = np.empty((width, -(-count // _BLOCK) * _BLOCK), dtype)[:, :count]
    if len(shape) == 1:
        return rows.T
    return np.moveaxis(rows.reshape(width, *shape), 0, -1)


def _spread(array: Array, shape: tuple[int, ...], trailing: int) -> Array:
    """The batch `shape` of an array whose rows a kernel can step through, or one row for all."""
    batch = array.shape[: array.ndim - trailing]
    if batch == shape and (len(shape) < 2 or array.flags.c_contiguous):
        return array
    rest = array.shape[array.ndim - trailing :]
    if prod(batch) == 1:
        return array.reshape(rest)
    spread = np.broadcast_to(array, (*shape, *rest))
    return spread if len(shape) < 2 else _rows(spread, shape, rest)


def _rows(array: Array, shape: tuple[int, ...], rest: tuple[int, ...]) -> Array:
    """Several batch dimensions as one, without a copy where the memory allows it."""
    return array.reshape(prod(shape), *rest)


def of_one(kernel: Callable[..., None], given: Array, width: int) -> Array:
    """Apply a kernel of one input ``(*, n)``."""
    shape = given.shape[:-1]
    made = empty(shape, width, given.dtype)
    kernel(_spread(given, shape, 1), made)
    return made


def of_two(kernel: Callable[..., None], a: Array, b: Array, width: int) -> Array:
    """Apply a kernel of two inputs ``(*, n)`` whose batches broadcast."""
    shape = a.shape[:-1]
    if b.shape[:-1] != shape:
        shape = np.broadcast_shapes(shape, b.shape[:-1])
    made = empty(shape, width, a.dtype)
    kernel(_spread(a, shape, 1), _spread(b, shape, 1), made)
    return made


def of_fraction(
    kernel: Callable[..., None], a: Array, b: Array, fraction: Array | float, width: int
) -> Array:
    """Apply a kernel of two inputs ``(*, n)`` and a fraction ``(*)``."""
    shape = a.shape[:-1]
    if b.shape[:-1] != shape:
        shape = np.broadcast_shapes(shape, b.shape[:-1])
    if not isinstance(fraction, float):
        if fraction.shape == ():
            fraction = float(fraction)
        elif fraction.shape != shape:
            shape = np.broadcast_shapes(shape, fraction.shape)
    made = empty(shape, width, a.dtype)
    part = fraction if isinstance(fraction, float) else _spread(fraction, shape, 0)
    kernel(_spread(a, shape, 1), _spread(b, shape, 1), part, made)
    return made


def compose(a: Array, b: Array) -> Array:
    """Geometric product ``a b`` of motors, ``(*, 8)``."""
    return of_two(_compose, a, b, 8)


def inverse(m: Array) -> Array:
    """Reverse of motors, ``(*, 8)``: the inverse where they are unit."""
    return of_one(_inverse, m, 8)


def apply(m: Array, points: Array) -> Array:
    """Points ``(*, 3)`` moved by motors ``(*, 8)``."""
    return of_two(_apply, m, points, 3)


def exp(log: Array) -> Array:
    """Motors ``(*, 8)`` from bivectors ``(*, 6)`` on ``e23, e31, e12, e1∞, e2∞, e3∞``.

    Of half angles up to 2e8 (float64) or 6e3 (float32) nothing is lost beyond their own rounding.
    """
    return of_one(_exp, log, 8)


def log(m: Array, short_way: bool = True) -> Array:
    """Bivectors ``(*, 6)`` of unit motors ``(*, 8)``.

    With ``short_way`` the sign is flipped first where ``m0 < 0``, so half the rotation angle is at
    most π/2; without, it runs up to π, where the axis is lost.
    """
    return of_one(_log if short_way else _log_long, m, 6)


def interpolate(a: Array, b: Array, fraction: Array | float, short_way: bool = True) -> Array:
    """Screw interpolation ``a exp(fraction log(~a b))``; ``fraction`` is any number."""
    return of_fraction(_interpolate if short_way else _interpolate_long, a, b, fraction, 8)


def blend(a: Array, b: Array, fraction: Array | float) -> Array:
    """Linear blend of motors the short way round, projected to motors ``(*, 8)``."""
    return of_fraction(_blend, a, b, fraction, 8)


def blend_matrix(a: Array, b: Array, fraction: Array | float) -> Array:
    """`blend` as matrices ``(*, 3, 4)``."""
    return matrices(of_fraction(_blend_matrix, a, b, fraction, 12), 3)


def screw_blend(a: Array, b: Array, fraction: Array | float) -> Array:
    """`interpolate` for fractions in [0, 1], faster; outside it loses accuracy."""
    return of_fraction(_screw_blend, a, b, fraction, 8)


def screw_blend_matrix(a: Array, b: Array, fraction: Array | float) -> Array:
    """`screw_blend` as matrices ``(*, 3, 4)``."""
    return matrices(of_fraction(_screw_blend_matrix, a, b, fraction, 12), 3)


def blend_many(motors: Array, weights: Array) -> Array:
    """Linear blend of ``K`` motors ``(K, *, 8)`` with weights ``(K)`` or ``(K, *)``: ``(*, 8)``.

    Signs follow the first motor, the pivot. Weights need not add up to 1; where everything
    cancels there is no blend and the result is not finite.
    """
    return of_one(_normalize, _accumulated(motors, weights), 8)


def blend_many_matrix(motors: Array, weights: Array) -> Array:
    """`blend_many` as matrices ``(*, 3, 4)``."""
    return matrices(of_one(_normalize_matrix, _accumulated(motors, weights), 12), 3)


def _accumulated(motors: Array, weights: Array) -> Array:
    shape = motors.shape[1:-1]
    total = np.zeros(8, motors.dtype)
    other = empty(shape, 8, motors.dtype)
    spare = empty(shape, 8, motors.dtype)
    pivot = _spread(motors[0], shape, 1)
    for one, weight in zip(motors, weights, strict=True):
        part = float(weight) if weight.shape == () else _spread(weight, shape, 0)
        _accumulate(total, pivot, _spread(one, shape, 1), part, other)
        total, other, spare = other, spare, other
    return total


def normalize(m: Array) -> Array:
    """The motors nearest to even elements ``(*, 8)``, which must not have a zero rotor part."""
    return of_one(_normalize, m, 8)


def matrix34(m: Array) -> Array:
    """Matrices ``(*, 3, 4)`` of motors."""
    return matrices(of_one(_matrix34, m, 12), 3)


def matrix44(m: Array) -> Array:
    """Homogeneous matrices ``(*, 4, 4)`` of motors."""
    return matrices(of_one(_matrix44, m, 16), 4)


def matrices(rows: Array, height: int) -> Array:
    return rows.reshape(*rows.shape[:-1], height, 4)


def dual_quaternion(m: Array) -> Array:
    """Hamilton dual quaternions ``(*, 8)``, real wxyz then dual wxyz."""
    return of_one(_dual_quaternion, m, 8)


def rotor_compose(a: Array, b: Array) -> Array:
    """Geometric product ``a b`` of rotors, ``(*, 4)``."""
    return of_two(_rotor_compose, a, b, 4)


def rotor_inverse(r: Array) -> Array:
    """Reverse of rotors, ``(*, 4)``: the inverse where they are unit."""
    return of_one(_rotor_inverse, r, 4)


def rotor_exp(log: Array) -> Array:
    """Rotors ``(*, 4)`` from bivectors ``(*, 3)`` on ``e23, e31, e12``."""
    return of_one(_rotor_exp, log, 4)


def rotor_log(r: Array, short_way: bool = True) -> Array:
    """Bivectors ``(*, 3)`` of unit rotors ``(*, 4)``; the sign rule of `log`."""
    return of_one(_rotor_log if short_way else _rotor_log_long, r, 3)


def rotor_interpolate(a: Array, b: Array, fraction: Array | float, short_way: bool = True) -> Array:
    """Great-circle interpolation ``a exp(fraction log(~a b))``."""
    return of_fraction(
        _rotor_interpolate if short_way else _rotor_interpolate_long, a, b, fraction, 4
    )
