"""Checked, read-only float arrays, of which all values are made, and `CoefficientBatch`, the base
of batches of versors and of classical poses.

Leading dimensions are batch, trailing dimensions are fixed by the value's type. Nothing is
repaired here: an array that does not fit is refused with its name, what was expected, what came.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self, SupportsFloat, SupportsIndex, cast

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

__all__ = [
    "UNIT_TOLERANCE",
    "CoefficientBatch",
    "FloatArray",
    "IntArray",
    "broadcast_batch",
    "checked_floats",
    "checked_number",
    "checked_positive",
    "common_precision",
    "frozen",
    "given_floats",
    "sealed",
    "shape_text",
]

# How far from 1 the norm of given coefficients may be before they are refused.
UNIT_TOLERANCE = 1e-6
_SINGLE, _DOUBLE = np.dtype(np.float32), np.dtype(np.float64)


def shape_text(trailing: tuple[int, ...]) -> str:
    """Write trailing dimensions as ``(*, 4)``, the way the documentation does."""
    return "(" + ", ".join(["*", *map(str, trailing)]) + ")"


def checked_floats(value: ArrayLike, name: str, trailing: tuple[int, ...]) -> FloatArray:
    """Convert to float64 and check the trailing dimensions and that every number is finite.

    Args:
        value: anything NumPy reads as real numbers, shape ``(*, *trailing)``.
        name: what the caller calls it; it opens the error message.
        trailing: the fixed trailing dimensions; ``()`` allows any shape.

    Returns:
        A float64 array, the caller's own memory where no conversion was needed.

    Raises:
        ValueError: not real numbers, wrong trailing dimensions, or NaN or infinity inside.
    """
    array = np.asarray(_numbers(value, name), dtype=np.float64)
    _check_shape(array, name, trailing)
    if not np.isfinite(array).all():
        bad = int(array.size - np.count_nonzero(np.isfinite(array)))
        raise ValueError(
            f"{name}: expected finite numbers, got {bad} NaN or infinite of {array.size}"
        )
    return array


def given_floats(value: ArrayLike, name: str, trailing: tuple[int, ...]) -> FloatArray:
    """As `checked_floats`, but what is of float32 stays so, and NaN and infinity are let through.

    For what a kernel checks on its way: where it finds something, `checked_floats` says what.
    """
    if type(value) is np.ndarray and (value.dtype is _DOUBLE or value.dtype is _SINGLE):
        array = value
    else:
        array = _numbers(value, name)
        single = array.dtype == _SINGLE and hasattr(value, "dtype")
        array = array.astype(_SINGLE if single else _DOUBLE, copy=False)
    _check_shape(array, name, trailing)
    return array


def _numbers(value: ArrayLike, name: str) -> NDArray[Any]:
    if isinstance(value, CoefficientBatch):  # a rotor's are not those of a quaternion
        problem = f"{name}: expected numbers, got a {type(value).__name__}"
        raise ValueError(f"{problem}, which as_… converts; its own are its coefficients")
    try:
        values = np.asarray(value)
    except ValueError as ragged:
        raise ValueError(f"{name}: expected a regular array of numbers, {ragged}") from ragged
    if values.dtype.kind not in "fiub":
        raise ValueError(f"{name}: expected real numbers, got dtype {values.dtype}")
    return values


def _check_shape(array: FloatArray, name: str, trailing: tuple[int, ...]) -> None:
    if not trailing:
        return
    kept = array.ndim - len(trailing)
    if kept < 0 or array.shape[kept:] != trailing:
        raise ValueError(f"{name}: expected shape {shape_text(trailing)}, got {array.shape}")


def common_precision(*inputs: Any) -> np.dtype[Any]:
    """float32 where every array among the inputs is of float32, else float64.

    Whatever has a ``dtype`` counts as an array; Python's numbers and lists have no precision.
    """
    kinds = {np.dtype(one.dtype) for one in inputs if hasattr(one, "dtype")}
    return np.dtype(np.float32 if kinds == {np.dtype(np.float32)} else np.float64)


def checked_number(value: object, name: str) -> float:
    """One real number, as Python's or as a single one of NumPy's; True and False are none.

    Raises:
        TypeError: another kind of thing.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    single = isinstance(value, SupportsFloat) and getattr(value, "ndim", 0) == 0
    if not single or np.asarray(value).dtype.kind not in "fiuO":
        raise TypeError(f"{name}: expected a number, got {type(value).__name__}")
    return float(cast(SupportsFloat, value))


def checked_positive(value: float, name: str, unit: str = "") -> float:
    """A finite number above 0.

    Raises:
        ValueError: another one.
        TypeError: no number.
    """
    checked_number(value, name)
    if not 0.0 < value < np.inf:
        expected = f"a positive number of {unit}" if unit else "a number above 0"
        raise ValueError(f"{name}: expected {expected}, got {value}")
    return float(value)


def frozen(array: FloatArray) -> FloatArray:
    """Return a read-only copy in C order; the array that came in stays as it was."""
    return sealed(np.array(array, dtype=np.float64, order="C", copy=True))


def sealed(array: FloatArray) -> FloatArray:
    """The array, read-only so that NumPy refuses to make it writable again; it is not copied.

    NumPy lets the owner of memory take its flag back, and a view only where its owner is writable.
    """
    array.setflags(write=False)
    base = array.base
    if base is None:
        return array.view()
    if isinstance(base, np.ndarray):
        base.setflags(write=False)
    return array


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
class CoefficientBatch(ABC):
    """An array of values by their coefficients: indexed, joined and shaped as NumPy arrays are."""

    coefficients: FloatArray

    # NumPy arrays must not try to broadcast over a value: array @ value is a TypeError.
    __array_ufunc__: ClassVar[None] = None
    _size: ClassVar[int]

    def _like(self, coefficients: FloatArray) -> Self:
        """The same kind of value around coefficients just made; they are frozen, not copied."""
        versor = object.__new__(type(self))
        versor.__dict__.update(self.__dict__)
        object.__setattr__(versor, "coefficients", sealed(coefficients))
        return versor

    @classmethod
    @abstractmethod
    def _check_alike(cls, what: str, *values: Self) -> None:
        """Raise TypeError or ValueError where values are not all of one sort."""

    @classmethod
    def _field(cls, name: str) -> str:
        return f"{cls.__name__}.{name}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape, without the dimension of coefficients."""
        return self.coefficients.shape[:-1]

    def __array__(
        self, dtype: DTypeLike | None = None, copy: bool | None = None
    ) -> NDArray[np.floating[Any]]:
        """The coefficients ``(*, n)``, for NumPy's functions."""
        return np.array(self.coefficients, dtype, copy=copy)

    def reshape(self, *shape: int | tuple[int, ...]) -> Self:
        """The same values in another batch shape, as numbers or a tuple; one of them may be -1."""
        batch = shape[0] if len(shape) == 1 and isinstance(shape[0], tuple) else shape
        whole = (*cast(tuple[int, ...], batch), self._size)
        return self._like(self.coefficients.reshape(whole))

    @classmethod
    def stack(cls, values: Sequence[Self]) -> Self:
        """Join values of equal shape along a new leading dimension."""
        if not values:
            raise ValueError(f"{cls._field('stack')}: expected one or more, got none")
        cls._check_alike(cls._field("stack"), *values)
        return values[0]._like(np.stack([one.coefficients for one in values]))

    @classmethod
    def concatenate(cls, values: Sequence[Self]) -> Self:
        """Join batches along their first dimension."""
        if not values or any(not one.shape for one in values):
            raise ValueError(
                f"{cls._field('concatenate')}: expected one or more batches with a leading "
                f"dimension, got shapes {[one.shape for one in values]}; stack joins single ones"
            )
        cls._check_alike(cls._field("concatenate"), *values)
        return values[0]._like(np.concatenate([one.coefficients for one in values]))

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
