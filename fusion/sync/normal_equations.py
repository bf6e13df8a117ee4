"""Normal equations of a chain of states with unknowns that all of them share.

States ``(N, s)`` touch their neighbours only, so their matrix is a band; the few shared unknowns
border it and are solved first, by the Schur complement, whose inverse is their covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.chains import banded
from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Solved:
    """The minimum, and how sure it is.

    Fields:
        states: ``(N, s)`` steps.
        shared: ``(g,)`` steps; covariance: ``(g, g)`` of them, 0 where they were held.
        own: ``(N, s, s)`` covariance of each state if the shared unknowns were known.
        cross: ``(N - 1, s, s)`` of each later state with the one before it, likewise.
        border: ``(N, s, g)`` how the states follow the shared unknowns: minus their derivative.
    """

    states: FloatArray
    shared: FloatArray
    covariance: FloatArray
    own: FloatArray
    cross: FloatArray
    border: FloatArray

    def state_covariance(self, own: FloatArray, shared: FloatArray) -> FloatArray:
        """Covariance ``(N, r, r)`` of residuals of single states with derivatives ``(N, r, *)``."""
        along = shared - own @ self.border
        spread: FloatArray = own @ self.own @ _turned(own)
        return spread + along @ self.covariance @ _turned(along)

    def interval_covariance(
        self, start: FloatArray, end: FloatArray, shared: FloatArray
    ) -> FloatArray:
        """Covariance ``(N - 1, r, r)`` of residuals with derivatives ``(N - 1, r, *)``."""
        crossed = end @ self.cross @ _turned(start)
        spread = start @ self.own[:-1] @ _turned(start) + end @ self.own[1:] @ _turned(end)
        along = shared - start @ self.border[:-1] - end @ self.border[1:]
        total: FloatArray = spread + crossed + _turned(crossed)
        return total + along @ self.covariance @ _turned(along)


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
        self._add_shared(residual, shared)
        self._pull -= _product(own, residual[..., None])[..., 0]

    def add_intervals(
        self, residual: FloatArray, start: FloatArray, end: FloatArray, shared: FloatArray
    ) -> None:
        """Residuals ``(N - 1, r)`` between neighbours, with derivatives by both, white."""
        for part, own in ((slice(None, -1), start), (slice(1, None), end)):
            self._own[part] += _product(own, own)
            self._border[part] += _product(own, shared)
            self._pull[part] -= _product(own, residual[..., None])[..., 0]
        self._next += _product(end, start)
        self._add_shared(residual, shared)

    def add_prior(self, state: int, unknown: slice, error: FloatArray, sigma: FloatArray) -> None:
        """What is known beforehand of some unknowns of one state."""
        index = np.arange(self._own.shape[-1])[unknown]
        self._own[state, index, index] += 1.0 / sigma**2
        self._pull[state, index] -= error / sigma**2

    def add_shared_prior(self, residual: FloatArray, derivative: FloatArray) -> None:
        """Residuals ``(r,)`` of the shared unknowns alone, ``(r, g)``, white."""
        self._add_shared(residual[None], derivative[None])

    def solve(self, free: NDArray[np.bool_]) -> Solved:
        """The minimum with the shared unknowns outside the mask `free` ``(g,)`` held.

        Raises:
            ValueError: unknowns that nothing determines.
        """
        from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

        count, size, _ = self._border.shape
        border = self._border[..., free].reshape(count * size, -1)
        right = np.concatenate([self._pull.reshape(-1, 1), border], axis=1)
        try:
            factor = cholesky_banded(banded(self._own, self._next), lower=True, check_finite=False)
            solved = cho_solve_banded((factor, True), right, check_finite=False)
            schur = self._shared[np.ix_(free, free)] - border.T @ solved[:, 1:]
            covariance = np.linalg.inv(schur)
            np.linalg.cholesky(schur)
        except LinAlgError as fault:
            raise ValueError(
                "camera and imu: expected motion that determines the states, got too little of it"
            ) from fault
        step = covariance @ (self._shared_pull[free] - border.T @ solved[:, 0])
        states = (solved[:, 0] - solved[:, 1:] @ step).reshape(count, size)
        shared = np.zeros(len(free))
        shared[free] = step
        full = np.zeros((len(free), len(free)))
        full[np.ix_(free, free)] = 0.5 * (covariance + covariance.T)
        follow = np.zeros((count, size, len(free)))
        follow[..., free] = solved[:, 1:].reshape(count, size, -1)
        return Solved(states, shared, full, *self._marginals(), follow)

    def _marginals(self) -> tuple[FloatArray, FloatArray]:
        """Blocks of the inverse of the states' matrix, on and below its diagonal."""
        count = len(self._own)
        eliminated, gains = np.empty_like(self._own), np.empty_like(self._next)
        eliminated[0] = np.linalg.inv(self._own[0])
        for k in range(1, count):
            gains[k - 1] = self._next[k - 1] @ eliminated[k - 1]
            eliminated[k] = np.linalg.inv(self._own[k] - gains[k - 1] @ self._next[k - 1].T)
        own, cross = eliminated.copy(), np.empty_like(self._next)
        for k in range(count - 2, -1, -1):
            cross[k] = -own[k + 1] @ gains[k]
            own[k] = eliminated[k] - gains[k].T @ cross[k]
        return own, cross

    def _add_shared(self, residual: FloatArray, shared: FloatArray) -> None:
        self._shared += np.sum(_product(shared, shared), axis=0)
        self._shared_pull -= np.sum(_product(shared, residual[..., None])[..., 0], axis=0)


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = _turned(a) @ b
    return product


def _turned(a: FloatArray) -> FloatArray:
    return np.swapaxes(a, -1, -2)
