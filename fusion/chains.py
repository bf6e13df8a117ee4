"""Matrices of chains: states touch their neighbours only, so that solving takes linear time."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray


def banded(diagonal: FloatArray, below: FloatArray) -> FloatArray:
    """A symmetric block-tridiagonal matrix by its lower diagonals, as LAPACK wants it.

    Args:
        diagonal: ``(N, s, s)`` blocks.
        below: ``(N - 1, s, s)``, rows of the later state.

    Returns:
        ``(2 s, N s)``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.chains import banded
        >>> banded(np.full((3, 1, 1), 2.0), np.full((2, 1, 1), -1.0))
        array([[ 2.,  2.,  2.],
               [-1., -1.,  0.]])
    """
    count, size = diagonal.shape[:2]
    band = np.zeros((2 * size, count * size))
    for column in range(size):
        own = slice(column, None, size)
        band[: size - column, own] = diagonal[:, column:, column].T
        upto = slice(column, (count - 1) * size, size)
        band[size - column : 2 * size - column, upto] = below[:, :, column].T
    return band
