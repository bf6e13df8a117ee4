"""Normal equations of a chain of states with unknowns that all of them share.

States ``(N, s)`` touch their neighbours only, so their matrix is a band; the few shared unknowns
border it and are solved first, by the Schur complement, whose inverse is their covariance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Solved:
    """The minimum, and how sure it is.

    Fields:
        states: ``(N, s)`` steps.
        shared: ``(g,)`` steps; covariance: ``(g, g)`` of them, 0 where they were held.
        border: ``(N, s, g)`` how the states follow the shared unknowns: minus their derivative.
        factor: of the states' matrix, the shared unknowns held.
    """

    states: FloatArray
    shared: FloatArray
    covariance: FloatArray
    border: FloatArray
    factor: ChainFactor

    @cached_property
    def _known_shared(self) -> tuple[FloatArray, FloatArray]:
        """Covariance of each state, and with the one before it, were the shared unknowns known."""
        return self.factor.inverse_blocks()

    def state_covariance(self, own: FloatArray, shared: FloatArray) -> FloatArray:
        """Covariance ``(N, r, r)`` of residuals of single states with derivatives ``(N, r, *)``."""
        along = shared - own @ self.border
        spread: FloatArray = own @ self._known_shared[0] @ _transposed(own)
        return spread + along @ self.covariance @ _transposed(along)

    def interval_covariance(
        self, start: FloatArray, end: FloatArray, shared: FloatArray
    ) -> FloatArray:
        """Covariance ``(N - 1, r, r)`` of residuals with derivatives ``(N - 1, r, *)``."""
        own, cross = self._known_shared
        crossed = end @ cross @ _transposed(start)
        spread = start @ own[:-1] @ _transposed(start) + end @ own[1:] @ _transposed(end)
        along = shared - start @ self.border[:-1] - end @ self.border[1:]
        total: FloatArray = spread + crossed + _transposed(crossed)
        return total + along @ self.covariance @ _transposed(along)


class Bordered:
    """Squares of linear residuals, added up; `solve` finds their minimum.

    Args:
        count: number N of states.
        size: unknowns s a state.
        shared: unknowns g that all share.
    """

    def __init__(self, count: int, size: int, shared: int) -> None:
        self._own = np.zeros((count, size, size))
        self._next = np.zeros((count - 1, size, size))  # rows of the later state
        self._border = np.zeros((count, size, shared))
        self._shared = np.zeros((shared, shared))
        self._pull = np.zeros((count, size))
        self._shared_pull = np.zeros(shared)

    def add_states(self, residual: FloatArray, own: FloatArray, shared: FloatArray) -> None:
        """Residuals ``(N, r)`` with derivatives ``(N, r, s)`` and ``(N, r, g)``, white."""
        self._own += _product(own, own)
        self._border += _product(own, shared)
        self.add_shared(residual, shared)
        self._pull -= _product(own, residual[..., None])[..., 0]

    def add_intervals(
        self,
        first: int,
        residual: FloatArray,
        start: FloatArray,
        end: FloatArray,
        shared: FloatArray,
    ) -> None:
        """Residuals ``(n, r)`` of states from `first` on to their next ones, white.

        Derivatives are by both states and by what is shared.
        """
        size, count = start.shape[-1], len(residual)
        observed = np.flatnonzero(np.any(shared, axis=(0, 1)))
        joined = np.concatenate([start, end, shared[..., observed], residual[..., None]], axis=-1)
        squares = np.ascontiguousarray(_transposed(joined)) @ joined
        for state, column in ((first, 0), (first + 1, size)):
            part, rows = slice(state, state + count), squares[:, column : column + size]
            self._own[part] += rows[..., column : column + size]
            self._border[part, :, observed] += rows[..., 2 * size : -1]
            self._pull[part] -= rows[..., -1]
        self._next[first : first + count] += squares[:, size : 2 * size, :size]
        of_shared = np.sum(squares[:, 2 * size : -1], axis=0)
        self._shared[np.ix_(observed, observed)] += of_shared[:, 2 * size : -1]
        self._shared_pull[observed] -= of_shared[:, -1]

    def add_prior(self, state: int, unknown: slice, error: FloatArray, sigma: FloatArray) -> None:
        """What is known beforehand of some unknowns of one state."""
        index = np.arange(self._own.shape[-1])[unknown]
        self._own[state, index, index] += 1.0 / sigma**2
        self._pull[state, index] -= error / sigma**2

    def add_shared(self, residual: FloatArray, shared: FloatArray) -> None:
        """Residuals ``(n, r)`` of the shared unknowns alone, ``(n, r, g)``, white."""
        self._shared += np.sum(_product(shared, shared), axis=0)
        self._shared_pull -= np.sum(_product(shared, residual[..., None])[..., 0], axis=0)

    def solve(self, free: NDArray[np.bool_]) -> Solved:
        """The minimum with the shared unknowns outside the mask `free` ``(g,)`` held.

        Raises:
            ValueError: unknowns that nothing determines.
        """
        right = np.concatenate([self._pull[..., None], self._border[..., free]], axis=-1)
        try:
            factor = ChainFactor(self._own, self._next)
            solved = factor.solve(right)
            schur = self._shared[np.ix_(free, free)]
            schur = schur - np.tensordot(right[..., 1:], solved[..., 1:], axes=([0, 1], [0, 1]))
            covariance = np.linalg.inv(schur)
            np.linalg.cholesky(schur)
        except np.linalg.LinAlgError as fault:
            raise ValueError(
                "camera and imu: expected motion that determines the states, got too little of it"
            ) from fault
        taken = np.einsum("nsg,ns->g", right[..., 1:], solved[..., 0])
        step = covariance @ (self._shared_pull[free] - taken)
        shared = np.zeros(len(free))
        shared[free] = step
        full = np.zeros((len(free), len(free)))
        full[np.ix_(free, free)] = 0.5 * (covariance + covariance.T)
        follow = np.zeros((*self._pull.shape, len(free)))
        follow[..., free] = solved[..., 1:]
        return Solved(solved[..., 0] - solved[..., 1:] @ step, shared, full, follow, factor)


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    return _transposed(a) @ b


def _transposed(a: FloatArray) -> FloatArray:
    return np.swapaxes(a, -1, -2)


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
        >>> from motorcade.fusion.sync.normal_equations import ChainFactor
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
        return cls(alone, -alone @ below[0::2], -alone[: len(after)] @ _transposed(after))

    def left_of(self, diagonal: FloatArray, below: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The chain of the other states."""
        left = diagonal[0::2].copy()
        left[: len(self.alone)] += _transposed(below[0::2]) @ self.from_before
        left[1 : 1 + self.inner] += below[1::2] @ self.from_after
        return left, below[1::2] @ self.from_before[: self.inner]

    def pushed(self, right: FloatArray) -> FloatArray:
        """The other states' right sides, with what is eliminated."""
        left, own = right[0::2].copy(), right[1::2]
        left[: len(own)] += _transposed(self.from_before) @ own
        left[1 : 1 + self.inner] += _transposed(self.from_after) @ own[: self.inner]
        return left

    def blocks(self, left_own: FloatArray, left_cross: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Blocks of all states' inverse from those of the others'."""
        count, inner = len(self.alone), self.inner
        before = self.from_before @ left_own[:count]
        before[:inner] += self.from_after @ left_cross
        after = self.from_before[:inner] @ _transposed(left_cross)
        after += self.from_after @ left_own[1 : 1 + inner]
        own = np.empty((len(left_own) + count, *self.alone.shape[1:]))
        cross = np.empty((count + inner, *self.alone.shape[1:]))
        own[0::2], cross[0::2], cross[1::2] = left_own, before, _transposed(after)
        own[1::2] = self.alone + before @ _transposed(self.from_before)
        own[1::2][:inner] += after @ _transposed(self.from_after)
        return own, cross


def _inverse(blocks: FloatArray) -> FloatArray:
    np.linalg.cholesky(blocks)  # refuses what is not positive definite
    return np.asarray(np.linalg.inv(blocks), dtype=np.float64)
