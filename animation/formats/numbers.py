"""Long texts of numbers into arrays, a piece at a time, so that words do not fill the memory."""

from __future__ import annotations

import re

import numpy as np

from motorcade.animation.formats.errors import FormatError, expected, shown
from motorcade.animation.formats.limits import MAX_VALUES
from motorcade.ga.arrays import FloatArray

PIECE = 1 << 20
SPACE = re.compile(r"\s")


def numbers_in(text: str, field: str) -> FloatArray:
    """All numbers of a text, parted by white space.

    Raises:
        FormatError: other words, NaN, numbers beyond 1e9, or more than MAX_VALUES.
    """
    pieces, start, total = [], 0, 0
    while start < len(text):
        gap = SPACE.search(text, min(start + PIECE, len(text)))
        end = len(text) if gap is None else gap.start()
        words = text[start:end].split()
        start = end + 1
        if not words:
            continue
        try:
            pieces.append(np.array(words, dtype=np.float64))
        except ValueError as fault:
            raise FormatError(f"{field}: expected numbers, {shown(fault)}") from fault
        total += len(words)
        if total > MAX_VALUES:
            raise expected(field, f"at most {MAX_VALUES} numbers", "more")
    values = np.concatenate(pieces) if pieces else np.zeros(0)
    if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > 1e9:
        raise expected(field, "finite numbers up to 1e9", "others")
    return values
