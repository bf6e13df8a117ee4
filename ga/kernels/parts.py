"""Versors from their parts and back, through kernels that check what they are given.

What is made comes with how far off the input is, NaN where a number of it is not finite: the
largest over a batch, and no less than the distance of its norm from 1, of ``|R^T R - 1|``, or a
tenth of what a last row is off from ``0 0 0 1``. Inputs of one call have one precision.
"""

from __future__ import annotations

from collections.abc import Callable
from math import nan

import numpy as np

from motorcade.ga.kernels.backend import checked_function, function
from motorcade.ga.kernels.batches import Array, checked_call, of_one, of_two

_translation, _motor_scale = function("translation"), function("motor_scale")
_matrix33 = function("rotor_matrix33")
_tait_bryan, _proper_euler = function("rotor_tait_bryan"), function("rotor_proper_euler")
_of_euler, _motor_of_euler = checked_function("rotor_of_euler"), checked_function("motor_of_euler")
_motor_of, _similarity_of = checked_function("motor_of"), checked_function("similarity_of")
_similarity_of_motor = checked_function("similarity_of_motor")
_of_quaternion = checked_function("rotor_of_quaternion")
_of_matrix33 = checked_function("rotor_of_matrix33")
_motor_of_quaternion = checked_function("motor_of_quaternion")
_motor_of_matrix44 = checked_function("motor_of_matrix44")
_of_dual_quaternion = checked_function("motor_of_dual_quaternion")
_similarity_of_matrix44 = checked_function("similarity_of_matrix44")
_rotor_normalize, _project = checked_function("rotor_normalize"), checked_function("project")


def _with_off(kernel: Callable[..., bool], width: int, *inputs: Array) -> tuple[Array, float]:
    results, finite = checked_call(kernel, width + 1, *inputs)
    if not finite:
        return results[..., :width], nan
    if results.ndim == 1:
        return results[:width], results.item(width)
    return results[..., :width], float(np.max(results[..., width], initial=0.0))


def _rows(matrix: Array) -> Array:
    return matrix.reshape(*matrix.shape[:-2], matrix.shape[-1] ** 2)


def rotor_of_quaternion(wxyz: Array) -> tuple[Array, float]:
    """Rotors ``(*, 4)`` of unit quaternions, and how far off these are."""
    return _with_off(_of_quaternion, 4, wxyz)


def rotor_of_matrix(matrix: Array) -> tuple[Array, float]:
    """Rotors ``(*, 4)`` of rotation matrices ``(*, 3, 3)``, and how far off these are."""
    return _with_off(_of_matrix33, 4, _rows(matrix))


def rotor_matrix(r: Array) -> Array:
    """Matrices ``(*, 3, 3)`` of rotors."""
    rows = of_one(_matrix33, r, 9)
    return rows.reshape(*rows.shape[:-1], 3, 3)


def rotor_of_euler(angles: Array, axes: Array) -> tuple[Array, bool]:
    """Rotors of intrinsic angles ``(*, 3)`` about three axes ``(9,)``; whether all are finite."""
    return checked_call(_of_euler, 4, angles, axes)


def motor_of_euler(angles: Array, axes: Array, t: Array) -> tuple[Array, bool]:
    """Motors that turn by such angles, then move by ``(*, 3)``; whether all given is finite."""
    return checked_call(_motor_of_euler, 8, angles, axes, t)


def euler_of_rotor(r: Array, sequence: Array, proper: bool) -> Array:
    """Angles ``(*, 3)`` of rotors for a sequence ``(10,)``: axes i, j, k and their handedness.

    With `proper` the sequence is i, j, i, otherwise i, j, k.
    """
    return of_two(_proper_euler if proper else _tait_bryan, r, sequence, 3)


def translation(m: Array) -> Array:
    """Where motors take the origin, ``(*, 3)``."""
    return of_one(_translation, m, 3)


def motor_of(r: Array, t: Array) -> tuple[Array, bool]:
    """Motors that turn by rotors, then move by ``(*, 3)``; and whether all given is finite."""
    return checked_call(_motor_of, 8, r, t)


def motor_of_quaternion(wxyz: Array, t: Array) -> tuple[Array, float]:
    """Motors that turn by unit quaternions, then move by ``(*, 3)``; how far off the former are."""
    return _with_off(_motor_of_quaternion, 8, wxyz, t)


def motor_of_matrix(matrix: Array) -> tuple[Array, float]:
    """Motors of homogeneous matrices ``(*, 4, 4)``, and how far off these are."""
    return _with_off(_motor_of_matrix44, 8, _rows(matrix))


def motor_of_dual_quaternion(d: Array) -> tuple[Array, float]:
    """Motors of unit dual quaternions ``(*, 8)``, and how far off these are."""
    return _with_off(_of_dual_quaternion, 8, d)


def similarity_of(r: Array, t: Array, scale: Array) -> tuple[Array, bool]:
    """Similarities of rotors, translations and scales ``(*)``; whether all given is finite."""
    return checked_call(_similarity_of, 12, r, t, scale[..., None])


def similarity_of_motor(m: Array, scale: Array) -> tuple[Array, bool]:
    """Similarities of motors and scales ``(*)``; whether all given is finite."""
    return checked_call(_similarity_of_motor, 12, m, scale[..., None])


def similarity_of_matrix(matrix: Array) -> tuple[Array, float]:
    """Similarities of homogeneous matrices ``(*, 4, 4)``, and how far off these are."""
    return _with_off(_similarity_of_matrix44, 12, _rows(matrix))


def motor_scale(s: Array) -> tuple[Array, Array]:
    """Rigid motions ``(*, 8)`` and scales ``(*)`` of similarities."""
    results = of_one(_motor_scale, s, 9)
    return results[..., :8], results[..., 8]


def normalized_rotor(r: Array) -> tuple[Array, float]:
    """The nearest rotors, and their smallest size before that: NaN where not all are finite."""
    return _with_least(_rotor_normalize, 4, r)


def normalized_motor(m: Array) -> tuple[Array, float]:
    """The nearest motors, and their rotors' smallest size before that."""
    return _with_least(_project, 8, m)


def _with_least(kernel: Callable[..., bool], width: int, array: Array) -> tuple[Array, float]:
    results, finite = checked_call(kernel, width + 1, array)
    if not finite:
        return results[..., :width], nan
    return results[..., :width], float(np.min(results[..., width], initial=np.inf))
