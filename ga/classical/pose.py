"""What the classical poses share: frozen coefficients, batch in front, and the names of the verbs.

The names are those of the versors, so that one test or one benchmark runs on all of them; what a
verb does is each kind's own. ``a @ b`` applies ``b`` first. Metres and radians.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats, frozen
from motorcade.ga.classical.quaternion import quaternion_as_matrix, quaternion_from_matrix

__all__ = ["UNIT_TOLERANCE", "Pose", "checked_method", "random_pose", "split_matrix"]

UNIT_TOLERANCE = 1e-6


def checked_method(what: str, method: str, allowed: tuple[str, ...]) -> str:
    """The method, or ValueError that lists those there are."""
    if method not in allowed:
        raise ValueError(f"{what}(method): expected one of {', '.join(allowed)}, got {method!r}")
    return method


@dataclass(frozen=True, eq=False, repr=False)
class Pose(ABC):
    """Rotation and translation of rigid bodies, batch in the leading dimensions.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or not normalised.

    Examples:
        >>> from motorcade.ga.classical import EulerPose, Pose, QuaternionPose
        >>> world_T_camera = QuaternionPose.identity((3,))
        >>> isinstance(world_T_camera, Pose), len(world_T_camera), world_T_camera[0].shape
        (True, 3, ())
    """

    coefficients: FloatArray

    # NumPy arrays must not try to broadcast over a pose: array @ pose is a TypeError.
    __array_ufunc__: ClassVar[None] = None
    _size: ClassVar[int]

    def __post_init__(self) -> None:
        name = f"{type(self).__name__}.coefficients"
        given = checked_floats(self.coefficients, name, (self._size,))
        self._check(given)
        object.__setattr__(self, "coefficients", frozen(given))

    @abstractmethod
    def _check(self, coefficients: FloatArray) -> None:
        """Raise ValueError where coefficients are no pose."""

    def _like(self, coefficients: FloatArray) -> Self:
        """The same kind of pose around coefficients that were just made."""
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__)
        coefficients.setflags(write=False)
        object.__setattr__(made, "coefficients", coefficients)
        return made

    def _batch(self, verb: str, *shapes: tuple[int, ...]) -> None:
        try:
            np.broadcast_shapes(self.shape, *shapes)
        except ValueError:
            listed = " and ".join(map(str, (self.shape, *shapes)))
            raise ValueError(
                f"{type(self).__name__}{verb}: expected batch shapes that broadcast together, "
                f"got {listed}"
            ) from None

    # Batch -------------------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape, without the dimension of coefficients."""
        return self.coefficients.shape[:-1]

    def reshape(self, *shape: int) -> Self:
        """The same poses in another batch shape; one dimension may be -1."""
        return self._like(self.coefficients.reshape(*shape, self._size))

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError(f"a single {type(self).__name__} has no length")
        return self.shape[0]

    def __getitem__(self, index: Any) -> Self:
        """Index the batch dimensions as a NumPy array; the coefficients stay together."""
        whole = index if isinstance(index, tuple) else (index,)
        if not self.shape and whole not in ((Ellipsis,), ()):
            raise IndexError(f"a single {type(self).__name__} has no batch to index")
        with_rest = whole if any(part is Ellipsis for part in whole) else (*whole, Ellipsis)
        return self._like(self.coefficients[(*with_rest, slice(None))])

    def __iter__(self) -> Iterator[Self]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        if self.shape:
            return f"{type(self).__name__}(shape={self.shape})"
        return f"{type(self).__name__}({self.coefficients.tolist()})"

    def __reduce_ex__(self, protocol: SupportsIndex) -> tuple[Any, ...]:
        """Rebuild through the constructor, so copies sent to other processes stay read-only."""
        rest = (value for name, value in self.__dict__.items() if name != "coefficients")
        return type(self), (np.array(self.coefficients), *rest)

    @classmethod
    def stack(cls, poses: Sequence[Self]) -> Self:
        """Join poses of equal shape along a new leading dimension."""
        if not poses:
            raise ValueError(f"{cls.__name__}.stack: expected at least one pose, got none")
        for one in poses[1:]:
            poses[0]._check_same(one)
        return poses[0]._like(np.stack([one.coefficients for one in poses]))

    @classmethod
    def concatenate(cls, poses: Sequence[Self]) -> Self:
        """Join batches along their first dimension."""
        if not poses or any(not one.shape for one in poses):
            raise ValueError(
                f"{cls.__name__}.concatenate: expected one or more batches with a leading "
                f"dimension, got shapes {[one.shape for one in poses]}; stack joins single ones"
            )
        for one in poses[1:]:
            poses[0]._check_same(one)
        return poses[0]._like(np.concatenate([one.coefficients for one in poses]))

    # Verbs -------------------------------------------------------------------------------------

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


def split_matrix(name: str, matrix: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Quaternions ``(*, 4)`` and translations ``(*, 3)`` of matrices ``(*, 4, 4)``.

    The upper left block is taken for a rotation, as practitioners do.
    """
    given = checked_floats(matrix, f"{name}.from_matrix(matrix)", (4, 4))
    return quaternion_from_matrix(given[..., :3, :3]), given[..., :3, 3]


def random_pose(
    rng: np.random.Generator, shape: tuple[int, ...], extent_m: float
) -> tuple[FloatArray, FloatArray]:
    """Quaternions drawn uniformly, translations normal with deviation `extent_m` an axis."""
    q = rng.standard_normal((*shape, 4))
    return (
        q / np.linalg.norm(q, axis=-1, keepdims=True),
        extent_m * rng.standard_normal((*shape, 3)),
    )
