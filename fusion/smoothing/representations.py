"""Poses as numbers that every smoother runs on: seven ways to write a path down and to average it.

A method sees coordinates ``(*, D)`` and two verbs. ``local(x, base)`` (⊟) is the vector ``(*, d)``
from a base to `x` and ``retract(base, vector)`` (⊞) its mirror; whatever a method averages, filters
or fits are such vectors, so that it is written once. What is a straight line in them is what tells
the representations apart:

=====================  ===  ===  ==============================================================
name                    D    d   local vector
=====================  ===  ===  ==============================================================
``motor``                8    6  twist from base to pose, in the base's body frame: one screw
``similarity``          12    7  the same with the logarithm of the scale behind it
``rotor``                7    6  rotation vector in the base's body, translation in the world
``dual_quaternion``      8    8  components (signs follow), projected after every step
``quaternion``           7    7  components (signs follow), renormalised; translation apart
``euler_unwrapped``      6    6  angles made continuous over time; translation apart
``euler``                6    6  angles as they come, which leap at ±π; translation apart
=====================  ===  ===  ==============================================================

The last four are subtraction and addition, as practitioners do it. Euler angles are intrinsic
x-y′-z″; the pitch folds back at ±90° while the other two leap by half a turn, which unwrapping does
not cure. Of a path of similarities all but `similarity` carry the scale beside the rest as one more
number, last of both D and d. Rotations come first, then translations.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.classical import (
    dual_quaternion_normalize,
    nearest_branch,
    nearest_sign,
    quaternion_normalize,
)
from motorcade.ga.kernels import (
    MOTORS,
    ROTORS,
    SIMILARITIES,
    VersorKernels,
)

Poses = Motor | Similarity


class Representation(ABC):
    """A way to write poses down; see the top of this module. All methods are batched in front.

    Fields:
        name: in `REPRESENTATIONS`.
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

    name: ClassVar[str]
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
        made = [np.zeros((len(vector), 6, 6)) for _ in range(2)]
        turning = _inverse_jacobians(ROTORS, vector[..., :3])
        for whole, part, sign in zip(made, turning, (-1.0, 1.0), strict=True):
            whole[:, :3, :3], whole[:, 3:, 3:] = part, sign * np.eye(3)
        return made[0], made[1]


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
        made = components.copy()
        made[:, : self.signed] *= signs[:, None]
        return made


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


class EulerAngles(Representation):
    """Intrinsic x-y′-z″ angles as they come, each averaged for itself: at ±π they leap."""

    name = "euler"
    _rigid_size = 6

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        angles, translation = poses.astype(np.float64).as_euler_translation("xyz")
        return np.concatenate([angles, translation], axis=-1)

    def _rigid_poses(self, coordinates: FloatArray) -> Motor:
        return Motor.from_euler_translation(coordinates[..., :3], coordinates[..., 3:], "xyz")


class UnwrappedEulerAngles(EulerAngles):
    """The same angles, each made continuous over time; the pitch still folds at ±90°."""

    name = "euler_unwrapped"

    def continued(self, coordinates: FloatArray, previous: FloatArray) -> FloatArray:
        """Each angle on the branch nearest to the one before."""
        angles = nearest_branch(coordinates[..., :3], previous[..., :3])
        return np.concatenate([angles, coordinates[..., 3:]], axis=-1)

    def _rigid_coordinates(self, poses: Motor) -> FloatArray:
        made = super()._rigid_coordinates(poses)
        made[:, :3] = np.unwrap(made[:, :3], axis=0)
        return made


REPRESENTATIONS: dict[str, Representation] = {
    one.name: one
    for one in (
        MotorTwists(),
        SimilarityTwists(),
        Rotors(),
        DualQuaternions(),
        Quaternions(),
        UnwrappedEulerAngles(),
        EulerAngles(),
    )
}
"""Every representation that smoothers run on, by name."""


def representation_named(name: str) -> Representation:
    """The representation of that name.

    Raises:
        ValueError: a name that is not in `REPRESENTATIONS`; the message lists those that are.
    """
    if name not in REPRESENTATIONS:
        known = ", ".join(REPRESENTATIONS)
        raise ValueError(f"representation: expected one of {known}, got {name!r}")
    return REPRESENTATIONS[name]


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
