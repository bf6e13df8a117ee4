"""Poses as numbers that every smoother runs on: the ways to write a path down and to average it.

What is a straight line in a representation's vectors is what tells it from the others:

=====================  ===  ===  ==============================================================
name                    D    d   local vector
=====================  ===  ===  ==============================================================
``motor``                8    6  twist from base to pose, in the base's body frame: one screw
``similarity``          12    7  the same with the logarithm of the scale behind it
``rotor``                7    6  rotation vector in the base's body, translation in the world
``dual_quaternion``      8    8  components (signs follow), projected after every step
``quaternion``           7    7  components (signs follow), renormalised; translation apart
``euler_unwrapped``      6    6  x-y′-z″, each angle made continuous over time; translation apart
``euler``                6    6  x-y′-z″ as they come, which leap at ±π; translation apart
``euler_xyz``, ...       6    6  of an order, as triples nearest to the ones before
``euler_best``           6    6  the one of these that stays farthest from its gimbal lock
=====================  ===  ===  ==============================================================

A method sees coordinates ``(*, D)``. ``local(x, base)`` (⊟) is the vector ``(*, d)`` from a base to
`x` and ``retract(base, vector)`` (⊞) its mirror; whatever a method averages, filters or fits are
such vectors, so that it is written once.

All but the first three are subtraction and addition, as practitioners do it. Of a path of
similarities all but `similarity` carry the scale beside the rest as one more number, last of both D
and d. Rotations come first, then translations.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, TypeVar

import numpy as np

from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.classical import (
    dual_quaternion_normalize,
    follow_euler,
    nearest_branch,
    nearest_euler,
    nearest_sign,
    quaternion_normalize,
)
from motorcade.ga.kernels import (
    MOTORS,
    ROTORS,
    SIMILARITIES,
    VersorKernels,
)
from motorcade.ga.names import nearest_name
from motorcade.ga.versors.euler_angles import SEQUENCES, axes_of, lock_levers

__all__ = [
    "BEST_EULER",
    "REPRESENTATIONS",
    "REPRESENTATION_NAMES",
    "Poses",
    "Representation",
    "representation_named",
    "restored",
]


Poses = Motor | Similarity
P = TypeVar("P", Motor, Similarity, Motor | Similarity)


class Representation(ABC):
    """A way to write poses down. All methods are batched in front.

    Fields:
        name: one of `REPRESENTATION_NAMES`.
        ends: where rotation and translation end in a local vector of rigid poses.
        units: components of a local vector for a radian and for a metre.
        coupled: how many components compose as one motion, and so mix; 0 where all are added.
        signed: leading components of coordinates whose common sign is free.
        scale_beside: a scale is one more number behind the coordinates of the rigid pose.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.smoothing import REPRESENTATIONS
        >>> from motorcade.ga import Motor
        >>> turned = Motor.from_euler_translation([[0, 0, 0], [0, 0, 0.5]], np.zeros((2, 3)))
        >>> motors = REPRESENTATIONS["motor"]
        >>> x = motors.coordinates(turned)
        >>> motors.local(x[1], x[0]).round(6) + 0.0
        array([0. , 0. , 0.5, 0. , 0. , 0. ])
    """

    name: str
    ends: ClassVar[tuple[int, int]] = (3, 6)
    units: ClassVar[tuple[float, float]] = (1.0, 1.0)
    coupled: ClassVar[int] = 0
    signed: ClassVar[int] = 0
    scale_beside: ClassVar[bool] = True
    _rigid_size: ClassVar[int]

    def coordinates(self, poses: Poses) -> FloatArray:
        """Write down a path of poses ``(N,)`` as ``(N, D)``, continuous where the practice is."""
        if not isinstance(poses, Similarity):
            return self._rigid_coordinates(poses)
        motor, scale = poses.as_motor_scale()
        return np.concatenate([self._rigid_coordinates(motor), scale[..., None]], axis=-1)

    def poses(self, coordinates: FloatArray) -> Poses:
        """Poses ``(*)`` of coordinates ``(*, D)``; similarities where there is a scale.

        Raises:
            ValueError: coordinates of no pose, such as a scale that is not positive.
        """
        if coordinates.shape[-1] == self._rigid_size:
            return self._rigid_poses(coordinates)
        rigid = self._rigid_poses(coordinates[..., :-1])
        return Similarity.from_motor_scale(rigid, coordinates[..., -1])

    def local(self, coordinates: FloatArray, base: FloatArray) -> FloatArray:
        """Vectors ``(*, d)`` from bases ``(*, D)`` to poses ``(*, D)``; batches broadcast."""
        if coordinates.shape[-1] == self._rigid_size:
            return self._rigid_local(coordinates, base)
        rigid = self._rigid_local(coordinates[..., :-1], base[..., :-1])
        scale = coordinates[..., -1:] - base[..., -1:]
        return np.concatenate([rigid, scale], axis=-1)

    def retract(self, base: FloatArray, vector: FloatArray) -> FloatArray:
        """Coordinates ``(*, D)`` that lie a vector ``(*, d)`` from a base: mirrors `local`."""
        if base.shape[-1] == self._rigid_size:
            return self._rigid_retract(base, vector)
        rigid = self._rigid_retract(base[..., :-1], vector[..., :-1])
        return np.concatenate([rigid, base[..., -1:] + vector[..., -1:]], axis=-1)

    def local_jacobians(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """How `local` vectors ``(N, d)`` change with small vectors of the base and of the pose.

        Returns:
            Two arrays ``(N, d, d)``, or ``(1, d, d)`` where they are the same for all.
        """
        size = self.ends[1]
        rigid = self._rigid_local_jacobians(vector[..., :size])
        if vector.shape[-1] == size:
            return rigid
        both = [np.zeros((len(part), size + 1, size + 1)) for part in rigid]
        for whole, part, sign in zip(both, rigid, (-1.0, 1.0), strict=True):
            whole[:, :size, :size], whole[:, size, size] = part, sign
        return both[0], both[1]

    def continued(self, coordinates: FloatArray, previous: FloatArray) -> FloatArray:
        """The same poses ``(*, D)`` written as near as may be to others ``(*, D)``.

        Scanned over a path it gives what `coordinates` gives: of the two signs or the many branches
        of angles the nearest, where the practice takes it; the others return what they are given.
        """
        return coordinates

    @property
    def compiled(self) -> str:
        """Name of the compiled twin, which is fed with `to_compiled` poses or own coordinates."""
        return self.name

    def to_compiled(self, poses: P) -> P:
        """Poses as the compiled twin takes them."""
        return poses

    def from_compiled(self, poses: P) -> P:
        """What the compiled twin gives, as poses of this representation: mirrors `to_compiled`."""
        return poses

    def vectors_from_compiled(self, vectors: FloatArray) -> FloatArray:
        """Local vectors ``(*, d)`` of the compiled twin as those of this representation."""
        return vectors

    @abstractmethod
    def _rigid_coordinates(self, poses: Motor) -> FloatArray: ...

    @abstractmethod
    def _rigid_poses(self, coordinates: FloatArray) -> Motor: ...

    def _rigid_local(self, coordinates: FloatArray, base: FloatArray) -> FloatArray:
        return coordinates - base

    def _rigid_retract(self, base: FloatArray, vector: FloatArray) -> FloatArray:
        return base + vector

    def _rigid_local_jacobians(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        unit = np.eye(vector.shape[-1])[None]
        return -unit, unit


# Euler angles as representations: as they come, unwrapped, and followed in each of twelve orders.
#
# An order of axes is a choice of frames, and no more. With ``left`` the turn that lays its first
# two axes on x and y, an order of three axes is x-y′-z″ of ``left R left⁻¹``; one that ends as it
# began is that of ``left R left⁻¹ exp(-90° about y)``, whose middle angle is 90° less. Up to
# constants and the sign of the third angle these are the same numbers, so that one compiled twin
# serves all twelve. What an order decides is which rotations are gimbal lock.

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
        >>> from motorcade.fusion.smoothing.representations import best_euler_order
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


class MotorTwists(Representation):
    """Motors, averaged as twists in the base's body frame: no choice of world or body matters."""

    name = "motor"
    coupled = 6
    _rigid_size = 8

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        return poses.astype(np.float64).coefficients

    def _rigid_poses(self, coordinates: FloatArray) -> Motor:
        return Motor(coordinates)

    def _rigid_local(self, coordinates: FloatArray, base: FloatArray) -> FloatArray:
        return MOTORS.local(base, coordinates)

    def _rigid_retract(self, base: FloatArray, vector: FloatArray) -> FloatArray:
        return MOTORS.retract(base, vector)

    def _rigid_local_jacobians(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        return _inverse_jacobians(MOTORS, vector)


class SimilarityTwists(Representation):
    """Similarities, averaged as twists with the logarithm of the scale; rigid paths keep 1."""

    name = "similarity"
    coupled = 7
    scale_beside = False
    _rigid_size = 12

    def coordinates(self, poses: Poses) -> FloatArray:
        """Coefficients ``(N, 12)``."""
        if isinstance(poses, Motor):
            poses = Similarity.from_motor_scale(poses.astype(np.float64))
        return poses.coefficients.astype(np.float64, copy=False)

    def poses(self, coordinates: FloatArray) -> Similarity:
        """Similarities, of rigid paths too: see `restored`."""
        return Similarity(coordinates)

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        return self.coordinates(poses)

    def _rigid_poses(self, coordinates: FloatArray) -> Motor:
        return self.poses(coordinates).rigid

    def _rigid_local(self, coordinates: FloatArray, base: FloatArray) -> FloatArray:
        return Similarity(base).local(Similarity(coordinates))

    def _rigid_retract(self, base: FloatArray, vector: FloatArray) -> FloatArray:
        return Similarity(base).retract(vector).coefficients

    def local_jacobians(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of twists ``(N, 7)``, the logarithm of the scale among them."""
        return _inverse_jacobians(SIMILARITIES, vector)


class Rotors(Representation):
    """Rotors beside translations: the body turns about its own origin, which goes straight."""

    name = "rotor"
    coupled = 3
    _rigid_size = 7

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        double = poses.astype(np.float64)
        return np.concatenate([double.rotor.coefficients, double.translation_m], axis=-1)

    def _rigid_poses(self, coordinates: FloatArray) -> Motor:
        return Motor.from_rotor_translation(Rotor(coordinates[..., :4]), coordinates[..., 4:])

    def _rigid_local(self, coordinates: FloatArray, base: FloatArray) -> FloatArray:
        turn = ROTORS.local(base[..., :4], coordinates[..., :4])
        return np.concatenate([turn, coordinates[..., 4:] - base[..., 4:]], axis=-1)

    def _rigid_retract(self, base: FloatArray, vector: FloatArray) -> FloatArray:
        turned = ROTORS.retract(base[..., :4], vector[..., :3])
        return np.concatenate([turned, base[..., 4:] + vector[..., 3:]], axis=-1)

    def _rigid_local_jacobians(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        jacobians = [np.zeros((len(vector), 6, 6)) for _ in range(2)]
        turning = _inverse_jacobians(ROTORS, vector[..., :3])
        for whole, part, sign in zip(jacobians, turning, (-1.0, 1.0), strict=True):
            whole[:, :3, :3], whole[:, 3:, 3:] = part, sign * np.eye(3)
        return jacobians[0], jacobians[1]


def _inverse_jacobians(
    tangents: VersorKernels, vector: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How a twist to a pose changes with moves of its base and of the pose."""
    return -tangents.left_jacobian_inverse(vector), tangents.left_jacobian_inverse(-vector)


class _SignedComponents(Representation):
    """Components of which the first four are a quaternion whose sign follows its predecessor."""

    def continued(self, coordinates: FloatArray, previous: FloatArray) -> FloatArray:
        """The sign nearest to the quaternion before."""
        nearest = nearest_sign(coordinates[..., : self.signed], previous)
        return np.concatenate([nearest, coordinates[..., self.signed :]], axis=-1)

    def _with_signs(self, components: FloatArray) -> FloatArray:
        flips = np.sum(components[1:, :4] * components[:-1, :4], axis=-1) < 0.0
        signs = np.where(np.concatenate([[False], np.cumsum(flips) % 2 == 1]), -1.0, 1.0)
        continuous = components.copy()
        continuous[:, : self.signed] *= signs[:, None]
        return continuous


class Quaternions(_SignedComponents):
    """Quaternion components, renormalised, beside translations."""

    name = "quaternion"
    ends = (4, 7)
    units = (0.5, 1.0)
    signed = 4
    _rigid_size = 7

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        wxyz, translation = poses.astype(np.float64).as_quaternion_translation()
        return self._with_signs(np.concatenate([wxyz, translation], axis=-1))

    def _rigid_poses(self, coordinates: FloatArray) -> Motor:
        wxyz = quaternion_normalize(coordinates[..., :4])
        return Motor.from_quaternion_translation(wxyz, coordinates[..., 4:])

    def _rigid_retract(self, base: FloatArray, vector: FloatArray) -> FloatArray:
        summed = base + vector
        return np.concatenate([quaternion_normalize(summed[..., :4]), summed[..., 4:]], axis=-1)


class DualQuaternions(_SignedComponents):
    """The eight components of dual quaternions, projected onto unit ones."""

    name = "dual_quaternion"
    ends = (4, 8)
    units = (0.5, 0.5)
    signed = 8
    _rigid_size = 8

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        return self._with_signs(poses.astype(np.float64).as_dual_quaternion())

    def _rigid_poses(self, coordinates: FloatArray) -> Motor:
        return Motor.from_dual_quaternion(dual_quaternion_normalize(coordinates))

    def _rigid_retract(self, base: FloatArray, vector: FloatArray) -> FloatArray:
        return dual_quaternion_normalize(base + vector)


REPRESENTATIONS: dict[str, Representation] = {
    representation.name: representation
    for representation in (
        MotorTwists(),
        SimilarityTwists(),
        Rotors(),
        DualQuaternions(),
        Quaternions(),
        UnwrappedEulerAngles(),
        EulerAngles(),
    )
}
"""The representations that smoothers are compared on, by name; `EULER_ORDERS` stand beside them."""

BEST_EULER = "euler_best"

REPRESENTATION_NAMES: tuple[str, ...] = (*REPRESENTATIONS, BEST_EULER, *EULER_ORDERS)
"""Every name that `smooth` takes."""


def representation_named(name: str, poses: Poses | None = None) -> Representation:
    """The representation of that name.

    Args:
        name: one of `REPRESENTATION_NAMES`.
        poses: the whole path ``(N,)``, by which "euler_best" is decided.

    Raises:
        ValueError: an unknown name (the message lists those that are known), or "euler_best"
            without a path.

    Examples:
        >>> from motorcade.fusion.motions import MOTIONS
        >>> from motorcade.fusion.smoothing.representations import representation_named
        >>> path = MOTIONS["handheld"].sampled(rate_hz=30.0, duration_s=10.0)
        >>> representation_named("euler_best", path.poses).name
        'euler_zyx'
    """
    if name == BEST_EULER:
        if poses is None:
            raise ValueError(
                f"representation: expected of Euler angles one of {', '.join(EULER_ORDERS)} where "
                f"poses come one after another; {BEST_EULER} is decided by a whole path"
            )
        return best_euler_order(poses)
    representation = EULER_ORDERS.get(name) or REPRESENTATIONS.get(name)
    if representation is None:
        known = ", ".join(REPRESENTATION_NAMES)
        near = nearest_name(name, REPRESENTATION_NAMES)
        raise ValueError(f"representation: expected one of {known}, got {name!r}{near}")
    return representation


def restored(
    representation: Representation, coordinates: FloatArray, like: Trajectory
) -> Trajectory:
    """A trajectory of coordinates ``(N, D)`` with the stamps and frames of another.

    Where that one is rigid so is the result, whatever it was averaged as.
    """
    poses = representation.poses(coordinates)
    if isinstance(like.poses, Motor):
        poses = poses.rigid
    return Trajectory(like.time_ns, poses, like.parent, like.child)
