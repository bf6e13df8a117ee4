"""Euler angles beside translation, ``(*, 6)``: three angles (rad), then metres.

The sequence is three lower-case letters, intrinsic unless ``extrinsic`` says that the axes stay
fixed; see `motorcade.ga.versors.euler_angles`. Angles are kept as they are, never wrapped by
themselves: an angle of 190° and one of -170° are the same turn, but not the same path. Composition
and inverse go through matrices, since angles have no product.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.classical.euler import interpolate_euler, nearest_branch
from motorcade.ga.classical.pose import Pose, random_pose
from motorcade.ga.classical.quaternion import quaternion_as_matrix, quaternion_from_matrix
from motorcade.ga.versors.euler_angles import SEQUENCES, euler_from_matrix, matrix_from_euler

__all__ = ["EulerPose"]


@dataclass(frozen=True, eq=False, repr=False)
class EulerPose(Pose):
    """``coefficients (*, 6)``: angles (rad) in the order of `sequence`, translation in metres.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, an unknown sequence.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.classical import EulerPose
        >>> almost = EulerPose(np.deg2rad([0, 0, 179, 0, 0, 0]))
        >>> beyond = EulerPose(np.deg2rad([0, 0, -179, 0, 0, 0]))
        >>> np.rad2deg(almost.interpolate(beyond, 0.5).angles_rad).round(6)  # back through 0
        array([0., 0., 0.])
        >>> np.rad2deg(almost.interpolate(beyond, 0.5, short_way=True).angles_rad).round(6)
        array([  0.,   0., 180.])
    """

    sequence: str = "xyz"
    extrinsic: bool = False

    _size: ClassVar[int] = 6

    def _check(self, coefficients: FloatArray) -> None:
        if self.sequence not in SEQUENCES:
            raise ValueError(
                f"EulerPose.sequence: expected one of {', '.join(SEQUENCES)}, got {self.sequence!r}"
            )

    def _check_same(self, other: EulerPose) -> None:
        super()._check_same(other)
        mine, its = (self.sequence, self.extrinsic), (other.sequence, other.extrinsic)
        if mine != its:
            raise ValueError(
                "EulerPose: expected two poses of one sequence, got "
                + " and ".join(
                    f"{name} {'extrinsic' if out else 'intrinsic'}" for name, out in (mine, its)
                )
            )

    @property
    def angles_rad(self) -> FloatArray:
        """Angles ``(*, 3)`` in the order of the sequence."""
        return self.coefficients[..., :3]

    @property
    def translation_m(self) -> FloatArray:
        """Translations ``(*, 3)``: where the body's origin is."""
        return self.coefficients[..., 3:]

    @classmethod
    def identity(
        cls, shape: tuple[int, ...] = (), sequence: str = "xyz", extrinsic: bool = False
    ) -> EulerPose:
        """No motion, repeated over the batch `shape`."""
        return cls(np.zeros((*shape, 6)), sequence, extrinsic)

    @classmethod
    def random(
        cls,
        rng: np.random.Generator,
        shape: tuple[int, ...] = (),
        extent_m: float = 1.0,
        sequence: str = "xyz",
        extrinsic: bool = False,
    ) -> EulerPose:
        """Uniform orientations, normal translations with deviation `extent_m` an axis."""
        pose = random_pose(rng, shape, extent_m)
        return cls.from_quaternion_translation(*pose, sequence, extrinsic)

    @classmethod
    def normalize(
        cls, coefficients: ArrayLike, sequence: str = "xyz", extrinsic: bool = False
    ) -> EulerPose:
        """The same rotations by angles in their principal ranges (see `euler_from_matrix`)."""
        given = checked_floats(coefficients, "EulerPose.normalize(coefficients)", (6,))
        return cls._joined(
            matrix_from_euler(given[..., :3], sequence, extrinsic),
            given[..., 3:],
            sequence,
            extrinsic,
        )

    @classmethod
    def exp(cls, log: ArrayLike, sequence: str = "xyz", extrinsic: bool = False) -> EulerPose:
        """Poses from ``(*, 6)``: the numbers are the angles and the translation themselves."""
        return cls(checked_floats(log, "EulerPose.exp(log)", (6,)), sequence, extrinsic)

    def log(self) -> FloatArray:
        """Angles (rad) and translation (m), ``(*, 6)``, treated as a vector."""
        return self.coefficients.copy()

    @classmethod
    def _joined(
        cls, rotation: FloatArray, translation_m: FloatArray, sequence: str, extrinsic: bool
    ) -> EulerPose:
        angles = euler_from_matrix(rotation, sequence, extrinsic)
        shape = np.broadcast_shapes(angles.shape, translation_m.shape)
        both = [np.broadcast_to(angles, shape), np.broadcast_to(translation_m, shape)]
        return cls(np.concatenate(both, axis=-1), sequence, extrinsic)

    def _rotation(self) -> FloatArray:
        return matrix_from_euler(self.angles_rad, self.sequence, self.extrinsic)

    def _compose(self, other: EulerPose) -> FloatArray:
        rotation = self._rotation()
        moved = (rotation @ other.translation_m[..., None])[..., 0] + self.translation_m
        product = rotation @ other._rotation()
        return np.array(self._joined(product, moved, self.sequence, self.extrinsic).coefficients)

    def inverse(self) -> EulerPose:
        """The motion undone, by the transposed matrix."""
        back = np.swapaxes(self._rotation(), -1, -2)
        moved = -(back @ self.translation_m[..., None])[..., 0]
        return self._joined(back, moved, self.sequence, self.extrinsic)

    def apply(self, points: ArrayLike) -> FloatArray:
        """Move points ``(*, 3)`` in metres."""
        x = self._checked_points(points)
        moved: FloatArray = (self._rotation() @ x[..., None])[..., 0] + self.translation_m
        return moved

    def interpolate(
        self, other: EulerPose, fraction: ArrayLike, short_way: bool = False
    ) -> EulerPose:
        """Each angle and each coordinate by itself, straight from start to end.

        The path depends on the sequence, its speed is uneven near gimbal lock, and by default an
        angle that has jumped by 2π takes the whole turn back. With ``short_way`` each angle's
        end is first taken on the branch nearest to its start.

        Raises:
            ValueError: NaN or infinite fraction, batches that do not broadcast, two sequences.
            TypeError: another type of pose.
        """
        steps = self._checked_fraction(other, fraction)
        end = other.angles_rad
        if short_way:
            end = nearest_branch(end, self.angles_rad)
        turned = interpolate_euler(self.angles_rad, end, steps)
        part = steps[..., None]
        moved = (1.0 - part) * self.translation_m + part * other.translation_m
        return self._like(np.concatenate([turned, moved], axis=-1))

    def blend(self, weights: ArrayLike) -> EulerPose:
        """Weighted average of angles and coordinates over the last batch dimension.

        Raises:
            ValueError: weights that do not fit or sum to zero.
        """
        share = self._checked_weights(weights)
        parts = share / np.sum(share, axis=-1, keepdims=True)
        averaged: FloatArray = np.sum(parts[..., None] * self.coefficients, axis=-2)
        return self._like(averaged)

    @classmethod
    def from_quaternion_translation(
        cls,
        wxyz: ArrayLike,
        translation_m: ArrayLike,
        sequence: str = "xyz",
        extrinsic: bool = False,
    ) -> EulerPose:
        """Poses from unit quaternions ``(*, 4)`` and translations ``(*, 3)``; batches broadcast."""
        t = checked_floats(translation_m, "EulerPose translation_m", (3,))
        return cls._joined(quaternion_as_matrix(wxyz), t, sequence, extrinsic)

    def as_quaternion_translation(self) -> tuple[FloatArray, FloatArray]:
        """Unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)`` in metres."""
        return quaternion_from_matrix(self._rotation()), self.translation_m

    @classmethod
    def from_matrix(
        cls, matrix: ArrayLike, sequence: str = "xyz", extrinsic: bool = False
    ) -> EulerPose:
        """Poses from homogeneous matrices ``(*, 4, 4)``, taken for rigid."""
        given = checked_floats(matrix, "EulerPose.from_matrix(matrix)", (4, 4))
        return cls._joined(given[..., :3, :3], given[..., :3, 3], sequence, extrinsic)
