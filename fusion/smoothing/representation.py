"""What a smoother asks of a representation: coordinates of poses, and two verbs between them.

A method sees coordinates ``(*, D)``. ``local(x, base)`` (⊟) is the vector ``(*, d)`` from a base to
`x` and ``retract(base, vector)`` (⊞) its mirror; whatever a method averages, filters or fits are
such vectors, so that it is written once. `motorcade.fusion.smoothing.representations` lists them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, TypeVar

import numpy as np

from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray

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
