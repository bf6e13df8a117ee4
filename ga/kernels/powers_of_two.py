"""Powers of two on batches, as ``support.h`` has them: what generated NumPy kernels call."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def exp2_of_integer(n: NDArray[Any]) -> NDArray[Any]:
    """``2^n`` of whole numbers; 0 and infinity where that is no normal number."""
    limits = np.finfo(n.dtype)
    least = limits.minexp - 1
    biased = (np.clip(n, least, limits.maxexp) - least).astype(f"i{n.dtype.itemsize}")
    power: NDArray[Any] = np.left_shift(biased, limits.nmant).view(n.dtype)
    return power


def exponent(x: NDArray[Any]) -> NDArray[Any]:
    """The greatest n with ``2^n <= x``, of positive normal numbers."""
    whole: NDArray[Any] = (np.frexp(x)[1] - 1).astype(x.dtype)
    return whole
