"""What an editor holds of an object: a similarity, or Euler angles beside position and scale.

Both know how to be turned, moved and grown about an axis of the object's own frame, its parent's
or the world. On versors each is a product, on the left or on the right: paper §3 with A.3 to A.5,
corrected (``exp(-½ φ plane)``, the planes turned along). On Euler angles a turn about an axis adds
to the angle that is named after it, as the three rings of an editor do: only the last angle turns
about the object's own axis and only the first about the parent's, so the middle one and every turn
on top of others end up somewhere else, and near ±90° of the middle one two rings turn alike.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import EulerPose, Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive, frozen

Frame = Literal["local", "parent", "global"]


class ObjectPose(ABC):
    """Where an object is in its parent; values never change, verbs return new ones.

    >>> import numpy as np
    >>> from motorcade.animation.authoring import EulerObjectPose, VersorObjectPose
    >>> from motorcade.ga import Similarity
    >>> world_T_table, up = Similarity.identity(), np.array([0.0, 0.0, 1.0])
    >>> cup = VersorObjectPose(Similarity.identity())
    >>> for pose in (cup, EulerObjectPose.from_similarity(cup.as_similarity())):
    ...     turned = pose.rotated(up, np.pi / 2, "local", world_T_table)
    ...     print(turned.as_similarity().apply([1.0, 0.0, 0.0]).round(6) + 0.0)
    [0. 1. 0.]
    [0. 1. 0.]
    """

    @abstractmethod
    def as_similarity(self) -> Similarity:
        """`parent_T_object`."""

    @abstractmethod
    def rotated(
        self, axis: FloatArray, angle_rad: float, frame: Frame, world_T_parent: Similarity
    ) -> Self:
        """Turned about the object's origin, right-handed about a unit axis of the frame."""

    @abstractmethod
    def translated(self, shift_m: FloatArray, frame: Frame, world_T_parent: Similarity) -> Self:
        """Moved by a vector of the frame, in the frame's metres."""

    @abstractmethod
    def scaled(self, factor: float) -> Self:
        """Grown about the object's origin."""

    @classmethod
    @abstractmethod
    def from_similarity(cls, parent_T_object: Similarity) -> Self:
        """The mirror of `as_similarity`."""

    @abstractmethod
    def moved(self, motion: Similarity, frame: Frame, world_T_parent: Similarity) -> Self:
        """Moved as a whole by a similarity of the frame: turned, shifted and grown at once."""

    @abstractmethod
    def towards(self, other: Self, fraction: FloatArray) -> Similarity:
        """Similarities ``(*)`` on the way to another pose, as this writing interpolates."""


@dataclass(frozen=True, eq=False)
class VersorObjectPose(ObjectPose):
    """A similarity of CGA.

    Args:
        parent_T_object: batch shape ().

    Raises:
        ValueError: a batch.

    >>> import numpy as np
    >>> from motorcade.animation.authoring import VersorObjectPose
    >>> from motorcade.ga import Similarity
    >>> small = VersorObjectPose(Similarity.identity()).scaled(0.5)
    >>> halfway = small.towards(small.scaled(4.0), np.array(0.5))
    >>> float(halfway.scale.round(6))  # even in the logarithm: the geometric mean of 0.5 and 2
    1.0
    """

    parent_T_object: Similarity

    def __post_init__(self) -> None:
        if self.parent_T_object.shape != ():
            raise ValueError(
                "VersorObjectPose: expected one similarity, got a batch of shape "
                f"{self.parent_T_object.shape}"
            )

    def as_similarity(self) -> Similarity:
        """`parent_T_object`."""
        return self.parent_T_object

    def rotated(
        self, axis: FloatArray, angle_rad: float, frame: Frame, world_T_parent: Similarity
    ) -> VersorObjectPose:
        """The rotor goes to the right of the versor in the local frame, else to its left."""
        pose = self.parent_T_object
        about = axis if frame != "global" else world_T_parent.rotor.inverse().apply(axis)
        rotor = Rotor.from_rotation_vector(angle_rad * about)
        rotated = pose.rotor @ rotor if frame == "local" else rotor @ pose.rotor
        return VersorObjectPose(pose_of(rotated, pose.translation_m, pose.scale))

    def translated(
        self, shift_m: FloatArray, frame: Frame, world_T_parent: Similarity
    ) -> VersorObjectPose:
        """A translator on the left, by the vector as the parent sees it."""
        pose = self.parent_T_object
        shift = _in_parent(shift_m, frame, pose, world_T_parent)
        return VersorObjectPose(pose_of(pose.rotor, pose.translation_m + shift, pose.scale))

    def scaled(self, factor: float) -> VersorObjectPose:
        """A dilator on the right."""
        pose = self.parent_T_object
        scaled = Similarity.from_motor_scale(Motor.identity(), factor)
        return VersorObjectPose(Similarity.normalize((pose @ scaled).coefficients))

    @classmethod
    def from_similarity(cls, parent_T_object: Similarity) -> VersorObjectPose:
        """The pose that is that similarity."""
        return cls(parent_T_object)

    def moved(
        self, motion: Similarity, frame: Frame, world_T_parent: Similarity
    ) -> VersorObjectPose:
        """The versor goes to the right in the local frame, else to the left."""
        pose = self.parent_T_object
        if frame == "local":
            product = pose @ motion
        elif frame == "parent":
            product = motion @ pose
        else:
            product = world_T_parent.inverse() @ motion @ world_T_parent @ pose
        return VersorObjectPose(pose_of(product.rotor, product.translation_m, product.scale))

    def towards(self, other: VersorObjectPose, fraction: FloatArray) -> Similarity:
        """Turned by rotors along the geodesic, moved straight, grown evenly in the logarithm."""
        a, b = self.parent_T_object, other.parent_T_object
        part = checked_floats(fraction, "towards(fraction)", ())
        rotor = a.rotor.interpolate(b.rotor, part)
        shift = part[..., None] * (b.translation_m - a.translation_m)
        scale = a.scale ** (1.0 - part) * b.scale**part
        return pose_of(rotor, a.translation_m + shift, scale)


@dataclass(frozen=True, eq=False)
class EulerObjectPose(ObjectPose):
    """Euler angles, intrinsic x-y'-z'', never wrapped, beside position and scale.

    Args:
        angles_rad: ``(3,)``.
        position_m: ``(3,)``.
        scale: above zero.

    Raises:
        ValueError: wrong shapes, NaN or infinity, a scale that is not positive.

    >>> import numpy as np
    >>> from motorcade.animation.authoring import EulerObjectPose
    >>> from motorcade.ga import Similarity
    >>> upright = EulerObjectPose(np.zeros(3), np.zeros(3))
    >>> turned = upright.rotated(np.array([0, 0, 1.0]), np.pi / 2, "local", Similarity.identity())
    >>> turned.as_similarity().apply([1.0, 0, 0]).round(6) + 0.0
    array([0., 1., 0.])
    """

    angles_rad: FloatArray
    position_m: FloatArray
    scale: float = 1.0

    def __post_init__(self) -> None:
        for name in ("angles_rad", "position_m"):
            values = checked_vector(getattr(self, name), f"EulerObjectPose.{name}")
            object.__setattr__(self, name, frozen(values))
        checked_positive(self.scale, "EulerObjectPose.scale")

    @classmethod
    def from_similarity(cls, parent_T_object: Similarity) -> EulerObjectPose:
        """Angles with the middle one within ±90°; at ±90° the last is zero."""
        angles = parent_T_object.rotor.as_euler()
        return cls(angles, parent_T_object.translation_m, float(parent_T_object.scale))

    def as_similarity(self) -> Similarity:
        """`parent_T_object`."""
        return pose_of(Rotor.from_euler(self.angles_rad), self.position_m, self.scale)

    def rotated(
        self, axis: FloatArray, angle_rad: float, frame: Frame, world_T_parent: Similarity
    ) -> EulerObjectPose:
        """The axis' components times the angle are added to the three angles, whatever the frame.

        That is what editors on Euler angles do.
        """
        return EulerObjectPose(self.angles_rad + angle_rad * axis, self.position_m, self.scale)

    def translated(
        self, shift_m: FloatArray, frame: Frame, world_T_parent: Similarity
    ) -> EulerObjectPose:
        """Moved by the vector as the parent sees it."""
        shift = _in_parent(shift_m, frame, self.as_similarity(), world_T_parent)
        return EulerObjectPose(self.angles_rad, self.position_m + shift, self.scale)

    def scaled(self, factor: float) -> EulerObjectPose:
        """The scale times the factor."""
        return EulerObjectPose(self.angles_rad, self.position_m, self.scale * factor)

    def moved(
        self, motion: Similarity, frame: Frame, world_T_parent: Similarity
    ) -> EulerObjectPose:
        """Where a versor would be, with the angles of that."""
        versor = VersorObjectPose(self.as_similarity()).moved(motion, frame, world_T_parent)
        return EulerObjectPose.from_similarity(versor.parent_T_object)

    def towards(self, other: EulerObjectPose, fraction: FloatArray) -> Similarity:
        """Angles, position and scale each interpolated straight."""
        part = checked_floats(fraction, "towards(fraction)", ())[..., None]
        start = EulerPose(np.concatenate([self.angles_rad, self.position_m]))
        end = EulerPose(np.concatenate([other.angles_rad, other.position_m]))
        angles = (1.0 - part) * start.angles_rad + part * end.angles_rad
        position = (1.0 - part) * start.translation_m + part * end.translation_m
        scale = (1.0 - part[..., 0]) * self.scale + part[..., 0] * other.scale
        return pose_of(Rotor.from_euler(angles), position, scale)


def pose_of(rotor: Rotor, position_m: FloatArray, scale: FloatArray | float) -> Similarity:
    """A pose by its parts, the rotor at length 1."""
    unit = Rotor.normalize(rotor.coefficients)
    return Similarity.from_rotor_translation_scale(unit, position_m, scale)


def checked_vector(value: ArrayLike, name: str) -> FloatArray:
    """One vector ``(3,)`` of finite numbers. Raises ValueError: anything else."""
    values = checked_floats(value, name, (3,))
    if values.shape != (3,):
        raise ValueError(f"{name}: expected (3,), got {values.shape}")
    return values


def _in_parent(
    shift_m: FloatArray, frame: Frame, pose: Similarity, world_T_parent: Similarity
) -> FloatArray:
    """A vector of a frame as the parent sees it."""
    if frame == "local":
        return pose.rotor.apply(shift_m) * pose.scale
    if frame == "parent":
        return shift_m
    return world_T_parent.rotor.inverse().apply(shift_m) / world_T_parent.scale
