"""Euler angles as representations: as they come, unwrapped, and followed in each of twelve orders.

An order of axes is a choice of frames, and no more. With ``left`` the turn that lays its first two
axes on x and y, an order of three axes is x-y′-z″ of ``left R left⁻¹``; one that ends as it began
is that of ``left R left⁻¹ exp(-90° about y)``, whose middle angle is 90° less. Up to constants and
the sign of the third angle these are the same numbers, so that one compiled twin serves all twelve.
What an order decides is which rotations are gimbal lock.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.smoothing.representation import P, Poses, Representation
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.ga.classical import follow_euler, nearest_branch, nearest_euler
from motorcade.ga.versors.euler_angles import SEQUENCES, axes_of, lock_levers

_CHUNK = 4096


class EulerAngles(Representation):
    """Intrinsic x-y′-z″ angles as they come, each averaged for itself: at ±π they leap."""

    name = "euler"
    sequence = "xyz"
    _rigid_size = 6

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        coordinates = np.empty((len(poses), 6))
        for rows in _chunks(len(poses)):
            double = poses[rows].astype(np.float64)
            coordinates[rows, :3], coordinates[rows, 3:] = double.as_euler_translation(
                self.sequence
            )
        return coordinates

    def _rigid_poses(self, coordinates: FloatArray) -> Motor:
        flat = coordinates.reshape(-1, 6)
        coefficients = np.empty((len(flat), 8))
        for rows in _chunks(len(flat)):
            angles, translation = flat[rows, :3], flat[rows, 3:]
            poses = Motor.from_euler_translation(angles, translation, self.sequence)
            coefficients[rows] = poses.coefficients
        return Motor(coefficients.reshape(*coordinates.shape[:-1], 8))


def _chunks(count: int) -> list[slice]:
    """Segments of a path whose rotation matrices are few beside it."""
    return [slice(first, first + _CHUNK) for first in range(0, count, _CHUNK)]


class UnwrappedEulerAngles(EulerAngles):
    """The same angles, each made continuous over time; the pitch still folds at ±90°."""

    name = "euler_unwrapped"

    def continued(self, coordinates: FloatArray, previous: FloatArray) -> FloatArray:
        """Each angle on the branch nearest to the one before."""
        angles = nearest_branch(coordinates[..., :3], previous[..., :3])
        return np.concatenate([angles, coordinates[..., 3:]], axis=-1)

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        coordinates = super()._rigid_coordinates(poses)
        coordinates[:, :3] = np.unwrap(coordinates[:, :3], axis=0)
        return coordinates


class FollowedEulerAngles(EulerAngles):
    """Angles of an order, each triple the nearest to the one before of all that are its rotation.

    Args:
        sequence: three letters, intrinsic; one of `motorcade.ga.versors.euler_angles.SEQUENCES`.

    Raises:
        ValueError: another sequence.
    """

    def __init__(self, sequence: str) -> None:
        first, second, third, cyclic = axes_of(sequence)
        self.name = f"euler_{sequence}"
        self.sequence = sequence
        proper = sequence[0] == sequence[2]
        rows = np.zeros((3, 3))
        rows[0, first] = rows[1, second] = 1.0
        rows[2, third] = cyclic
        self._left = Rotor.from_matrix(rows)
        quarter = Rotor.from_rotation_vector([0.0, -0.5 * np.pi if proper else 0.0, 0.0])
        self._right = self._left.inverse() @ quarter
        self._third = -1.0 if proper else cyclic

    @property
    def compiled(self) -> str:
        """All orders are compiled as one."""
        return "euler_xyz"

    def to_compiled(self, poses: P) -> P:
        """The same rotations from frames in which the order is x-y′-z″; translations stay."""
        return _turned(poses, self._left, self._right)

    def from_compiled(self, poses: P) -> P:
        """Mirror of `to_compiled`."""
        return _turned(poses, self._left.inverse(), self._right.inverse())

    def vectors_from_compiled(self, vectors: FloatArray) -> FloatArray:
        """The third angle turns the other way where the order is not cyclic."""
        turned = vectors.copy()
        turned[..., 2] *= self._third
        return turned

    def continued(self, coordinates: FloatArray, previous: FloatArray) -> FloatArray:
        """The triple that is nearest to the one before."""
        angles = nearest_euler(coordinates[..., :3], previous[..., :3], self.sequence)
        return np.concatenate([angles, coordinates[..., 3:]], axis=-1)

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        coordinates = super()._rigid_coordinates(poses)
        coordinates[:, :3] = follow_euler(coordinates[:, :3], self.sequence)
        return coordinates


def _turned(poses: P, left: Rotor, right: Rotor) -> P:
    if isinstance(poses, Similarity):
        rigid, scale = poses.as_motor_scale()
        return Similarity.from_motor_scale(_turned_rigid(rigid, left, right), scale)
    return _turned_rigid(poses, left, right)


def _turned_rigid(poses: Motor, left: Rotor, right: Rotor) -> Motor:
    double = poses.astype(np.float64)
    return Motor.from_rotor_translation(left @ double.rotor @ right, double.translation_m)


# Half a degree, which is the noise of an ordinary pose: nearer a lock angles are all noise.
_NEAREST = 0.01

EULER_ORDERS: dict[str, FollowedEulerAngles] = {
    f"euler_{sequence}": FollowedEulerAngles(sequence) for sequence in SEQUENCES
}
"""The twelve orders of axes, followed, by name: `euler_xyz` to `euler_zyz`."""


def best_euler_order(poses: Poses) -> FollowedEulerAngles:
    """The order that stays farthest from its gimbal lock over a path ``(N,)``.

    Noise of the rotation grows in the angles by one over `lock_levers`; what is compared is the
    geometric mean of that over the path, as factors are averaged. One wrong pose near a lock does
    not rule an order out. Of orders that are equal the first of `SEQUENCES` is taken.

    Examples:
        >>> from motorcade.fusion.motions import MOTIONS
        >>> from motorcade.fusion.smoothing.euler import best_euler_order
        >>> path = MOTIONS["gimbal_crossing"].sampled(rate_hz=30.0, duration_s=10.0)
        >>> best_euler_order(path.poses).name
        'euler_yxz'
    """
    rigid = poses.rigid if isinstance(poses, Similarity) else poses
    total = np.zeros(len(SEQUENCES))
    for rows in _chunks(len(rigid)):
        matrices = rigid[rows].rotor.as_matrix()
        levers = np.stack([lock_levers(matrices, one) for one in SEQUENCES])
        total += np.sum(np.log(np.maximum(levers, _NEAREST)), axis=1)
    return EULER_ORDERS[f"euler_{SEQUENCES[int(np.argmax(total))]}"]
