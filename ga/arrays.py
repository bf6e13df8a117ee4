"""Checked, read-only float arrays: the door through which every value of this room comes in.

Leading dimensions are batch, trailing dimensions are fixed by the value's type. Nothing is
repaired here: an array that does not fit is refused with its name, what was expected, what came.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

__all__ = [
    "FloatArray",
    "IntArray",
    "checked_floats",
    "checked_positive",
    "common_precision",
    "frozen",
    "sealed",
    "shape_text",
]


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
    try:
        given = np.asarray(value)
    except ValueError as ragged:
        raise ValueError(f"{name}: expected a regular array of numbers, {ragged}") from ragged
    if given.dtype.kind not in "fiub":
        raise ValueError(f"{name}: expected real numbers, got dtype {given.dtype}")
    array = np.asarray(given, dtype=np.float64)
    kept = len(trailing)
    if array.ndim < kept or array.shape[array.ndim - kept :] != trailing:
        raise ValueError(f"{name}: expected shape {shape_text(trailing)}, got {array.shape}")
    if not np.isfinite(array).all():
        bad = int(array.size - np.count_nonzero(np.isfinite(array)))
        raise ValueError(
            f"{name}: expected finite numbers, got {bad} NaN or infinite of {array.size}"
        )
    return array


def common_precision(*given: Any) -> np.dtype[Any]:
    """float32 where every array among the inputs is of float32, else float64.

    Whatever has a ``dtype`` counts as an array; Python's numbers and lists have no precision.
    """
    kinds = {np.dtype(one.dtype) for one in given if hasattr(one, "dtype")}
    return np.dtype(np.float32 if kinds == {np.dtype(np.float32)} else np.float64)


def checked_positive(value: float, name: str, unit: str = "") -> float:
    """A finite number above 0.

    Raises:
        ValueError: another one.
    """
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
