"""Powers of two on batches, as ``support.h`` has them: what generated NumPy kernels call."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["exp2_of_integer", "exponent"]


def exp2_of_integer(n: NDArray[Any]) -> NDArray[Any]:
    """``2^n`` of whole numbers; 0 and infinity where that is no normal number."""
    limits = np.finfo(n.dtype)
    kept = np.clip(n, limits.minexp - 1, limits.maxexp)
    power = np.ldexp(n.dtype.type(1), kept.astype(np.int32))
    return np.where(kept < limits.minexp, n.dtype.type(0), power)


def exponent(x: NDArray[Any]) -> NDArray[Any]:
    """The greatest n with ``2^n <= x``, of positive normal numbers."""
    return (np.frexp(x)[1] - 1).astype(x.dtype)
