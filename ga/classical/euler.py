"""Euler angles as practitioners use them, each by itself: array functions, and `EulerPose`.

Angles in radians, ``(*, 3)``, in the order of their sequence: three lower-case letters, intrinsic
unless ``extrinsic`` says that the axes stay fixed; `motorcade.ga.versors.euler_angles` converts
them. They are numbers on a line here, never wrapped by themselves: 190° and -170° are one rotation,
but not one path.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.classical.branches import nearest_branch
from motorcade.ga.classical.pose import Pose, random_pose
from motorcade.ga.classical.quaternion import quaternion_as_matrix, quaternion_from_matrix
from motorcade.ga.versors.euler_angles import (
    SEQUENCES,
    euler_from_matrix,
    matrix_from_euler,
)

# Euler rates are divided by the cosine of the middle angle, kept at least this far from zero.
_LEAST_COSINE = 1e-3


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


@dataclass(frozen=True, eq=False, repr=False)
class EulerPose(Pose):
    """``coefficients (*, 6)``: angles (rad) in the order of `sequence`, translation in metres.

    Composition and inverse go through matrices, since angles have no product.

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

    def _retracted(self, step: FloatArray) -> FloatArray:
        return self.coefficients + step

    def _local(self, other: EulerPose) -> FloatArray:
        return other.coefficients - self.coefficients

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
