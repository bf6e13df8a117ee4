"""The verbs that every versor type shares: build, stack, index, compose, invert, log, interpolate.

A versor acts by ``X' = S X ~S``; ``a @ b`` applies ``b`` first. ``S`` and ``-S`` are one motion.
Leading dimensions are batch and broadcast as NumPy arrays do; values are frozen.

Coefficients are float64; versors made of a float32 array are and stay float32, and so is all that
they compute. Versors of different precision do not mix; `astype` converts.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, ClassVar, NamedTuple, Self, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from motorcade.ga.arrays import FloatArray, checked_floats

__all__ = ["UNIT_TOLERANCE", "Versor", "VersorKernels", "broadcast_batch"]

# How far from 1 the norm of given coefficients may be before they are refused.
UNIT_TOLERANCE = 1e-6
_UNIT_TOLERANCE_SINGLE = 1e-5
# Below this sine of half the angle the long way round has lost its axis.
_LONG_WAY_SINE = 1e-7


def broadcast_batch(what: str, *shapes: tuple[int, ...]) -> tuple[int, ...]:
    """Return the common batch shape, or raise ValueError that names `what` and the shapes."""
    first = shapes[0]
    if all(shape == first or not shape for shape in shapes):  # NumPy takes longer to find out
        return first
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        listed = " and ".join(map(str, shapes))
        raise ValueError(
            f"{what}: expected batch shapes that broadcast together, got {listed}"
        ) from None


class VersorKernels(NamedTuple):
    """What a versor type computes with, on coefficient arrays whose batches broadcast."""

    compose: Callable[[FloatArray, FloatArray], FloatArray]
    inverse: Callable[[FloatArray], FloatArray]
    exp: Callable[[FloatArray], FloatArray]
    log: Callable[[FloatArray], FloatArray]
    interpolate: Callable[[FloatArray, FloatArray, FloatArray, bool], FloatArray]


@dataclass(frozen=True, eq=False, repr=False)
class Versor(ABC):
    """Unit versors, batch in the leading dimensions of `coefficients`.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or a norm more than 1e-6 from 1.
    """

    coefficients: FloatArray

    # NumPy arrays must not try to broadcast over a versor: array @ versor is a TypeError.
    __array_ufunc__: ClassVar[None] = None
    _size: ClassVar[int]
    _log_size: ClassVar[int]
    _kernels: ClassVar[VersorKernels]

    def __post_init__(self) -> None:
        given = self._checked(self.coefficients, self._field("coefficients"), (self._size,))
        self._check_unit(given)
        own = np.array(given, order="C", copy=True)
        own.setflags(write=False)
        object.__setattr__(self, "coefficients", own)

    @classmethod
    def _field(cls, name: str) -> str:
        return f"{cls.__name__}.{name}"

    @classmethod
    def _checked(cls, value: ArrayLike, name: str, trailing: tuple[int, ...]) -> FloatArray:
        """Checked numbers, in float32 where an array of that type was given."""
        checked = checked_floats(value, name, trailing)
        return np.asarray(value) if getattr(value, "dtype", None) == np.float32 else checked

    @classmethod
    def _tolerance(cls, coefficients: FloatArray) -> float:
        """How far from unit given coefficients may be in their precision."""
        return UNIT_TOLERANCE if coefficients.dtype == np.float64 else _UNIT_TOLERANCE_SINGLE

    @classmethod
    def _check_unit(cls, coefficients: FloatArray) -> None:
        with np.errstate(over="ignore"):  # an infinite norm is refused like any other
            norm = np.sqrt(np.sum(coefficients[..., :4] ** 2, axis=-1))
        worst = float(np.max(np.abs(norm - 1.0), initial=0.0))
        tolerance = cls._tolerance(coefficients)
        if worst > tolerance:
            raise ValueError(
                f"{cls._field('coefficients')}: expected unit versors (norm within "
                f"{tolerance:g} of 1), got a norm off by {worst:.3g}; "
                f"{cls.__name__}.normalize projects other even elements"
            )

    @classmethod
    def _trusted(cls, coefficients: FloatArray) -> Self:
        """Wrap coefficients that a kernel has just made; they are frozen in place, not copied."""
        made = object.__new__(cls)
        coefficients.setflags(write=False)
        object.__setattr__(made, "coefficients", coefficients)
        return made

    # Building ----------------------------------------------------------------------------------

    @classmethod
    def identity(cls, shape: tuple[int, ...] = ()) -> Self:
        """The motion that leaves everything where it is, repeated over the batch `shape`."""
        coefficients = np.zeros((*shape, cls._size))
        coefficients[..., 0] = 1.0
        return cls._trusted(coefficients)

    @classmethod
    def exp(cls, log: ArrayLike) -> Self:
        """Versors from bivectors, the mirror of `log`.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        given = cls._checked(log, cls._field("exp(log)"), (cls._log_size,))
        return cls._trusted(cls._kernels.exp(given))

    @classmethod
    @abstractmethod
    def normalize(cls, coefficients: ArrayLike) -> Self:
        """Project even elements onto unit versors; zero is refused with ValueError."""

    @classmethod
    def stack(cls, versors: Sequence[Self]) -> Self:
        """Join versors of equal shape along a new leading dimension."""
        if not versors:
            raise ValueError(f"{cls._field('stack')}: expected at least one versor, got none")
        cls._check_precision(cls._field("stack"), *versors)
        return cls._trusted(np.stack([one.coefficients for one in versors]))

    @classmethod
    def concatenate(cls, versors: Sequence[Self]) -> Self:
        """Join batches along their first dimension."""
        if not versors or any(not one.shape for one in versors):
            raise ValueError(
                f"{cls._field('concatenate')}: expected one or more batches with a leading "
                f"dimension, got shapes {[one.shape for one in versors]}; stack joins single ones"
            )
        cls._check_precision(cls._field("concatenate"), *versors)
        return cls._trusted(np.concatenate([one.coefficients for one in versors]))

    # Batch -------------------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape, without the dimension of coefficients."""
        return self.coefficients.shape[:-1]

    @property
    def dtype(self) -> np.dtype[Any]:
        """The precision of the coefficients, float32 or float64."""
        precision: np.dtype[Any] = self.coefficients.dtype
        return precision

    def astype(self, dtype: DTypeLike) -> Self:
        """The same versors in float32 or float64.

        Raises:
            ValueError: another type.
        """
        wanted = np.dtype(dtype)
        if wanted not in (np.float32, np.float64):
            raise ValueError(f"{self._field('astype')}: expected float32 or float64, got {wanted}")
        return self._trusted(self.coefficients.astype(wanted))

    @classmethod
    def _check_precision(cls, what: str, *versors: Self) -> None:
        names = {one.coefficients.dtype.name for one in versors}
        if len(names) > 1:
            raise TypeError(
                f"{what}: expected versors of one precision, got {' and '.join(sorted(names))}; "
                "astype converts"
            )

    def reshape(self, *shape: int) -> Self:
        """The same versors in another batch shape; one dimension may be -1."""
        return self._trusted(self.coefficients.reshape(*shape, self._size))

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError(f"a single {type(self).__name__} has no length")
        return self.shape[0]

    def __getitem__(self, index: Any) -> Self:
        """Index the batch dimensions as a NumPy array; the coefficients stay together."""
        whole = index if isinstance(index, tuple) else (index,)
        if not self.shape and whole != (Ellipsis,) and whole != ():
            raise IndexError(f"a single {type(self).__name__} has no batch to index")
        with_rest = whole if any(part is Ellipsis for part in whole) else (*whole, Ellipsis)
        return self._trusted(self.coefficients[(*with_rest, slice(None))])

    def __iter__(self) -> Iterator[Self]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        if self.shape:
            return f"{type(self).__name__}(shape={self.shape})"
        return f"{type(self).__name__}({self.coefficients.tolist()})"

    def __reduce_ex__(self, protocol: SupportsIndex) -> tuple[Any, ...]:
        """Rebuild through the constructor, so copies sent to other processes stay read-only."""
        return type(self), (np.array(self.coefficients),)

    # Algebra -----------------------------------------------------------------------------------

    def __matmul__(self, other: Self) -> Self:
        """Compose: ``(a @ b).apply(x) == a.apply(b.apply(x))``. Batches broadcast."""
        if type(other) is not type(self):
            return NotImplemented
        name = f"{type(self).__name__} @ {type(self).__name__}"
        broadcast_batch(name, self.shape, other.shape)
        if other.coefficients.dtype != self.coefficients.dtype:
            self._check_precision(name, self, other)
        return self._trusted(self._kernels.compose(self.coefficients, other.coefficients))

    def inverse(self) -> Self:
        """The motion undone: ``m @ m.inverse()`` is the identity."""
        return self._trusted(self._kernels.inverse(self.coefficients))

    def log(self) -> FloatArray:
        """Bivector whose `exp` is this versor or its negative, the one that turns by at most π.

        Near zero and near π it keeps full precision. A turn by exactly π has two logarithms of
        equal length; the sign of the stored coefficients then says which one is returned.
        """
        return self._kernels.log(self.coefficients)

    @abstractmethod
    def apply(self, points: ArrayLike) -> FloatArray:
        """Move points ``(*, 3)``; batch shapes broadcast."""

    def interpolate(self, other: Self, fraction: ArrayLike, short_way: bool = True) -> Self:
        """Constant-speed path ``self exp(fraction log(~self other))``, the screw between the two.

        Args:
            other: where fraction 1 arrives (up to the versor's sign).
            fraction: any real number; it broadcasts with both batches, values outside [0, 1]
                extrapolate.
            short_way: turn by at most π. Otherwise the path follows the sign of the coefficients
                as they stand and may turn by up to 2π.

        Raises:
            TypeError: another type of versor, or of another precision.
            ValueError: NaN or infinite fraction, batches that do not broadcast, or the long way
                between two equal orientations of opposite sign, which has no axis.
        """
        name = f"{type(self).__name__}.interpolate"
        if type(other) is not type(self):
            raise TypeError(
                f"{name}(other): expected a {type(self).__name__}, got {type(other).__name__}"
            )
        steps = self._fractions(fraction, f"{name}(fraction)")
        broadcast_batch(name, self.shape, other.shape, steps.shape)
        if other.coefficients.dtype != self.coefficients.dtype:
            self._check_precision(name, self, other)
        if not short_way:
            self._check_long_way(other, name)
        return self._trusted(
            self._kernels.interpolate(self.coefficients, other.coefficients, steps, short_way)
        )

    def _fractions(self, fraction: Any, name: str) -> FloatArray:
        """Checked fractions in this precision."""
        if isinstance(fraction, float) and isfinite(fraction):  # most often, and much faster
            return np.asarray(fraction, dtype=self.coefficients.dtype)
        return checked_floats(fraction, name, ()).astype(self.coefficients.dtype, copy=False)

    def _check_long_way(self, other: Self, name: str) -> None:
        between = (self.inverse() @ other).coefficients
        sine = np.sqrt(np.sum(between[..., 1:4] ** 2, axis=-1))
        lost = int(np.count_nonzero((between[..., 0] < 0.0) & (sine < _LONG_WAY_SINE)))
        if lost:
            raise ValueError(
                f"{name}(short_way=False): expected a defined axis, got {lost} pairs of equal "
                "orientation and opposite sign"
            )
