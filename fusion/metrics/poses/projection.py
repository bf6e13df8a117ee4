"""Poses projected to a plane of their world, as evo does it."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

Plane = Literal["xy", "xz", "yz"]

_NORMAL: dict[Plane, int] = {"xy": 2, "xz": 1, "yz": 0}


def projected(poses: Motor, plane: Plane) -> Motor:
    """Poses ``(*)`` in a plane: positions without their part along its normal, turns about it.

    The turn is evo's: the Euler angle about the normal, of angles about the fixed axes x, y and z
    in that order. About z it is the heading of the moving frame's x axis, in (-π, π]. About y it
    lies within ±π/2, so that a frame that turns farther seems to turn back; `folded` says where.

    Raises:
        ValueError: another plane.

    Examples:
        >>> from motorcade.fusion.metrics import projected
        >>> from motorcade.ga import Motor
        >>> pose = Motor.from_euler_translation([0.0, 0.0, 0.5], [1.0, 2.0, 3.0])
        >>> flat = projected(pose, "xy")
        >>> flat.translation_m + 0.0, flat.rotor.as_rotation_vector().round(6) + 0.0
        (array([1., 2., 0.]), array([0. , 0. , 0.5]))
    """
    if plane not in get_args(Plane):
        raise ValueError(f"plane: expected one of {', '.join(get_args(Plane))}, got {plane!r}")
    normal = _NORMAL[plane]
    vector = np.zeros((*poses.shape, 3))
    vector[..., normal] = _euler_angle(poses.rotor.as_matrix(), normal)
    positions = np.array(poses.translation_m)
    positions[..., normal] = 0.0
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(vector), positions)


def folded(poses: Motor, plane: Plane) -> NDArray[np.bool_]:
    """Which poses ``(*)`` face backwards in the plane xz, where the projected turn is folded.

    Examples:
        >>> from motorcade.fusion.metrics import folded
        >>> from motorcade.ga import Motor, Rotor
        >>> turn = Rotor.from_rotation_vector([[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]])
        >>> folded(Motor.from_rotor_translation(turn, [0.0, 0.0, 0.0]), "xz")
        array([False,  True])
    """
    matrix = poses.rotor.as_matrix()
    backwards = (matrix[..., 0, 0] < 0.0) & (matrix[..., 2, 2] < 0.0)
    return np.asarray(backwards & (plane == "xz"), dtype=np.bool_)


def _euler_angle(matrix: FloatArray, axis: int) -> FloatArray:
    cosine = np.hypot(matrix[..., 0, 0], matrix[..., 1, 0])
    if axis == 1:
        middle: FloatArray = np.arctan2(-matrix[..., 2, 0], cosine)
        return middle
    # Where the middle angle is a right one only the sum of the others is known: it goes to x.
    locked = cosine <= 4.0 * np.finfo(np.float64).eps
    if axis == 0:
        free = np.arctan2(matrix[..., 2, 1], matrix[..., 2, 2])
        first: FloatArray = np.where(
            locked, np.arctan2(-matrix[..., 1, 2], matrix[..., 1, 1]), free
        )
        return first
    last: FloatArray = np.where(locked, 0.0, np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0]))
    return last
