"""Arrays as JSON: their bytes in base64, little-endian, and their shape."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

KINDS = {"f32": "<f4", "f64": "<f8", "u32": "<u4"}


def packed(values: ArrayLike, kind: str = "f32") -> dict[str, Any]:
    """An array for `look.js`: "f32" for what is drawn, "f64" for poses and stamps, "u32".

    >>> from motorcade.replays.studio.look.packing import packed
    >>> packed([[1.0, 2.0]])
    {'f32': 'AACAPwAAAEA=', 'shape': [1, 2]}
    """
    array = np.ascontiguousarray(values, dtype=KINDS[kind])
    return {kind: text(array.tobytes()), "shape": list(array.shape)}


def text(data: bytes) -> str:
    """Bytes in base64."""
    return base64.b64encode(data).decode("ascii")
