"""The entries of GoPro's telemetry format (GPMF): key, type, size and repeat, then the values.

Values are big-endian and padded to 4 bytes; type 0 nests. Format: github.com/gopro/gpmf-parser.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.errors import refusal

_TYPES = {"s": ">i2", "S": ">u2", "l": ">i4", "L": ">u4", "f": ">f4", "d": ">f8", "b": "i1"}


@dataclass(frozen=True)
class Item:
    """One entry: its key, its type as a letter ("" nests), the size of a sample, its bytes."""

    key: bytes
    kind: str
    size: int
    body: bytes


def items(data: bytes, path: Path) -> Iterator[Item]:
    """Take a run of entries apart.

    Raises:
        RecordingError: an entry that does not end inside `data`.
    """
    at = 0
    while at + 8 <= len(data):
        key, kind, size, repeat = struct.unpack_from(">4sBBH", data, at)
        if key == b"\0\0\0\0":
            return  # padding at the end
        end = at + 8 + size * repeat
        if end > len(data):
            problem = f"expected {size * repeat} bytes of {key!r}, got {len(data) - at - 8}"
            raise refusal(path, problem, field="telemetry")
        yield Item(key, "" if kind == 0 else chr(kind), size, data[at + 8 : end])
        at = end + -(size * repeat) % 4


def numbers(item: Item, path: Path) -> FloatArray:
    """Values ``(samples, values a sample)``."""
    kind = np.dtype(_TYPES[item.kind]) if item.kind in _TYPES else None
    if kind is None or item.size == 0 or item.size % kind.itemsize:
        problem = f"expected numbers, got type {item.kind!r} of {item.size} bytes"
        raise refusal(path, problem, field=f"telemetry {item.key!r}")
    values = np.frombuffer(item.body, kind).astype(np.float64)
    return values.reshape(-1, item.size // kind.itemsize)
