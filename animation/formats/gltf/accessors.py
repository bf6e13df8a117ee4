"""Accessors: typed arrays in the buffers of a glTF file, decoded once each.

Normalised integers become numbers from 0 or −1 to 1, sparse entries are written over what they
replace, interleaved data is taken apart.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.gltf.container import Document, integer, table
from motorcade.animation.formats.limits import MAX_VALUES, FormatError, expected
from motorcade.ga.arrays import FloatArray, IntArray

TYPES: dict[int, np.dtype[Any]] = {
    5120: np.dtype("<i1"),
    5121: np.dtype("<u1"),
    5122: np.dtype("<i2"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class Accessors:
    """Reads the accessors of one document."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._entries = document.entries("accessors")
        self._views = document.entries("bufferViews")
        self._read: dict[int, NDArray[Any]] = {}
        self._total = 0

    def floats(self, index: object, field: str, kind: str) -> FloatArray:
        """Values (n, width), or (n,) for scalars, as float64; normalised integers are divided.

        Raises:
            FormatError: another type, out of range, NaN or infinity.
        """
        raw = self._raw(index, field, kind)
        if raw.dtype.kind == "f":
            numbers = widened(raw)
            if not np.isfinite(numbers).all():
                raise expected(field, "finite numbers", "NaN or infinity")
            return numbers
        number = integer(index, field, 0, len(self._entries) - 1)
        entry = table(self._entries[number], field)
        numbers = raw.astype(np.float64)
        if entry.get("normalized") is True:
            numbers = np.maximum(numbers / np.iinfo(raw.dtype).max, -1.0)
        return numbers

    def integers(self, index: object, field: str, kind: str) -> IntArray:
        """Whole numbers (n, width), or (n,) for scalars.

        Raises:
            FormatError: another type, or out of range.
        """
        raw = self._raw(index, field, kind)
        if raw.dtype.kind == "f":
            raise expected(field, "integers", "floating-point numbers")
        return raw.astype(np.int64)

    def unread(self, index: object, field: str, kind: str) -> NDArray[Any]:
        """Values as they are stored, perhaps in the buffer's own memory; NaN may be among them."""
        return self._raw(index, field, kind)

    def unpacked(self, index: object, values: NDArray[Any], field: str) -> None:
        """Take the values (n, width) of an accessor, which were compressed.

        There may be fewer or more than it counts: encoders merge vertices that are alike and drop
        triangles without area, and viewers take what is decoded.

        Raises:
            FormatError: none, or of another width or kind than the accessor says.
        """
        number = integer(index, field, 0, len(self._entries) - 1)
        entry = table(self._entries[number], field)
        kind, width = _component(entry, field), WIDTHS.get(str(entry.get("type")))
        if width is None or values.ndim != 2 or not len(values) or values.shape[1] != width:
            said = f"one or more {entry.get('type')}, as accessors[{number}]"
            raise expected(field, said, " x ".join(map(str, values.shape)) + " numbers")
        self._count(values.size)
        decoded = values.astype(kind)
        if kind.kind != "f" and not np.array_equal(decoded, values):
            raise expected(field, f"numbers of {kind}, as accessors[{number}]", values.dtype)
        self._read[number] = decoded[:, 0] if width == 1 else decoded

    def _count(self, values: int) -> None:
        self._total += values
        if self._total > MAX_VALUES:
            raise FormatError(f"accessors: expected at most {MAX_VALUES} numbers in all, got more")

    def _raw(self, index: object, field: str, kind: str) -> NDArray[Any]:
        number = integer(index, field, 0, len(self._entries) - 1)
        known = self._read.get(number)
        entry = table(self._entries[number], field)
        if entry.get("type") != kind:
            raise expected(f"accessors[{number}].type", kind, entry.get("type"))
        if known is not None:
            return known
        raw = self._decode(entry, number)
        self._read[number] = raw
        return raw

    def _decode(self, entry: dict[str, Any], number: int) -> NDArray[Any]:
        width = WIDTHS[entry["type"]]
        kind = _component(entry, "accessor")
        count = integer(entry.get("count"), "accessor.count", 1, MAX_VALUES // width)
        self._count(count * width)
        if "bufferView" in entry:
            offset = entry.get("byteOffset", 0)
            elements = self._view(entry["bufferView"], offset, number, kind, count, width)
        else:
            elements = np.zeros((count, width), kind)
        if "sparse" in entry:
            elements = self._sparse(
                table(entry["sparse"], f"accessors[{number}].sparse"), number, elements
            )
        return elements[:, 0] if width == 1 else elements

    def _view(
        self, view: object, offset: object, number: int, kind: np.dtype[Any], count: int, width: int
    ) -> NDArray[Any]:
        """An array (count, width) over a buffer view; nothing is copied."""
        which = integer(view, "accessor.bufferView", 0, len(self._views) - 1)
        entry = table(self._views[which], "bufferView")
        buffers = self._document.buffers
        whole = integer(entry.get("buffer"), "bufferView.buffer", 0, len(buffers) - 1)
        data = buffers[whole]
        start = integer(entry.get("byteOffset", 0), "bufferView.byteOffset", 0, len(data))
        length = integer(entry.get("byteLength"), "bufferView.byteLength", 1, len(data) - start)
        item = kind.itemsize * width
        stride = entry.get("byteStride", item)
        if stride != item:
            stride = integer(stride, "bufferView.byteStride", item, 252)
        first = offset if type(offset) is int and 0 <= offset <= length else -1
        if first < 0 or first + (count - 1) * stride + item > length:
            raise expected(
                f"accessors[{number}].count", f"values within the {length} bytes of its view", count
            )
        return np.ndarray((count, width), kind, data, start + first, (stride, kind.itemsize))

    def _sparse(self, entry: dict[str, Any], number: int, base: NDArray[Any]) -> NDArray[Any]:
        field = f"accessors[{number}].sparse"
        count = integer(entry.get("count"), f"{field}.count", 1, len(base))
        at = table(entry.get("indices"), f"{field}.indices")
        kind = _component(at, f"{field}.indices")
        if kind.kind != "u":
            raise expected(f"{field}.indices.componentType", "unsigned integers", "others")
        rows = self._view(at.get("bufferView"), at.get("byteOffset", 0), number, kind, count, 1)
        values = table(entry.get("values"), f"{field}.values")
        new = self._view(
            values.get("bufferView"),
            values.get("byteOffset", 0),
            number,
            base.dtype,
            count,
            base.shape[1],
        )
        where = rows[:, 0].astype(np.int64)
        if where.max() >= len(base) or np.any(np.diff(where) <= 0):
            raise expected(f"{field}.indices", f"increasing numbers below {len(base)}", "others")
        sparse = base.copy()
        sparse[where] = new
        return sparse


def widened(raw: NDArray[Any]) -> FloatArray:
    """Numbers as float64; NaN that would signal stays quiet, to be refused by name."""
    with np.errstate(invalid="ignore"):
        return raw.astype(np.float64)


def _component(entry: dict[str, Any], field: str) -> np.dtype[Any]:
    """The type that a number stands for."""
    value = entry.get("componentType")
    kind = TYPES.get(value) if type(value) is int else None
    if kind is None:
        raise expected(f"{field}.componentType", "5120 to 5126", value)
    return kind
