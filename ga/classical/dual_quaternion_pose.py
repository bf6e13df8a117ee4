"""Dual quaternion, ``(*, 8)``: real part w, x, y, z, then dual part w, x, y, z.

Written with screw axis, moment, angle and slide, as in graphics and robotics. The linear blend is
fast and its path between two poses is the screw's; the screw has even speed besides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
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
from motorcade.ga.classical.pose import (
    UNIT_TOLERANCE,
    Pose,
    checked_method,
    random_pose,
    split_matrix,
)
from motorcade.ga.classical.quaternion import nearest_sign

__all__ = ["DualQuaternion"]


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
        off = np.abs(np.linalg.norm(real, axis=-1) - 1.0)
        length = np.maximum(1.0, np.max(np.abs(dual), axis=-1))
        off = np.maximum(off, np.abs(np.sum(real * dual, axis=-1)) / length)
        worst = float(np.max(off, initial=0.0))
        if worst > UNIT_TOLERANCE:
            raise ValueError(
                "DualQuaternion.coefficients: expected unit dual quaternions (within "
                f"{UNIT_TOLERANCE:g}), got one off by {worst:.3g}; normalize divides by the norm"
            )

    @classmethod
    def identity(cls, shape: tuple[int, ...] = ()) -> DualQuaternion:
        """No motion, repeated over the batch `shape`."""
        return cls(np.broadcast_to(np.eye(8)[0], (*shape, 8)))

    @classmethod
    def random(
        cls, rng: np.random.Generator, shape: tuple[int, ...] = (), extent_m: float = 1.0
    ) -> DualQuaternion:
        """Uniform orientations, normal translations with deviation `extent_m` an axis."""
        return cls.from_quaternion_translation(*random_pose(rng, shape, extent_m))

    @classmethod
    def normalize(cls, coefficients: ArrayLike) -> DualQuaternion:
        """Divide ``(*, 8)`` by its dual norm.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a zero real part.
        """
        given = checked_floats(coefficients, "DualQuaternion.normalize(coefficients)", (8,))
        return cls(dual_quaternion_normalize(given))

    @classmethod
    def exp(cls, log: ArrayLike) -> DualQuaternion:
        """Dual quaternions from pure ones ``(*, 6)``, half of rotation vector and velocity."""
        return cls(dual_quaternion_exp(checked_floats(log, "DualQuaternion.exp(log)", (6,))))

    def log(self) -> FloatArray:
        """Pure dual quaternions ``(*, 6)``: real x, y, z, then dual x, y, z."""
        return dual_quaternion_log(self.coefficients)

    def _compose(self, other: DualQuaternion) -> FloatArray:
        return dual_quaternion_multiply(self.coefficients, other.coefficients)

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
        given = np.broadcast_to(self.coefficients, (*share.shape, 8))
        return self._like(dual_quaternion_blend(given, share))

    @classmethod
    def from_quaternion_translation(
        cls, wxyz: ArrayLike, translation_m: ArrayLike
    ) -> DualQuaternion:
        """From unit quaternions ``(*, 4)`` and translations ``(*, 3)``; batches broadcast."""
        return cls(dual_quaternion_from_quaternion_translation(wxyz, translation_m))

    def as_quaternion_translation(self) -> tuple[FloatArray, FloatArray]:
        """Unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)`` in metres."""
        return dual_quaternion_as_quaternion_translation(self.coefficients)

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> DualQuaternion:
        """From homogeneous matrices ``(*, 4, 4)``, taken for rigid."""
        return cls.from_quaternion_translation(*split_matrix("DualQuaternion", matrix))
