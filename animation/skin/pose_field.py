"""Mesh poses between control motors: every vertex moves by its own blend of their logarithms.

Motors at a few control points say how the mesh moves there; in between, the weighted sum of their
logarithms says it. There is no skeleton. Near the points a mesh turns and shifts rigidly, between
them it bends and twists along screws.
Source: Wareham and Lasenby, "Mesh vertex pose and position interpolation using geometric algebra"
(2008); weights after Shepard (1968). Logarithms are taken the short way, so motors that differ by
close to half a turn must not stand side by side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive, frozen


@dataclass(frozen=True, eq=False)
class PoseField:
    """Motors at control points, and the motion of everything between them.

    Args:
        points_m: ``(K, 3)`` control points on the mesh at rest, all different.
        motors: Motor ``(K,)``, what happens to the mesh there.
        sharpness: power of the inverse distance by which a point counts; 2 is smooth, more keeps
            the surroundings of each point stiffer.

    Raises:
        ValueError: shapes that do not fit, points at one place, a sharpness that is not positive.

    >>> import numpy as np
    >>> from motorcade.animation.skin import PoseField
    >>> from motorcade.ga import Motor
    >>> ends = np.array([[0, 0, 0], [1.0, 0, 0]])
    >>> lift = PoseField(ends, Motor.from_translation([[0, 0, 0], [0, 0, 1.0]]))
    >>> lift.at([0.5, 0, 0]).translation_m + 0.0
    array([0. , 0. , 0.5])
    """

    points_m: FloatArray
    motors: Motor
    sharpness: float = 2.0

    def __post_init__(self) -> None:
        points = checked_floats(self.points_m, "PoseField.points_m", (3,))
        if points.ndim != 2 or self.motors.shape != (len(points),) or not len(points):
            raise ValueError(
                "PoseField: expected K points (K, 3) and K motors (K,), got shapes "
                f"{points.shape} and {self.motors.shape}"
            )
        if len(np.unique(points, axis=0)) != len(points):
            raise ValueError("PoseField.points_m: expected points that all differ")
        checked_positive(self.sharpness, "PoseField.sharpness")
        object.__setattr__(self, "points_m", frozen(points))

    def weights(self, points_m: ArrayLike) -> FloatArray:
        """Shares ``(*, K)`` of the control points at points ``(*, 3)``; they sum to one."""
        at = checked_floats(points_m, "PoseField.weights(points_m)", (3,))
        apart = np.linalg.norm(at[..., None, :] - self.points_m, axis=-1)
        nearest = np.min(apart, axis=-1, keepdims=True)
        # Divided by the nearest first: no power overflows, and at a point itself it alone counts.
        ratio = np.where(nearest > 0.0, nearest / np.where(apart > 0.0, apart, 1.0), apart == 0.0)
        share = ratio**self.sharpness
        total: FloatArray = share / np.sum(share, axis=-1, keepdims=True)
        return total

    def at(self, points_m: ArrayLike, fraction: ArrayLike = 1.0) -> Motor:
        """Motors ``(*)`` at points ``(*, 3)``, a share of the way from rest: 0 nothing, 1 all."""
        part = checked_floats(fraction, "PoseField.at(fraction)", ())
        logs = self.weights(points_m) @ self.motors.log()
        return Motor.exp(part[..., None] * logs)

    def deform(
        self, vertices_m: ArrayLike, normals: ArrayLike, fraction: ArrayLike = 1.0
    ) -> tuple[FloatArray, FloatArray]:
        """Vertices and normals ``(V, 3)`` of the deformed mesh.

        Normals turn with their vertex; where the field changes fast they are off by its shear.
        """
        vertices = checked_floats(vertices_m, "PoseField.deform(vertices_m)", (3,))
        directions = checked_floats(normals, "PoseField.deform(normals)", (3,))
        motion = self.at(vertices, fraction)
        return motion.apply(vertices), motion.rotor.apply(directions)
