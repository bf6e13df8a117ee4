"""Vectors of three coordinates: lengths, least turns, turns about an axis, frames, boxes."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, frozen

UP = frozen(np.array([0.0, 0.0, 1.0]))
"""Of characters and worlds."""

# All turns that take the axes to axes.
_QUARTERS = Rotor.from_matrix(
    np.array(
        [
            m
            for order in permutations(range(3))
            for signs in product((1.0, -1.0), repeat=3)
            if np.linalg.det(m := np.eye(3)[list(order)] * signs) > 0.0
        ]
    )
)


def length(vectors: FloatArray) -> FloatArray:
    """Lengths ``(*, 1)`` of vectors ``(*, 3)``."""
    return np.asarray(np.linalg.norm(vectors, axis=-1, keepdims=True), dtype=np.float64)


def unit(vectors: FloatArray, otherwise: ArrayLike = 0.0) -> FloatArray:
    """Vectors ``(*, 3)`` of length 1; where one has no length, another in its place."""
    size = length(vectors)
    return np.where(size > 0.0, vectors / np.where(size > 0.0, size, 1.0), otherwise)


def perpendicular(vectors: FloatArray) -> FloatArray:
    """Some unit vector ``(*, 3)`` at right angles to each of vectors ``(*, 3)``."""
    steep = np.abs(vectors[..., 2:]) > 0.9 * length(vectors)
    return unit(np.cross(np.where(steep, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]), vectors))


def shortest_turn(start: FloatArray, end: FloatArray) -> Rotor:
    """The least rotors ``(*)`` that turn vectors ``(*, 3)`` along others, of any lengths.

    Of vectors of no length, none; of opposite ones, half a turn about some axis across.

    >>> import numpy as np
    >>> from motorcade.animation.vectors import shortest_turn
    >>> shortest_turn(np.array([2.0, 0, 0]), np.array([0, 3.0, 0])).as_rotation_vector()
    array([0.        , 0.        , 1.57079633])
    """
    axis = np.cross(start, end)
    angle = np.arctan2(length(axis), np.sum(start * end, axis=-1, keepdims=True))
    return Rotor.from_rotation_vector(angle * unit(axis, perpendicular(start)))


def axes_along(ahead: FloatArray, towards: FloatArray) -> Rotor:
    """The rotors ``(*)`` to axes with x along one vector ``(*, 3)`` and y as near to another."""
    x = unit(ahead)
    z = unit(np.cross(x, towards))
    return Rotor.from_matrix(np.stack([x, np.cross(z, x), z], axis=-1))


def along_axes(rotor: Rotor) -> Rotor:
    """The nearest turn that takes the axes to axes."""
    return _QUARTERS[int(np.argmin((_QUARTERS.inverse() @ rotor).angle()))]


def turn_x(angle_rad: ArrayLike) -> Rotor:
    """Rotors about x by angles (*)."""
    return _turn(angle_rad, 0)


def turn_y(angle_rad: ArrayLike) -> Rotor:
    """Rotors about y by angles (*)."""
    return _turn(angle_rad, 1)


def turn_z(angle_rad: ArrayLike) -> Rotor:
    """Rotors about z by angles (*)."""
    return _turn(angle_rad, 2)


def _turn(angle_rad: ArrayLike, axis: int) -> Rotor:
    angle = np.asarray(angle_rad, dtype=np.float64)
    vector = np.zeros((*angle.shape, 3))
    vector[..., axis] = angle
    return Rotor.from_rotation_vector(vector)


def wrapped(angle_rad: ArrayLike) -> FloatArray:
    """The same angles ``(*)`` from −π to π."""
    return np.asarray((np.asarray(angle_rad) + np.pi) % (2.0 * np.pi) - np.pi)


def box_corners(points: FloatArray) -> FloatArray:
    """The eight corners ``(8, 3)`` of the box along the axes about points ``(N, 3)``, N above 0."""
    ends = np.stack([points.min(axis=0), points.max(axis=0)])
    return np.array([ends[which, range(3)] for which in np.ndindex(2, 2, 2)])
