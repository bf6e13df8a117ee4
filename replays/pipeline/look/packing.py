"""Arrays as JSON: their bytes in base64, little-endian, and their shape."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

KINDS = {"f32": "<f4", "f64": "<f8", "u32": "<u4"}


def packed(values: ArrayLike, kind: str = "f32") -> dict[str, Any]:
    """An array for `look.js`: "f32" for what is drawn, "f64" for poses and stamps, "u32".

    >>> from motorcade.replays.pipeline.look.packing import packed
    >>> packed([[1.0, 2.0]])
    {'f32': 'AACAPwAAAEA=', 'shape': [1, 2]}
    """
    array = np.ascontiguousarray(values, dtype=KINDS[kind])
    return {kind: text(array.tobytes()), "shape": list(array.shape)}


def packed_smooth(values: ArrayLike, finest: float) -> dict[str, Any]:
    """Rows ``(F, …)`` that change little from one to the next, each column in 16 bits.

    They are told as second differences, column after column, which the pages' compression makes a
    few bits each. Where 16 bits would be coarser than `finest` in some column, they are "f32".
    """
    array = np.asarray(values, dtype=np.float64)
    columns = array.reshape(len(array), -1)
    largest = np.abs(columns).max(axis=0, initial=0.0)
    step = np.where(largest > 0.0, largest, 1.0) / 32767
    if not np.all(largest <= 32767 * finest):  # nor where one is NaN
        return packed(array)
    numbers = np.rint(columns / step).astype(np.int64)
    blank = np.zeros((1, numbers.shape[1]), np.int64)
    twice = np.diff(np.diff(numbers, axis=0, prepend=blank), axis=0, prepend=blank)
    data = np.ascontiguousarray(twice.T).astype("<i2")  # modulo 2^16, as they are added up again
    return {"i16": text(data.tobytes()), "step": packed(step, "f64"), "shape": list(array.shape)}


def text(data: bytes) -> str:
    """Bytes in base64."""
    return base64.b64encode(data).decode("ascii")
