"""What the classical poses share besides `CoefficientBatch`: the names of the verbs.

The names are those of the versors, so that one test or one benchmark runs on all of them; what a
verb does is each kind's own. ``a @ b`` applies ``b`` first. Metres and radians.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import (
    CoefficientBatch,
    FloatArray,
    broadcast_batch,
    checked_floats,
    frozen,
)
from motorcade.ga.classical.quaternion import quaternion_as_matrix, quaternion_from_matrix


def checked_method(what: str, method: str, allowed: tuple[str, ...]) -> str:
    """The method, or ValueError that lists those there are."""
    if method not in allowed:
        raise ValueError(f"{what}(method): expected one of {', '.join(allowed)}, got {method!r}")
    return method


@dataclass(frozen=True, eq=False, repr=False)
class Pose(CoefficientBatch):
    """Rotation and translation of rigid bodies, batch in the leading dimensions.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or not normalised.

    Examples:
        >>> from motorcade.ga.classical import EulerPose, Pose, QuaternionPose
        >>> world_T_camera = QuaternionPose.identity((3,))
        >>> isinstance(world_T_camera, Pose), len(world_T_camera), world_T_camera[0].shape
        (True, 3, ())
    """

    def __post_init__(self) -> None:
        name = f"{type(self).__name__}.coefficients"
        values = checked_floats(self.coefficients, name, (self._size,))
        self._check(values)
        object.__setattr__(self, "coefficients", frozen(values))

    @abstractmethod
    def _check(self, coefficients: FloatArray) -> None:
        """Raise ValueError where coefficients are no pose."""

    @classmethod
    def _check_alike(cls, what: str, *values: Self) -> None:
        for value in values[1:]:
            values[0]._check_same(value)

    def _batch(self, verb: str, *shapes: tuple[int, ...]) -> None:
        broadcast_batch(f"{type(self).__name__}{verb}", self.shape, *shapes)

    def _check_same(self, other: Self) -> None:
        if type(other) is not type(self):
            raise TypeError(
                f"expected two poses of type {type(self).__name__}, got {type(other).__name__}"
            )

    def __matmul__(self, other: Self) -> Self:
        """Compose: ``(a @ b).apply(x) == a.apply(b.apply(x))``. Batches broadcast."""
        if type(other) is not type(self):
            return NotImplemented
        self._check_same(other)
        self._batch(f" @ {type(self).__name__}", other.shape)
        return self._like(self._compose(other))

    @abstractmethod
    def _compose(self, other: Self) -> FloatArray: ...

    @abstractmethod
    def inverse(self) -> Self:
        """The motion undone."""

    @abstractmethod
    def log(self) -> FloatArray:
        """Coordinates ``(*, 6)`` in which this kind of pose is scaled and added."""

    def retract(self, step: ArrayLike) -> Self:
        """Move by a step ``(*, 6)``: rotation (rad), then translation (m). The mirror of `local`.

        ``a.retract(fraction * a.local(b))`` is ``a.interpolate(b, fraction)`` with its defaults.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, batches that do not broadcast.
        """
        steps = checked_floats(step, f"{type(self).__name__}.retract(step)", (6,))
        self._batch(".retract", steps.shape[:-1])
        return self._like(self._retracted(steps))

    @abstractmethod
    def _retracted(self, step: FloatArray) -> FloatArray: ...

    def local(self, other: Self) -> FloatArray:
        """The step ``(*, 6)`` from this pose to `other`: rotation (rad), then translation (m).

        What is a straight line in these steps is what tells the kinds apart: `QuaternionPose`
        turns in the body and moves in the world, `DualQuaternion` follows one twist as motors do,
        `EulerPose` subtracts angles as they are.

        Raises:
            TypeError: another type of pose.
            ValueError: batches that do not broadcast, two sequences of Euler angles.
        """
        self._check_same(other)
        self._batch(".local", other.shape)
        return self._local(other)

    @abstractmethod
    def _local(self, other: Self) -> FloatArray: ...

    @classmethod
    def identity(cls, shape: tuple[int, ...] = ()) -> Self:
        """No motion, repeated over the batch `shape`."""
        return cls(np.broadcast_to(np.eye(cls._size)[0], (*shape, cls._size)))

    @classmethod
    def random(
        cls, rng: np.random.Generator, shape: tuple[int, ...] = (), extent_m: float = 1.0
    ) -> Self:
        """Uniform orientations, normal translations with deviation `extent_m` an axis."""
        return cls.from_quaternion_translation(*random_pose(rng, shape, extent_m))

    @classmethod
    @abstractmethod
    def from_quaternion_translation(cls, wxyz: ArrayLike, translation_m: ArrayLike) -> Self:
        """From unit quaternions ``(*, 4)`` and translations ``(*, 3)``; batches broadcast."""

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Self:
        """From homogeneous matrices ``(*, 4, 4)``, taken for rigid as practitioners do."""
        matrices = checked_floats(matrix, f"{cls.__name__}.from_matrix(matrix)", (4, 4))
        rotation, translation_m = matrices[..., :3, :3], matrices[..., :3, 3]
        return cls.from_quaternion_translation(quaternion_from_matrix(rotation), translation_m)

    @abstractmethod
    def as_quaternion_translation(self) -> tuple[FloatArray, FloatArray]:
        """Unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)`` in metres."""

    @abstractmethod
    def apply(self, points: ArrayLike) -> FloatArray:
        """Move points ``(*, 3)`` in metres; batch shapes broadcast."""

    def as_matrix(self) -> FloatArray:
        """Homogeneous matrices ``(*, 4, 4)`` that act on columns."""
        q, t = self.as_quaternion_translation()
        matrix = np.zeros((*self.shape, 4, 4))
        matrix[..., :3, :3] = quaternion_as_matrix(q)
        matrix[..., :3, 3] = t
        matrix[..., 3, 3] = 1.0
        return matrix

    def _checked_points(self, points: ArrayLike) -> FloatArray:
        x = checked_floats(points, f"{type(self).__name__}.apply(points)", (3,))
        self._batch(".apply", x.shape[:-1])
        return x

    def _checked_fraction(self, other: Self, fraction: ArrayLike) -> FloatArray:
        self._check_same(other)
        steps = checked_floats(fraction, f"{type(self).__name__}.interpolate(fraction)", ())
        self._batch(".interpolate", other.shape, steps.shape)
        return steps

    def _checked_weights(self, weights: ArrayLike) -> FloatArray:
        """Weights ``(*, K)`` for the last batch dimension, broadcast over the others."""
        name = type(self).__name__
        share = checked_floats(weights, f"{name}.blend(weights)", ())
        if not self.shape or share.ndim == 0 or share.shape[-1] != self.shape[-1]:
            raise ValueError(
                f"{name}.blend(weights): expected (*, K) for poses of shape (*, K), got "
                f"{share.shape} for {self.shape}"
            )
        self._batch(".blend", share.shape)
        total = np.sum(share, axis=-1)
        if not np.all(np.abs(total) > 0.0):
            raise ValueError(f"{name}.blend(weights): expected sums other than 0, got 0")
        return np.broadcast_to(share, np.broadcast_shapes(share.shape, self.shape))


def random_pose(
    rng: np.random.Generator, shape: tuple[int, ...], extent_m: float
) -> tuple[FloatArray, FloatArray]:
    """Quaternions drawn uniformly, translations normal with deviation `extent_m` an axis."""
    q = rng.standard_normal((*shape, 4))
    return (
        q / np.linalg.norm(q, axis=-1, keepdims=True),
        extent_m * rng.standard_normal((*shape, 3)),
    )
