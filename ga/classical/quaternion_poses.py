"""Poses of quaternions: beside a translation, `QuaternionPose`, or dual, `DualQuaternion`.

A quaternion beside a translation is what most programs use. The two are interpolated apart: the
body's origin goes straight while the body turns about it, so the path depends on which point of the
body is called its origin. Dual quaternions are written with screw axis, moment, angle and slide, as
in graphics and robotics. Their linear blend is fast and its path between two poses is the screw's;
the screw has even speed besides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import UNIT_TOLERANCE, FloatArray, checked_floats
from motorcade.ga.classical.dual_quaternion import (
    dual_quaternion_apply,
    dual_quaternion_as_quaternion_translation,
    dual_quaternion_blend,
    dual_quaternion_conjugate,
    dual_quaternion_exp,
    dual_quaternion_from_quaternion_translation,
    dual_quaternion_log,
    dual_quaternion_multiply,
    dual_quaternion_normalize,
    dual_quaternion_screw,
)
from motorcade.ga.classical.pose import Pose, checked_method
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
        with np.errstate(over="ignore"):  # an infinite norm is refused like any other
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
    def normalize(cls, coefficients: ArrayLike) -> QuaternionPose:
        """Divide the quaternions of ``(*, 7)`` by their norm; translations stay.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a zero quaternion.
        """
        values = checked_floats(coefficients, "QuaternionPose.normalize(coefficients)", (7,))
        unit = quaternion_normalize(values[..., :4])
        return cls(np.concatenate([unit, values[..., 4:]], axis=-1))

    @classmethod
    def exp(cls, log: ArrayLike) -> QuaternionPose:
        """Poses from rotation vector (rad) and translation (m), ``(*, 6)``, each by itself."""
        twists = checked_floats(log, "QuaternionPose.exp(log)", (6,))
        turned = quaternion_from_rotation_vector(twists[..., :3])
        return cls(np.concatenate([turned, twists[..., 3:]], axis=-1))

    def log(self) -> FloatArray:
        """Rotation vector (rad, at most π long) and translation (m), ``(*, 6)``."""
        turn = quaternion_as_rotation_vector(self.wxyz)
        return np.concatenate([turn, self.translation_m], axis=-1)

    def _compose(self, other: QuaternionPose) -> FloatArray:
        turned = quaternion_multiply(self.wxyz, other.wxyz)
        moved = quaternion_apply(self.wxyz, other.translation_m) + self.translation_m
        return np.concatenate([turned, moved], axis=-1)

    def _retracted(self, step: FloatArray) -> FloatArray:
        turned = quaternion_multiply(self.wxyz, quaternion_from_rotation_vector(step[..., :3]))
        return np.concatenate([turned, self.translation_m + step[..., 3:]], axis=-1)

    def _local(self, other: QuaternionPose) -> FloatArray:
        between = quaternion_multiply(quaternion_conjugate(self.wxyz), other.wxyz)
        moved = other.translation_m - self.translation_m
        return np.concatenate([quaternion_as_rotation_vector(between), moved], axis=-1)

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


@dataclass(frozen=True, eq=False, repr=False)
class DualQuaternion(Pose):
    """``coefficients (*, 8)``: real part w, x, y, z of unit length, dual part at right angles.

    Examples:
        >>> from motorcade.ga.classical import DualQuaternion
        >>> start = DualQuaternion.identity()
        >>> end = DualQuaternion.from_quaternion_translation([0, 0, 0, 1], [0, 0, 2])
        >>> start.interpolate(end, 0.5).apply([1, 0, 0]).round(6)  # a quarter turn about z, 1 m up
        array([0., 1., 1.])
    """

    _size: ClassVar[int] = 8

    def _check(self, coefficients: FloatArray) -> None:
        real, dual = coefficients[..., :4], coefficients[..., 4:]
        length = np.maximum(1.0, np.max(np.abs(dual), axis=-1))
        with np.errstate(over="ignore", invalid="ignore"):
            off = np.abs(np.linalg.norm(real, axis=-1) - 1.0)
            off = np.maximum(off, np.abs(np.sum(real * dual, axis=-1)) / length)
        worst = float(np.max(off, initial=0.0))
        if not worst <= UNIT_TOLERANCE:
            raise ValueError(
                "DualQuaternion.coefficients: expected unit dual quaternions (within "
                f"{UNIT_TOLERANCE:g}), got one off by {worst:.3g}; normalize divides by the norm"
            )

    @classmethod
    def normalize(cls, coefficients: ArrayLike) -> DualQuaternion:
        """Divide ``(*, 8)`` by its dual norm.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a zero real part.
        """
        values = checked_floats(coefficients, "DualQuaternion.normalize(coefficients)", (8,))
        return cls(dual_quaternion_normalize(values))

    @classmethod
    def exp(cls, log: ArrayLike) -> DualQuaternion:
        """Dual quaternions from pure ones ``(*, 6)``, half of rotation vector and velocity."""
        return cls(dual_quaternion_exp(checked_floats(log, "DualQuaternion.exp(log)", (6,))))

    def log(self) -> FloatArray:
        """Pure dual quaternions ``(*, 6)``: real x, y, z, then dual x, y, z."""
        return dual_quaternion_log(self.coefficients)

    def _compose(self, other: DualQuaternion) -> FloatArray:
        return dual_quaternion_multiply(self.coefficients, other.coefficients)

    def _retracted(self, step: FloatArray) -> FloatArray:
        return dual_quaternion_multiply(self.coefficients, dual_quaternion_exp(0.5 * step))

    def _local(self, other: DualQuaternion) -> FloatArray:
        back = dual_quaternion_conjugate(self.coefficients)
        return 2.0 * dual_quaternion_log(dual_quaternion_multiply(back, other.coefficients))

    def inverse(self) -> DualQuaternion:
        """The motion undone: both parts conjugated."""
        return self._like(dual_quaternion_conjugate(self.coefficients))

    def apply(self, points: ArrayLike) -> FloatArray:
        """Move points ``(*, 3)`` in metres."""
        return dual_quaternion_apply(self.coefficients, self._checked_points(points))

    def interpolate(
        self,
        other: DualQuaternion,
        fraction: ArrayLike,
        short_way: bool = True,
        *,
        method: str = "screw",
    ) -> DualQuaternion:
        """Screw interpolation ("screw") or the normalised sum ("linear").

        Raises:
            ValueError: an unknown method, NaN or infinite fraction, batches that do not broadcast.
            TypeError: another type of pose.
        """
        steps = self._checked_fraction(other, fraction)
        chosen = checked_method("DualQuaternion.interpolate", method, ("screw", "linear"))
        a, b = self.coefficients, other.coefficients
        if chosen == "screw":
            return self._like(dual_quaternion_screw(a, b, steps, short_way))
        if short_way:
            b = nearest_sign(b, a)
        part = steps[..., None]
        return self._like(dual_quaternion_normalize((1.0 - part) * a + part * b))

    def blend(self, weights: ArrayLike) -> DualQuaternion:
        """Linear blend over the last batch dimension, ``(*, K)`` to ``(*)``; signs of the first.

        Raises:
            ValueError: weights that do not fit or sum to zero, dual quaternions that cancel.
        """
        share = self._checked_weights(weights)
        values = np.broadcast_to(self.coefficients, (*share.shape, 8))
        return self._like(dual_quaternion_blend(values, share))

    @classmethod
    def from_quaternion_translation(
        cls, wxyz: ArrayLike, translation_m: ArrayLike
    ) -> DualQuaternion:
        """From unit quaternions ``(*, 4)`` and translations ``(*, 3)``; batches broadcast."""
        return cls(dual_quaternion_from_quaternion_translation(wxyz, translation_m))

    def as_quaternion_translation(self) -> tuple[FloatArray, FloatArray]:
        """Unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)`` in metres."""
        return dual_quaternion_as_quaternion_translation(self.coefficients)
