"""Matrices of chains: states touch their neighbours only, so that solving takes linear time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray


class ChainFactor:
    """A positive definite chain, factored: solves with it, and gives blocks of its inverse.

    Every other state is eliminated at once, then of those that are left every other one, and so on:
    some calls for stacks of matrices in place of one for each state.

    Source: D. Heller, Some aspects of the cyclic reduction algorithm for block tridiagonal linear
    systems, SIAM Journal on Numerical Analysis 13(4), 1976.

    Args:
        diagonal: ``(N, s, s)`` blocks.
        below: ``(N - 1, s, s)``, rows of the later state.

    Raises:
        numpy.linalg.LinAlgError: a matrix that is not positive definite.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.chains import ChainFactor
        >>> factor = ChainFactor(np.full((3, 1, 1), 2.0), np.full((2, 1, 1), -1.0))
        >>> factor.solve(np.array([1.0, 0.0, 1.0]).reshape(3, 1, 1)).ravel()
        array([1., 1., 1.])
        >>> own, cross = factor.inverse_blocks()
        >>> own.ravel(), cross.ravel()
        (array([0.75, 1.  , 0.75]), array([0.5, 0.5]))
    """

    def __init__(self, diagonal: FloatArray, below: FloatArray) -> None:
        self._levels: list[_Level] = []
        while len(diagonal) > 1:
            level = _Level.of(diagonal[1::2], below)
            self._levels.append(level)
            diagonal, below = level.left_of(diagonal, below)
        self._last = _inverse(diagonal)

    def solve(self, right: FloatArray) -> FloatArray:
        """Columns ``(N, s, k)`` that the matrix takes to those on the right."""
        eliminated = []
        for level in self._levels:
            eliminated.append(right[1::2])
            right = level.pushed(right)
        solved: FloatArray = self._last @ right
        for level, own in zip(reversed(self._levels), reversed(eliminated), strict=True):
            merged = np.empty((len(solved) + len(own), *own.shape[1:]))
            merged[0::2] = solved
            merged[1::2] = level.alone @ own + level.from_before @ solved[: len(own)]
            merged[1::2][: level.inner] += level.from_after @ solved[1 : 1 + level.inner]
            solved = merged
        return solved

    def inverse_blocks(self) -> tuple[FloatArray, FloatArray]:
        """Blocks ``(N, s, s)`` and ``(N - 1, s, s)`` on and below the inverse's diagonal."""
        own, cross = self._last, self._last[:0]
        for level in reversed(self._levels):
            own, cross = level.blocks(own, cross)
        return own, cross


@dataclass(frozen=True, eq=False)
class _Level:
    """What eliminating every other state leaves: each follows from its two neighbours.

    Fields:
        alone: ``(M, s, s)`` its covariance, were its neighbours known.
        from_before: ``(M, s, s)`` how it follows the state before it.
        from_after: ``(inner, s, s)`` how the one after it; an even chain's last has none.
    """

    alone: FloatArray
    from_before: FloatArray
    from_after: FloatArray

    @property
    def inner(self) -> int:
        return len(self.from_after)

    @classmethod
    def of(cls, eliminated: FloatArray, below: FloatArray) -> _Level:
        alone = _inverse(eliminated)
        after = below[1::2]
        return cls(alone, -alone @ below[0::2], -alone[: len(after)] @ _turned(after))

    def left_of(self, diagonal: FloatArray, below: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The chain of the other states."""
        left = diagonal[0::2].copy()
        left[: len(self.alone)] += _turned(below[0::2]) @ self.from_before
        left[1 : 1 + self.inner] += below[1::2] @ self.from_after
        return left, below[1::2] @ self.from_before[: self.inner]

    def pushed(self, right: FloatArray) -> FloatArray:
        """The other states' right sides, with what is eliminated."""
        left, own = right[0::2].copy(), right[1::2]
        left[: len(own)] += _turned(self.from_before) @ own
        left[1 : 1 + self.inner] += _turned(self.from_after) @ own[: self.inner]
        return left

    def blocks(self, left_own: FloatArray, left_cross: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Blocks of all states' inverse from those of the others'."""
        count, inner = len(self.alone), self.inner
        before = self.from_before @ left_own[:count]
        before[:inner] += self.from_after @ left_cross
        after = self.from_before[:inner] @ _turned(left_cross)
        after += self.from_after @ left_own[1 : 1 + inner]
        own = np.empty((len(left_own) + count, *self.alone.shape[1:]))
        cross = np.empty((count + inner, *self.alone.shape[1:]))
        own[0::2], cross[0::2], cross[1::2] = left_own, before, _turned(after)
        own[1::2] = self.alone + before @ _turned(self.from_before)
        own[1::2][:inner] += after @ _turned(self.from_after)
        return own, cross


def _inverse(blocks: FloatArray) -> FloatArray:
    np.linalg.cholesky(blocks)  # refuses what is not positive definite
    return np.asarray(np.linalg.inv(blocks), dtype=np.float64)


def _turned(blocks: FloatArray) -> FloatArray:
    return np.swapaxes(blocks, -1, -2)
