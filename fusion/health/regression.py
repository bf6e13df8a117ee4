"""Linear models fitted to vectors with heavy-tailed noise, so that they can be compared.

The noise is Cauchy's in three dimensions (Student's with one degree of freedom): up to three
quarters of the vectors may be far off before its scale gives way, since one that is infinitely far
counts with 4/3 of the scale's square where all together must make up one. Source: K. Lange,
R. Little, J. Taylor, Robust statistical modeling using the t distribution, JASA 84(408), 1989.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray

_FREEDOM = 1.0
_ITERATIONS = 50
_SETTLED = 0.01  # of the score
_SMALLEST = 1e-6  # of the noise: below what any sensor resolves, and far enough from rounding


@dataclass(frozen=True, eq=False)
class Prior:
    """Means ``(p,)`` and finite deviations ``(p,)`` of the values, known beforehand."""

    mean: FloatArray
    sigma: FloatArray


@dataclass(frozen=True, eq=False)
class RobustFit:
    """What fits best.

    Fields:
        values: ``(p,)``.
        covariance: ``(p, p)``.
        sigma: scale of the noise, an axis.
        score: the logarithm of likelihood times prior at its best, without constants.
    """

    values: FloatArray
    covariance: FloatArray
    sigma: float
    score: float

    @property
    def deviations(self) -> FloatArray:
        """Of the values ``(p,)``."""
        return np.sqrt(np.diag(self.covariance))


def fit(
    target: FloatArray,
    slope: FloatArray,
    prior: Prior,
    start: FloatArray,
    sigma: float | None = None,
) -> RobustFit:
    """RobustFit ``target (N, 3) = slope (N, 3, p) @ values (p,)``, from values to start with.

    It climbs to the nearest summit of the likelihood. What nothing tells stays at its prior. With
    few rows many values leave some rows next to nothing, and the noise's scale would collapse onto
    these: `sigma` holds it where fewer values have put it.
    """
    count = len(target)
    precision, mean = prior.sigma**-2.0, prior.mean
    values = start
    left = target - slope @ values
    square = np.sum(left**2, axis=-1)
    held = sigma is not None
    scale = sigma**2 if sigma is not None else float(np.median(square)) / 3.0
    scale = max(scale, _SMALLEST**2)
    flat = slope.reshape(3 * count, -1)
    score = -np.inf
    for _ in range(_ITERATIONS):
        weight = (_FREEDOM + 3.0) / (_FREEDOM + square / scale)
        weighted = (weight[:, None, None] * slope).reshape(3 * count, -1)
        matrix = weighted.T @ flat / scale + np.diag(precision)
        vector = weighted.T @ target.ravel() / scale + precision * mean
        values = np.linalg.solve(matrix, vector)
        left = target - slope @ values
        square = np.einsum("na,na->n", left, left)
        if not held:
            scale = max(float(weight @ square) / (3.0 * count), _SMALLEST**2)
        before, score = score, _score(square, scale, precision * (values - mean) ** 2)
        if score - before < _SETTLED:
            break
    # The curvature that Student's likelihood has on average: a share (ν + 3)/(ν + 5).
    known = (_FREEDOM + 3.0) / (_FREEDOM + 5.0) * (flat.T @ flat) / scale + np.diag(precision)
    covariance = np.linalg.inv(known).astype(np.float64)
    return RobustFit(values, covariance, float(np.sqrt(scale)), score)


def _score(square: FloatArray, scale: float, doubts: FloatArray) -> float:
    likelihood = 0.5 * (_FREEDOM + 3.0) * float(np.sum(np.log1p(square / (_FREEDOM * scale))))
    return -likelihood - 1.5 * len(square) * float(np.log(scale)) - 0.5 * float(np.sum(doubts))
