"""Batches of versors as arrays of them: checked when made, frozen, indexed, joined, compared.

Leading dimensions are batch and broadcast as those of NumPy arrays do.

One rule for precision. Arrays and versors are float32 or float64; Python's numbers and lists have
no precision of their own.

- Whatever makes versors (the constructor, ``from_…``, `exp`, `normalize`) makes float32 ones where
  all arrays and versors that it is given are float32, float64 ones otherwise.
- Verbs keep the versor's precision: arrays handed to them (points, twists, fractions) are taken in
  it, and what they return is in it.
- Verbs between versors of different precision raise TypeError; `astype` converts.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from motorcade.ga.arrays import FloatArray, checked_floats, common_precision, sealed

__all__ = ["UNIT_TOLERANCE", "VersorBatch", "broadcast_batch"]

# How far from 1 the norm of given coefficients may be before they are refused.
UNIT_TOLERANCE = 1e-6
_UNIT_TOLERANCE_SINGLE = 1e-5


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


@dataclass(frozen=True, eq=False, repr=False)
class VersorBatch(ABC):
    """Unit versors, batch in the leading dimensions of `coefficients`.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or a norm more than 1e-6 from 1.
    """

    coefficients: FloatArray

    # NumPy arrays must not try to broadcast over a versor: array @ versor is a TypeError.
    __array_ufunc__: ClassVar[None] = None
    _size: ClassVar[int]

    def __post_init__(self) -> None:
        given = self._checked(self.coefficients, self._field("coefficients"), (self._size,))
        self._check_unit(given)
        own = np.array(given, order="C", copy=True)
        object.__setattr__(self, "coefficients", sealed(own))

    @classmethod
    def _field(cls, name: str) -> str:
        return f"{cls.__name__}.{name}"

    @classmethod
    def _checked(cls, value: ArrayLike, name: str, trailing: tuple[int, ...]) -> FloatArray:
        """Checked numbers in the precision that they were given in."""
        checked = checked_floats(value, name, trailing)
        return checked.astype(common_precision(value), copy=False)

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
        object.__setattr__(made, "coefficients", sealed(coefficients))
        return made

    @classmethod
    def _of(cls, coefficients: FloatArray, *given: Any) -> Self:
        """Wrap what has just been computed from some inputs, in their common precision."""
        return cls._trusted(coefficients.astype(common_precision(*given), copy=False))

    @classmethod
    def identity(cls, shape: tuple[int, ...] = (), dtype: DTypeLike = np.float64) -> Self:
        """The motion that leaves everything where it is, repeated over the batch `shape`.

        Raises:
            ValueError: a dtype that is neither float32 nor float64.
        """
        precision = cls._precision(dtype, "identity")
        coefficients = np.zeros((*shape, cls._size), dtype=precision)
        coefficients[..., 0] = 1.0
        return cls._trusted(coefficients)

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
        return self._trusted(self.coefficients.astype(self._precision(dtype, "astype")))

    @classmethod
    def _precision(cls, dtype: DTypeLike, verb: str) -> np.dtype[Any]:
        wanted = np.dtype(dtype)
        if wanted not in (np.float32, np.float64):
            raise ValueError(f"{cls._field(verb)}: expected float32 or float64, got {wanted}")
        return wanted

    def isclose(self, other: Self, rtol: float = 1e-5, atol: float = 1e-8) -> NDArray[np.bool_]:
        """Whether versors are the same motion to a tolerance, ``(*)`` bools; batches broadcast.

        As ``np.isclose``, on the largest difference of coefficients against the largest
        coefficient of `other`, whose sign is chosen: ``S`` and ``-S`` are one motion.

        Raises:
            TypeError: another type of versor, or of another precision.
            ValueError: batches that do not broadcast.
        """
        name = self._field("isclose")
        self._check_partner(other, name)
        a, b = self.coefficients, other.coefficients
        apart = np.minimum(*(np.max(np.abs(a - sign * b), axis=-1) for sign in (1, -1)))
        close: NDArray[np.bool_] = apart <= atol + rtol * np.max(np.abs(b), axis=-1)
        return close

    def __eq__(self, other: object) -> bool:
        raise TypeError(
            f"{type(self).__name__}: == is not defined, as S and -S are one motion and numbers "
            "round; isclose compares motions, coefficients compare as arrays"
        )

    def __hash__(self) -> int:
        # Not None: dataclasses take that for a sign of values that change, and refuse defaults.
        raise TypeError(f"unhashable type: {type(self).__name__}")

    def _check_partner(self, other: Self, name: str) -> None:
        """Another versor of this type and precision, whose batch goes with this one."""
        if type(other) is not type(self):
            raise TypeError(
                f"{name}(other): expected a {type(self).__name__}, got {type(other).__name__}"
            )
        broadcast_batch(name, self.shape, other.shape)
        if other.coefficients.dtype != self.coefficients.dtype:
            self._check_precision(name, self, other)

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
