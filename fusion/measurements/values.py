"""How the kinds check the numbers that they are given."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.measurements.interface import Measurements
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen


def checked_rows(value: ArrayLike, name: str, count: int, trailing: tuple[int, ...]) -> FloatArray:
    """Numbers ``(N, *trailing)``, finite and read-only.

    Raises:
        ValueError: another shape, NaN or infinity.
    """
    array = checked_floats(value, name, trailing)
    if array.shape != (count, *trailing):
        raise ValueError(f"{name}: expected shape {(count, *trailing)}, got {array.shape}")
    return frozen(array)


def checked_vector(value: ArrayLike, name: str) -> FloatArray:
    """Three finite numbers ``(3,)``, read-only.

    Raises:
        ValueError: another shape, NaN or infinity.
    """
    array = checked_floats(value, name, (3,))
    if array.shape != (3,):
        raise ValueError(f"{name}: expected three numbers, got shape {array.shape}")
    return frozen(array)


def checked_stamps(value: ArrayLike, name: str) -> IntArray:
    """Stamps ``(N,)`` as int64.

    Raises:
        ValueError: no integers, or another shape.
    """
    array = np.asarray(value)
    if array.dtype.kind != "i" or array.ndim != 1:
        raise ValueError(f"{name}: expected integer nanoseconds (N,), got {array.dtype}")
    return array.astype(np.int64)


def spread(value: ArrayLike, name: str, count: int, size: int) -> FloatArray:
    """Covariances ``(N, m, m)`` of one for all ``(m, m)`` or one each; of m = 1 also variances.

    Raises:
        ValueError: another shape, NaN or infinity.
    """
    array = checked_floats(value, name, ())
    if size == 1 and array.shape in ((), (count,)):
        array = array.reshape((*array.shape, 1, 1))
    if array.shape not in ((size, size), (count, size, size)):
        raise ValueError(
            f"{name}: expected shape {(size, size)} or {(count, size, size)}, got {array.shape}"
        )
    return frozen(np.broadcast_to(array, (count, size, size)))


def set_checked(
    kind: Measurements,
    size: int,
    vectors: tuple[str, ...] = (),
    **rows: tuple[int, ...],
) -> int:
    """Check a frozen kind's numbers as it is made, and set them read-only; how many rows it has.

    Args:
        kind: with stamps `time_ns` and a `covariance` as `spread` takes it.
        size: of the covariances; 0 where the kind sets its own.
        vectors: fields of three numbers.
        rows: fields of numbers ``(N, *shape)``, with that shape.

    Raises:
        ValueError: stamps that are no integers ``(N,)``, another shape, NaN or infinity.
    """
    stamps = checked_stamps(kind.time_ns, "time_ns")
    count = len(stamps)
    object.__setattr__(kind, "time_ns", stamps)
    for name, shape in rows.items():
        object.__setattr__(kind, name, checked_rows(getattr(kind, name), name, count, shape))
    if size:
        own = spread(kind.covariance, "covariance", count, size)
        object.__setattr__(kind, "covariance", own)
    for name in vectors:
        object.__setattr__(kind, name, checked_vector(getattr(kind, name), name))
    return count
