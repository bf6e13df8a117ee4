"""Arithmetic on Euler angles, as practitioners do it: each angle by itself.

Angles in radians, ``(*, 3)``, in the order of their sequence; `motorcade.ga.versors.euler_angles`
converts them. They are numbers on a line here: 190° and -170° are one rotation, but not one path.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats

__all__ = ["euler_rates_from_body", "interpolate_euler", "nearest_branch"]

# Euler rates are divided by the cosine of the middle angle, kept at least this far from zero.
_LEAST_COSINE = 1e-3


def nearest_branch(angles_rad: ArrayLike, reference_rad: ArrayLike) -> FloatArray:
    """Angles ``(*)`` plus the multiples of 2π that bring each within π of its reference.

    The difference of two angles is wrapped by the reference 0.

    Raises:
        ValueError: NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.classical import nearest_branch
        >>> np.rad2deg(nearest_branch(np.deg2rad([-170.0, 20.0]), np.deg2rad([175.0, 10.0])))
        array([190.,  20.])
    """
    angles = checked_floats(angles_rad, "angles_rad", ())
    reference = checked_floats(reference_rad, "reference_rad", ())
    nearest: FloatArray = angles + 2.0 * np.pi * np.round((reference - angles) / (2.0 * np.pi))
    return nearest


def interpolate_euler(start_rad: ArrayLike, end_rad: ArrayLike, fraction: ArrayLike) -> FloatArray:
    """Each angle by itself, ``(*, 3)``, straight from start to end, without wrapping.

    This is the plain practitioner's version: the path depends on the sequence, its speed is not
    constant, and an angle that has jumped by 2π takes the whole turn back. ``fraction`` has shape
    ``(*)`` and broadcasts.

    Raises:
        ValueError: wrong last dimension, NaN or infinity.

    Examples:
        >>> from motorcade.ga.classical import interpolate_euler
        >>> interpolate_euler([0.0, 0.0, 3.0], [0.0, 0.0, -3.0], 0.5)  # back through 0, not on by π
        array([0., 0., 0.])
    """
    start = checked_floats(start_rad, "start_rad", (3,))
    end = checked_floats(end_rad, "end_rad", (3,))
    steps = checked_floats(fraction, "fraction", ())[..., None]
    between: FloatArray = (1.0 - steps) * start + steps * end
    return between


def euler_rates_from_body(angles_rad: ArrayLike) -> FloatArray:
    """Matrices ``(*, 3, 3)`` from angular rates in the moving frame to rates of x-y′-z″ angles.

    At gimbal lock they do not exist; the cosine of the middle angle is kept 0.001 away from 0.

    Raises:
        ValueError: wrong last dimension, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.classical import euler_rates_from_body
        >>> np.round(euler_rates_from_body([0.0, np.pi / 3, 0.0]) @ [1.0, 0.0, 0.0], 3)
        array([ 2.   ,  0.   , -1.732])
    """
    _, middle, last = np.moveaxis(checked_floats(angles_rad, "angles_rad", (3,)), -1, 0)
    cosine = np.copysign(np.maximum(np.abs(np.cos(middle)), _LEAST_COSINE), np.cos(middle))
    tangent = np.sin(middle) / cosine
    sin, cos, zero = np.sin(last), np.cos(last), np.zeros_like(last)
    rows = [
        [cos / cosine, -sin / cosine, zero],
        [sin, cos, zero],
        [-cos * tangent, sin * tangent, zero + 1.0],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
