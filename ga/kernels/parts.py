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


def _plain(name: str, width: int) -> Callable[..., tuple[Array, bool]]:
    """Results ``(*, width)``, and whether all given is finite."""
    kernel = checked_function(name)
    return lambda *inputs: checked_call(kernel, width, *inputs)


def _measured(name: str, width: int, least: bool = False) -> Callable[..., tuple[Array, float]]:
    """Results, and the largest or least of the numbers that follow them."""
    kernel = checked_function(name)

    def convert(*inputs: Array) -> tuple[Array, float]:
        results, finite = checked_call(kernel, width + 1, *inputs)
        follow = results[..., width]
        bound = np.min(follow, initial=np.inf) if least else np.max(follow, initial=0.0)
        return results[..., :width], float(bound) if finite else nan

    return convert


def _of_square(
    convert: Callable[..., tuple[Array, float]],
) -> Callable[[Array], tuple[Array, float]]:
    """The same of matrices ``(*, n, n)``."""
    return lambda matrix: convert(matrix.reshape(*matrix.shape[:-2], matrix.shape[-1] ** 2))


# Of unit quaternions (*, 4) and dual quaternions (*, 8), of rotation matrices (*, 3, 3) and of
# homogeneous ones (*, 4, 4): how far off these are.
rotor_of_quaternion = _measured("rotor_of_quaternion", 4)
rotor_of_matrix = _of_square(_measured("rotor_of_matrix33", 4))
motor_of_quaternion = _measured("motor_of_quaternion", 8)  # and translations (*, 3)
motor_of_matrix = _of_square(_measured("motor_of_matrix44", 8))
motor_of_dual_quaternion = _measured("motor_of_dual_quaternion", 8)
similarity_of_matrix = _of_square(_measured("similarity_of_matrix44", 12))
# The nearest versors of even elements, and the smallest size of their rotors before that.
normalized_rotor = _measured("rotor_normalize", 4, least=True)
normalized_motor = _measured("project", 8, least=True)
# Of angles (*, 3) about three axes (9,); of translations (*, 3), angles or rotors first; of scales
# (*, 1), which come last.
rotor_of_euler, motor_of_euler = _plain("rotor_of_euler", 4), _plain("motor_of_euler", 8)
motor_of_translation, motor_of = _plain("of_translation", 8), _plain("motor_of", 8)
similarity_of, similarity_of_motor = _plain("similarity_of", 12), _plain("similarity_of_motor", 12)


def rotor_matrix(r: Array) -> Array:
    """Matrices ``(*, 3, 3)`` of rotors."""
    rows = of_one(_matrix33, r, 9)
    return rows.reshape(*rows.shape[:-1], 3, 3)


def euler_of_rotor(r: Array, sequence: Array, proper: bool) -> Array:
    """Angles ``(*, 3)`` of rotors for a sequence ``(10,)``: axes i, j, k and their handedness.

    With `proper` the sequence is i, j, i, otherwise i, j, k.
    """
    return of_two(_proper_euler if proper else _tait_bryan, r, sequence, 3)


def translation(m: Array) -> Array:
    """Where motors take the origin, ``(*, 3)``."""
    return of_one(_translation, m, 3)


def motor_scale(s: Array) -> tuple[Array, Array]:
    """Rigid motions ``(*, 8)`` and scales ``(*)`` of similarities."""
    results = of_one(_motor_scale, s, 9)
    return results[..., :8], results[..., 8]
