"""The binary buffer of a glTF file that is being written, with its views and accessors."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga.arrays import FloatArray

KINDS = {"<f4": 5126, "<u4": 5125, "<u2": 5123, "|u1": 5121}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
GENERATOR = "Motorcade"
"""What files say that are written here: metres, figures on the ground at z = 0 of their space."""

VERTICES, INDICES = 34962, 34963


class BinaryBuffer:
    """Gathers arrays; each becomes a view and an accessor."""

    def __init__(self) -> None:
        self._data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    @property
    def data(self) -> bytes:
        """All arrays, one after the other."""
        return bytes(self._data)

    def add_bytes(self, data: bytes) -> int:
        """Add a file, such as an image; returns the number of its view."""
        self._data += b"\0" * (-len(self._data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self._data), "byteLength": len(data)})
        self._data += data
        return len(self.views) - 1

    def add(
        self, values: ArrayLike, kind: str = "<f4", *, target: int = 0, bounds: bool = False
    ) -> int:
        """Add an array (n,) or (n, width); returns the number of its accessor.

        Args:
            values: what to store.
            kind: NumPy's name of the type to store it as.
            target: what the array is for, where the format wants that said.
            bounds: whether to state the smallest and largest values.
        """
        array: NDArray[Any] = np.ascontiguousarray(values, dtype=kind)
        width = 1 if array.ndim == 1 else array.shape[1]
        self._data += b"\0" * (-len(self._data) % 4)
        view: dict[str, Any] = {
            "buffer": 0,
            "byteOffset": len(self._data),
            "byteLength": array.nbytes,
        }
        if target:
            view["target"] = target
        self._data += array.tobytes()
        accessor: dict[str, Any] = {
            "bufferView": len(self.views),
            "componentType": KINDS[array.dtype.str],
            "count": len(array),
            "type": TYPES[width],
        }
        if bounds:
            columns = array.reshape(len(array), width)
            accessor["min"] = [float(value) for value in columns.min(axis=0)]
            accessor["max"] = [float(value) for value in columns.max(axis=0)]
        self.views.append(view)
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def add_few(self, values: FloatArray, *, bounds: bool = False) -> int:
        """Add an array (n, width) of which most rows are zero: only the others are stored.

        Of an array of zeros the first row stands in the file, for programs that want some data.
        """
        rows = np.flatnonzero(np.any(values != 0.0, axis=1))
        rows = rows if len(rows) else np.zeros(1, dtype=np.int64)
        parts: list[dict[str, Any]] = []
        for part, kind in ((rows, "<u4"), (values[rows], "<f4")):
            parts.append({"bufferView": self.add_bytes(np.asarray(part, dtype=kind).tobytes())})
        accessor: dict[str, Any] = {
            "componentType": KINDS["<f4"],
            "count": len(values),
            "type": TYPES[values.shape[1]],
            "sparse": {
                "count": len(rows),
                "indices": {**parts[0], "componentType": KINDS["<u4"]},
                "values": parts[1],
            },
        }
        if bounds:
            stored = values.astype(np.float32)
            accessor["min"] = [float(value) for value in stored.min(axis=0)]
            accessor["max"] = [float(value) for value in stored.max(axis=0)]
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def write_glb(path: Path, document: dict[str, Any], buffer: BinaryBuffer) -> None:
    """Write a document with its buffer; the file appears whole or not at all.

    Raises OSError: the file cannot be written.
    """
    data = buffer.data + b"\0" * (-len(buffer.data) % 4)
    whole = {
        **document,
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": buffer.views,
        "accessors": buffer.accessors,
    }
    text = json.dumps(whole, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    parts = (
        struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)),
        struct.pack("<I4s", len(text), b"JSON"),
        text,
        struct.pack("<I4s", len(data), b"BIN\0"),
        data,
    )
    unfinished = path.with_name(path.name + ".part")
    try:
        unfinished.write_bytes(b"".join(parts))
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
