"""Euler angles as practitioners use them, each by itself: array functions, and `EulerPose`.

Angles in radians, ``(*, 3)``, in the order of their sequence: three lower-case letters, intrinsic
unless ``extrinsic`` says that the axes stay fixed; `motorcade.ga.versors.euler_angles` converts
them. They are numbers on a line here, never wrapped by themselves: 190° and -170° are one rotation,
but not one path. Of all triples that are one rotation, branches are those that lie near others.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.classical.pose import Pose, random_pose
from motorcade.ga.classical.quaternion import quaternion_as_matrix, quaternion_from_matrix
from motorcade.ga.versors.euler_angles import (
    LOCKED,
    SEQUENCES,
    axes_of,
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
    return (1.0 - steps) * start + steps * end


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
        values = checked_floats(coefficients, "EulerPose.normalize(coefficients)", (6,))
        return cls._joined(
            matrix_from_euler(values[..., :3], sequence, extrinsic),
            values[..., 3:],
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
        return (self._rotation() @ x[..., None])[..., 0] + self.translation_m

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
        matrices = checked_floats(matrix, "EulerPose.from_matrix(matrix)", (4, 4))
        return cls._joined(matrices[..., :3, :3], matrices[..., :3, 3], sequence, extrinsic)


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
    return angles + 2.0 * np.pi * np.round((reference - angles) / (2.0 * np.pi))


def nearest_euler(
    angles_rad: ArrayLike, reference_rad: ArrayLike, sequence: str = "xyz"
) -> FloatArray:
    """Of all triples ``(*, 3)`` that are one rotation, those nearest to their references.

    Angles may turn by 2π, and there is a twin: ``(a + π, π - b, c + π)``, of sequences that end as
    they began ``(a + π, -b, c + π)``. What is nearest is the triple as a whole. At gimbal lock one
    of the first and third angle is free, and both move by the same amount.

    Args:
        angles_rad: in the order of the sequence, intrinsic.
        reference_rad: in any branch; batches broadcast.
        sequence: see `motorcade.ga.versors.euler_angles`.

    Raises:
        ValueError: an unknown sequence, wrong last dimension, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.classical import nearest_euler
        >>> over = np.deg2rad([-180.0, 85.0, -180.0])  # a pitch that went on from 88 to 95
        >>> np.rad2deg(nearest_euler(over, np.deg2rad([0.0, 88.0, 0.0]))).round(6) + 0.0
        array([ 0., 95.,  0.])
    """
    angles = checked_floats(angles_rad, "angles_rad", (3,))
    reference = checked_floats(reference_rad, "reference_rad", (3,))
    branches = (angles, _twin(angles, sequence))
    own, twin = (nearest_branch(one, reference) for one in branches)
    far, near = (np.sum((one - reference) ** 2, axis=-1, keepdims=True) for one in (own, twin))
    nearest = np.where(near < far, twin, own)
    way = _lock_side(nearest[..., 1], sequence)
    if not np.any(way):
        return nearest
    # Only the first angle plus or minus the third is known there: both go half of the way.
    apart = nearest - reference
    half = 0.5 * nearest_branch(apart[..., 0] + way * apart[..., 2], 0.0)
    shared = reference + np.stack([half, apart[..., 1], way * half], axis=-1)
    return np.where(way[..., None] != 0.0, shared, nearest)


def follow_euler(angles_rad: ArrayLike, sequence: str = "xyz") -> FloatArray:
    """Angles ``(N, 3)`` of a path, each triple the nearest to the one before: see `nearest_euler`.

    The first stays as it is. Near gimbal lock angles turn fast still, and their noise with them.

    Raises:
        ValueError: an unknown sequence, angles of another shape, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Rotor
        >>> from motorcade.ga.classical import follow_euler
        >>> pitched = np.deg2rad([[0.0, 80.0, 0.0], [0.0, 100.0, 0.0], [0.0, 200.0, 0.0]])
        >>> np.rad2deg(follow_euler(Rotor.from_euler(pitched).as_euler())).round(6) + 0.0
        array([[  0.,  80.,   0.],
               [  0., 100.,   0.],
               [  0., 200.,   0.]])
    """
    angles = checked_floats(angles_rad, "angles_rad", (3,))
    if angles.ndim != 2:
        raise ValueError(f"angles_rad: expected (N, 3), got shape {angles.shape}")
    side = _lock_side(angles[:, 1], sequence)
    if len(angles) < 2:
        return angles.copy()
    starts = [1, *(1 + np.flatnonzero(np.diff(side[1:])) + 1).tolist(), len(angles)]
    followed = angles.copy()
    for start, stop in pairwise(starts):
        last, triples = followed[start - 1], angles[start:stop]
        if side[start] == 0.0:
            followed[start:stop] = _followed(last, triples, sequence)
        else:
            followed[start:stop] = _locked(last, triples, float(side[start]))
    return followed


def _followed(last: FloatArray, angles: FloatArray, sequence: str) -> FloatArray:
    """Triples ``(N, 3)`` after `last`, none at gimbal lock."""
    # Twins of two triples are as far apart as these: sides and turns depend on neighbours alone.
    whole = np.concatenate([last[None], angles])
    twin = _twin(whole, sequence)
    own, other = (nearest_branch(one[1:] - whole[:-1], 0.0) for one in (whole, twin))
    changes = np.sum(other**2, axis=-1) < np.sum(own**2, axis=-1)
    sides = np.cumsum(np.concatenate([np.zeros(1, dtype=np.bool_), changes])) % 2 == 1
    sided = np.where(sides[:, None], twin, whole)
    turns = np.cumsum(np.round((sided[:-1] - sided[1:]) / (2.0 * np.pi)), axis=0)
    return sided[1:] + 2.0 * np.pi * turns


def _locked(last: FloatArray, angles: FloatArray, way: float) -> FloatArray:
    """Triples ``(N, 3)`` after `last`, all at a lock: a + `way` c is known, a - `way` c stays."""
    whole = np.concatenate([last[None], angles])
    known = whole[:, 0] + way * whole[:, 2]
    half = 0.5 * np.cumsum(nearest_branch(np.diff(known), 0.0))
    middle = nearest_branch(angles[:, 1], last[1])
    return np.stack([last[0] + half, middle, last[2] + way * half], axis=-1)


def _is_proper(sequence: str) -> bool:
    """Whether a sequence ends around the axis that it began with; an unknown one is refused."""
    axes_of(sequence)
    return sequence[0] == sequence[2]


def _lock_side(middle_rad: FloatArray, sequence: str) -> FloatArray:
    """Sign s of the a + s c that alone is known at gimbal lock; 0 of triples that are not there."""
    _, _, _, cyclic = axes_of(sequence)
    sine, cosine = np.sin(middle_rad), np.cos(middle_rad)
    lever, way = (sine, cosine) if _is_proper(sequence) else (cosine, cyclic * sine)
    return np.where(np.abs(lever) <= 2.0 * LOCKED, np.sign(way), 0.0)


def _twin(angles: FloatArray, sequence: str) -> FloatArray:
    """The other triples ``(*, 3)`` of the same rotations, but for whole turns."""
    middle = -angles[..., 1] if _is_proper(sequence) else np.pi - angles[..., 1]
    return np.stack([angles[..., 0] + np.pi, middle, angles[..., 2] + np.pi], axis=-1)
