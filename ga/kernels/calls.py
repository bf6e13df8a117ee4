"""Kernels called on arrays ``(*, n)``: batches broadcast, results have memory that suits kernels.

See `motorcade.ga.kernels.batches` for what lies where.
"""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

# float32 or float64, one kind throughout a call.
Array = NDArray[Any]

_BLOCK = 16
# Rows that are worth a place of their own in memory; bytes of a line of the cache.
_LONG, _LINE = 1024, 64


def empty(shape: tuple[int, ...], width: int, dtype: np.dtype[Any]) -> Array:
    """An array ``(*shape, width)`` for a kernel to write into, see `batches`."""
    count = prod(shape)
    if count < _BLOCK:
        return np.empty((*shape, width), dtype)
    rows = _columns(width, -(-count // _BLOCK) * _BLOCK, dtype)[:, :count]
    if len(shape) == 1:
        return rows.T
    return np.moveaxis(rows.reshape(width, *shape), 0, -1)


def _columns(width: int, count: int, dtype: np.dtype[Any]) -> Array:
    """An array ``(width, count)``; long ones begin on a cache line, as do their rows.

    Where each vector that is stored lies across two lines, kernels take up to 1.7 times as long.
    Rows of an odd number of lines keep apart in the cache.
    """
    if count < _LONG:
        return np.empty((width, count), dtype)
    step = (count * dtype.itemsize // _LINE | 1) * _LINE
    memory = np.empty(width * step + _LINE, np.uint8)
    first = -memory.__array_interface__["data"][0] % _LINE
    return memory[first : first + width * step].view(dtype).reshape(width, -1)[:, :count]


def spread(array: Array, shape: tuple[int, ...], trailing: int) -> Array:
    """The batch `shape` of an array whose rows a kernel can step through, or one row for all."""
    batch = array.shape[: array.ndim - trailing]
    if batch == shape and (len(shape) < 2 or array.flags.c_contiguous):
        return array
    rest = array.shape[array.ndim - trailing :]
    if prod(batch) == 1:
        return array.reshape(rest)
    whole = np.broadcast_to(array, (*shape, *rest))
    return whole if len(shape) < 2 else whole.reshape(prod(shape), *rest)  # copied if need be


def expect_arrays(*given: object) -> None:
    """Refuse what is no array with TypeError."""
    kinds = [type(one).__name__ for one in given if not isinstance(one, np.ndarray | np.generic)]
    if kinds:
        raise TypeError(f"expected NumPy arrays of float32 or float64, got {', '.join(kinds)}")


def batch_of(*given: Array) -> tuple[int, ...]:
    """The batch that inputs ``(*, n)`` broadcast to."""
    try:
        shape = given[0].shape[:-1]
        for other in given[1:]:
            if other.shape[:-1] != shape:
                shape = np.broadcast_shapes(shape, other.shape[:-1])
    except AttributeError:
        expect_arrays(*given)
        raise
    return shape


def checked_call(kernel: Callable[..., bool], width: int, *given: Array) -> tuple[Array, bool]:
    """Apply a checked kernel to inputs ``(*, n)`` of one precision; and whether they are finite."""
    shape = batch_of(*given)
    if not shape:
        made = np.empty(width, given[0].dtype)
        return made, kernel(*given, made)
    made = empty(shape, width, given[0].dtype)
    return made, kernel(*[spread(one, shape, 1) for one in given], made)


def of_one(kernel: Callable[..., None], given: Array, width: int) -> Array:
    """Apply a kernel of one input ``(*, n)``."""
    shape = batch_of(given)
    if not shape:
        made = np.empty(width, given.dtype)
        kernel(given, made)
        return made
    made = empty(shape, width, given.dtype)
    kernel(spread(given, shape, 1), made)
    return made


def of_two(kernel: Callable[..., None], a: Array, b: Array, width: int) -> Array:
    """Apply a kernel of two inputs ``(*, n)`` whose batches broadcast."""
    shape = batch_of(a, b)
    if not shape:
        made = np.empty(width, a.dtype)
        kernel(a, b, made)
        return made
    made = empty(shape, width, a.dtype)
    kernel(spread(a, shape, 1), spread(b, shape, 1), made)
    return made
