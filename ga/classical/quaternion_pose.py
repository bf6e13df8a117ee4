"""Quaternion beside translation, ``(*, 7)``: w, x, y, z, then metres; what most programs use.

Rotation and translation are interpolated apart: the body's origin goes straight while the body
turns about it, so the path depends on which point of the body is called its origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.classical.pose import (
    UNIT_TOLERANCE,
    Pose,
    checked_method,
    random_pose,
    split_matrix,
)
from motorcade.ga.classical.quaternion import (
    nearest_sign,
    quaternion_apply,
    quaternion_as_rotation_vector,
    quaternion_conjugate,
    quaternion_from_rotation_vector,
    quaternion_multiply,
    quaternion_nlerp,
    quaternion_normalize,
    quaternion_slerp,
)

__all__ = ["QuaternionPose"]


@dataclass(frozen=True, eq=False, repr=False)
class QuaternionPose(Pose):
    """``coefficients (*, 7)``: unit quaternion w, x, y, z and translation x, y, z in metres.

    Examples:
        >>> from motorcade.ga.classical import QuaternionPose
        >>> world_T_camera = QuaternionPose.from_quaternion_translation([0, 0, 0, 1], [1, 0, 0])
        >>> camera_T_imu = QuaternionPose.from_quaternion_translation([1, 0, 0, 0], [0, 0.1, 0])
        >>> (world_T_camera @ camera_T_imu).translation_m
        array([ 1. , -0.1,  0. ])
    """

    _size: ClassVar[int] = 7

    def _check(self, coefficients: FloatArray) -> None:
        norm = np.linalg.norm(coefficients[..., :4], axis=-1)
        worst = float(np.max(np.abs(norm - 1.0), initial=0.0))
        if worst > UNIT_TOLERANCE:
            raise ValueError(
                "QuaternionPose.coefficients: expected unit quaternions (norm within "
                f"{UNIT_TOLERANCE:g} of 1), got a norm off by {worst:.3g}; normalize divides by it"
            )

    @property
    def wxyz(self) -> FloatArray:
        """Unit quaternions ``(*, 4)``."""
        return self.coefficients[..., :4]

    @property
    def translation_m(self) -> FloatArray:
        """Translations ``(*, 3)``: where the body's origin is."""
        return self.coefficients[..., 4:]

    @classmethod
    def identity(cls, shape: tuple[int, ...] = ()) -> QuaternionPose:
        """No motion, repeated over the batch `shape`."""
        return cls(np.broadcast_to(np.eye(7)[0], (*shape, 7)))

    @classmethod
    def random(
        cls, rng: np.random.Generator, shape: tuple[int, ...] = (), extent_m: float = 1.0
    ) -> QuaternionPose:
        """Uniform orientations, normal translations with deviation `extent_m` an axis."""
        return cls.from_quaternion_translation(*random_pose(rng, shape, extent_m))

    @classmethod
    def normalize(cls, coefficients: ArrayLike) -> QuaternionPose:
        """Divide the quaternions of ``(*, 7)`` by their norm; translations stay.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a zero quaternion.
        """
        given = checked_floats(coefficients, "QuaternionPose.normalize(coefficients)", (7,))
        unit = quaternion_normalize(given[..., :4])
        return cls(np.concatenate([unit, given[..., 4:]], axis=-1))

    @classmethod
    def exp(cls, log: ArrayLike) -> QuaternionPose:
        """Poses from rotation vector (rad) and translation (m), ``(*, 6)``, each by itself."""
        given = checked_floats(log, "QuaternionPose.exp(log)", (6,))
        turned = quaternion_from_rotation_vector(given[..., :3])
        return cls(np.concatenate([turned, given[..., 3:]], axis=-1))

    def log(self) -> FloatArray:
        """Rotation vector (rad, at most π long) and translation (m), ``(*, 6)``."""
        turn = quaternion_as_rotation_vector(self.wxyz)
        return np.concatenate([turn, self.translation_m], axis=-1)

    def _compose(self, other: QuaternionPose) -> FloatArray:
        turned = quaternion_multiply(self.wxyz, other.wxyz)
        moved = quaternion_apply(self.wxyz, other.translation_m) + self.translation_m
        return np.concatenate([turned, moved], axis=-1)

    def inverse(self) -> QuaternionPose:
        """The motion undone: ``q*`` and ``-q* t q``."""
        back = quaternion_conjugate(self.wxyz)
        return self._like(
            np.concatenate([back, -quaternion_apply(back, self.translation_m)], axis=-1)
        )

    def apply(self, points: ArrayLike) -> FloatArray:
        """Move points ``(*, 3)`` in metres: ``q x q* + t``."""
        return quaternion_apply(self.wxyz, self._checked_points(points)) + self.translation_m

    def interpolate(
        self,
        other: QuaternionPose,
        fraction: ArrayLike,
        short_way: bool = True,
        *,
        method: str = "slerp",
    ) -> QuaternionPose:
        """Slerp ("slerp") or normalised lerp ("nlerp") of quaternions beside lerp of translations.

        Raises:
            ValueError: an unknown method, NaN or infinite fraction, batches that do not broadcast.
            TypeError: another type of pose.
        """
        steps = self._checked_fraction(other, fraction)
        chosen = checked_method("QuaternionPose.interpolate", method, ("slerp", "nlerp"))
        turn = quaternion_slerp if chosen == "slerp" else quaternion_nlerp
        turned = turn(self.wxyz, other.wxyz, steps, short_way)
        part = steps[..., None]
        moved = (1.0 - part) * self.translation_m + part * other.translation_m
        return self._like(np.concatenate([turned, moved], axis=-1))

    def blend(self, weights: ArrayLike) -> QuaternionPose:
        """Weighted sum over the last batch dimension, ``(*, K)`` to ``(*)``; signs of the first.

        Raises:
            ValueError: weights that do not fit or sum to zero, quaternions that cancel.
        """
        share = self._checked_weights(weights)
        signed = nearest_sign(self.wxyz, self.wxyz[..., :1, :])
        turned = quaternion_normalize(np.sum(share[..., None] * signed, axis=-2))
        parts = share / np.sum(share, axis=-1, keepdims=True)
        moved = np.sum(parts[..., None] * self.translation_m, axis=-2)
        return self._like(np.concatenate([turned, moved], axis=-1))

    @classmethod
    def from_quaternion_translation(
        cls, wxyz: ArrayLike, translation_m: ArrayLike
    ) -> QuaternionPose:
        """Poses from unit quaternions ``(*, 4)`` and translations ``(*, 3)``; batches broadcast."""
        q = checked_floats(wxyz, "QuaternionPose wxyz", (4,))
        t = checked_floats(translation_m, "QuaternionPose translation_m", (3,))
        shape = np.broadcast_shapes(q.shape[:-1], t.shape[:-1])
        return cls(
            np.concatenate(
                [np.broadcast_to(q, (*shape, 4)), np.broadcast_to(t, (*shape, 3))], axis=-1
            )
        )

    def as_quaternion_translation(self) -> tuple[FloatArray, FloatArray]:
        """Unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)`` in metres."""
        return self.wxyz, self.translation_m

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> QuaternionPose:
        """Poses from homogeneous matrices ``(*, 4, 4)``, taken for rigid."""
        return cls.from_quaternion_translation(*split_matrix("QuaternionPose", matrix))
