"""Filters of meshoptimizer's streams: bytes as directions, turns, numbers and colours."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.errors import expected

Bytes = NDArray[np.uint8]


def _octahedral(rows: Bytes) -> NDArray[Any]:
    """Unit vectors from an octahedron that is laid flat; the fourth number is kept."""
    values, most = _signed(rows)
    one = values[:, 2].astype(np.float64)
    if not one.all():
        raise expected("octahedral vectors", "lengths above 0", "0")
    x, y = values[:, 0] / one, values[:, 1] / one
    z = 1.0 - np.abs(x) - np.abs(y)
    under = np.maximum(-z, 0.0)
    x, y = x - np.where(x >= 0.0, under, -under), y - np.where(y >= 0.0, under, -under)
    length = np.sqrt(x * x + y * y + z * z)
    for column, part in enumerate((x, y, z)):
        values[:, column] = _rounded(part / length * most)
    return values


def _quaternion(rows: Bytes) -> NDArray[Any]:
    """Unit quaternions from their three smaller parts."""
    if rows.shape[1] != 8:
        raise expected("byteStride of quaternions", "8", rows.shape[1])
    values = rows.view("<i2")
    last = values[:, 3].astype(np.int64)
    parts = values[:, :3] * (np.sqrt(0.5) / (last | 3))[:, None]
    largest = np.sqrt(np.maximum(1.0 - (parts * parts).sum(axis=1), 0.0))
    every = np.concatenate([largest[:, None], parts], axis=1)
    made = np.zeros_like(values)
    places = (last[:, None] + np.arange(4)) % 4
    np.put_along_axis(made, places, _rounded(every * 32767.0).astype(np.int16), axis=1)
    return made


def _exponential(rows: Bytes) -> NDArray[Any]:
    """Floating-point numbers from 8 bits of exponent and 24 of mantissa."""
    values = rows.view("<i4")
    with np.errstate(over="ignore", under="ignore"):  # infinity is refused with its accessor
        made = np.ldexp(((values << 8) >> 8).astype(np.float32), values >> 24)
    return np.asarray(made, dtype="<f4")


def _color(rows: Bytes) -> NDArray[Any]:
    """Red, green, blue and alpha from lightness and two differences."""
    signed, _ = _signed(rows)
    y, orange, green, alpha = (signed[:, k].astype(np.int64) for k in range(4))
    most = (1 << (2 * rows.shape[1])) - 1
    y, alpha = y & most, alpha & most
    bits = np.frexp(alpha.astype(np.float64))[1]  # of its highest bit, which tells the range
    whole = (1 << bits) - 1
    given = alpha & (whole >> 1)
    parts = (y + orange - green, y + green, y - orange - green, (given << 1) | (given & 1))
    if not whole.all():
        raise expected("colours", "an alpha above 0, which tells their range", "0")
    made = np.stack(parts, axis=1) * (most / whole)[:, None]
    return np.clip(_rounded(made), 0, most).astype(f"<u{rows.shape[1] // 4}")


def _signed(rows: Bytes) -> tuple[NDArray[Any], int]:
    """Four signed numbers a row, in memory of their own, and the largest that there is."""
    if rows.shape[1] not in (4, 8):
        raise expected("byteStride of four numbers", "4 or 8", rows.shape[1])
    kind = np.dtype(f"<i{rows.shape[1] // 4}")
    return rows.view(kind).copy(), int(np.iinfo(kind).max)


def _rounded(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nearest whole numbers, halves away from zero."""
    return np.trunc(values + np.copysign(0.5, values))


FILTERS: dict[str, Callable[[Bytes], NDArray[Any]]] = {
    "OCTAHEDRAL": _octahedral,
    "QUATERNION": _quaternion,
    "EXPONENTIAL": _exponential,
    "COLOR": _color,
}
"""By name; each takes rows (n, stride) in memory of their own."""
