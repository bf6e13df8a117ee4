"""Buffer views compressed as meshoptimizer does (EXT_ and KHR_meshopt_compression).

Source: Khronos Group, EXT_meshopt_compression and KHR_meshopt_compression, whose appendices lay
down every bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.errors import FormatError, expected
from motorcade.animation.formats.gltf.container import MESHOPT, Document, integer, table, text
from motorcade.animation.formats.gltf.packed.meshopt_filters import FILTERS
from motorcade.animation.formats.gltf.packed.meshopt_streams import (
    unpack_attributes,
    unpack_indices,
    unpack_triangles,
)
from motorcade.animation.formats.limits import MAX_VALUES

__all__ = ["unpack_meshopt"]

MAX_UNPACKED_BYTES = 4 * MAX_VALUES


def unpack_meshopt(document: Document) -> None:
    """Put plain buffers behind the compressed views of a document.

    Raises:
        FormatError: bytes that are none of the format's, unknown modes or filters, or more than
            `MAX_UNPACKED_BYTES` in all.
    """
    left = MAX_UNPACKED_BYTES
    for number, given in enumerate(document.entries("bufferViews")):
        field = f"bufferViews[{number}]"
        view = table(given, field)
        extensions = table(view.get("extensions", {}), f"{field}.extensions")
        for name in sorted(MESHOPT & extensions.keys())[:1]:
            packed = table(extensions[name], f"{field}.{name}")
            count = integer(packed.get("count"), f"{field}.count", 1, left)
            width = integer(packed.get("byteStride"), f"{field}.byteStride", 1, 256)
            left -= count * width
            if left < 0:
                raise expected(field, f"at most {MAX_UNPACKED_BYTES} bytes in all", "more")
            data = document.slice(packed, field)
            try:
                made = _unpacked(packed, data, count, width)
            except (FormatError, IndexError) as fault:
                why = "one that is cut off" if isinstance(fault, IndexError) else str(fault)
                raise FormatError(f"{field}: expected a stream of {name}, got {why}") from fault
            length = integer(view.get("byteLength"), f"{field}.byteLength", 1, len(made))
            view |= {"buffer": len(document.buffers), "byteOffset": 0, "byteLength": length}
            document.buffers.append(made)


def _unpacked(packed: dict[str, Any], data: bytes, count: int, width: int) -> bytes:
    """The bytes (count times width) that a stream stands for."""
    mode, filtering = packed.get("mode"), text(packed.get("filter", "NONE"), "filter")
    if mode == "ATTRIBUTES":
        if width % 4:
            raise expected("byteStride", "a multiple of 4", width)
        made = unpack_attributes(data, count, width)
        if filtering == "NONE":
            return made.tobytes()
        if filtering not in FILTERS:
            raise expected("filter", f"NONE, {', '.join(FILTERS)}", filtering)
        return FILTERS[filtering](made).tobytes()
    if filtering != "NONE" or width not in (2, 4):
        raise expected("indices", "2 or 4 bytes and no filter", f"{width} and {filtering}")
    numbers: NDArray[np.int64]
    if mode == "TRIANGLES":
        if count % 3:
            raise expected("count", "a multiple of 3", count)
        numbers = unpack_triangles(data, count // 3)
    elif mode == "INDICES":
        numbers = unpack_indices(data, count)
    else:
        raise expected("mode", "ATTRIBUTES, TRIANGLES or INDICES", mode)
    if numbers.max() >= 1 << (8 * width):
        raise expected("indices", f"numbers of {width} bytes", numbers.max())
    return numbers.astype(f"<u{width}").tobytes()
