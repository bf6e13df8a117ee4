"""How a sensor's readings can stand to what it should read: units, signs, axes, a free turn.

True readings are ``K @ readings``, up to a bias. Where a sensor is as stated K is the identity; a
unit is a multiple of it, axes in another order a signed permutation, a sensor that was turned a
rotation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np

from motorcade.fusion.health.regression import Prior, RobustFit, fit
from motorcade.ga.arrays import FloatArray

# K has elements of about one in any unit that somebody may use, degrees and milli-g included.
_LOOSE = 1e3
_SMALLEST = 1e-6
_STRAINED = 4.0  # deviations
_MOST_LAGS = 40


def _signed_permutations() -> tuple[FloatArray, ...]:
    """All 48: the identity, all signs, then by how many axes they leave."""
    signed = [
        np.eye(3)[list(order)] * np.array(signs)
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]

    def far(matrix: FloatArray) -> tuple[bool, bool, float]:
        same = float(np.trace(matrix))
        return same < 3.0, same > -3.0, float(np.sum(np.abs(matrix - np.eye(3))))

    return tuple(sorted(signed, key=far))


SIGNED_PERMUTATIONS = _signed_permutations()


@dataclass(frozen=True, eq=False)
class AxesEvidence:
    """What was measured beside what a sensor read, linear in K.

    Fields:
        target: ``(N, 3)``.
        block: ``(N, 3, 3, 3)``, its derivative by the elements of K.
        extra: ``(N, 3, q)``, its derivative by all else that is unknown, of which the first three
            are a constant.
        prior: of all else.
        camera_R_imu: ``(3, 3)`` that it takes for true. Where this, times K, is the same no
            measurement tells two models apart.
        gravity: size of the first three of all else, and its deviation, where only that is known.
    """

    target: FloatArray
    block: FloatArray
    extra: FloatArray
    prior: Prior
    camera_R_imu: FloatArray
    gravity: tuple[float, float] | None = None

    def __len__(self) -> int:
        return len(self.target)

    def thinned(self, most: int) -> AxesEvidence:
        """At most so many rows, spread evenly."""
        rows = slice(None, None, max(1, -(-len(self) // most)))
        return replace(
            self, target=self.target[rows], block=self.block[rows], extra=self.extra[rows]
        )

    def strained(self, fit: RobustFit) -> bool:
        """Whether unknowns besides K end far from what is known of them."""
        besides = fit.values[-len(self.prior.mean) :]
        off = np.abs(besides - self.prior.mean) > _STRAINED * self.prior.sigma
        return bool(np.any(off)) or self._surprise(fit) > _STRAINED

    @property
    def repeats(self) -> float:
        """How many rows tell as much as one: slow motions tell the same again and again.

        M. Bartlett, Some aspects of the time-correlation problem in regard to tests of
        significance, Journal of the Royal Statistical Society 98(3), 1935.
        """
        own = np.einsum("naii->na", self.block)
        of_target, other = (_autocorrelation(values) for values in (self.target, own))
        return max(1.0, 1.0 + 2.0 * float(np.sum(of_target * other)))

    def multiple(self, matrix: FloatArray) -> float:
        """A multiple of `matrix` to start with, by least squares."""
        column = np.einsum("naij,ij->na", self.block, matrix)[..., None]
        slope = np.concatenate([column, self.extra], axis=-1).reshape(3 * len(self), -1)
        prior = self._with([0.0])
        rows = np.concatenate([slope, np.diag(1.0 / prior.sigma)])
        values = np.append(self.target.ravel(), prior.mean / prior.sigma)
        return max(float(np.linalg.lstsq(rows, values)[0][0]), _SMALLEST)

    def nothing(self) -> RobustFit:
        """Without the sensor: nothing but a constant."""
        constant = np.broadcast_to(np.eye(3), (len(self), 3, 3))
        return fit(self.target, constant, Prior(np.zeros(3), np.full(3, _LOOSE)), np.zeros(3))

    def along(self, matrix: FloatArray) -> RobustFit:
        """With K as given: nothing of it free."""
        explained = np.einsum("naij,ij->na", self.block, matrix)
        left = self.target - explained
        return self._judged(fit(left, self.extra, self.prior, self._start(left)))

    def scaled(self, matrix: FloatArray, start: float) -> RobustFit:
        """With a multiple of `matrix`, which is the first value."""
        column = np.einsum("naij,ij->na", self.block, matrix)[..., None]
        slope = np.concatenate([column, self.extra], axis=-1)
        prior = self._with([0.0])
        first = np.append(start, self._start(self.target - start * column[..., 0]))
        return self._judged(fit(self.target, slope, prior, first))

    def free(self, start: FloatArray, sigma: float) -> RobustFit:
        """With any K, whose elements are the first nine values; the noise's scale is held."""
        columns = self.block.reshape(*self.block.shape[:2], 9)
        slope = np.concatenate([columns, self.extra], axis=-1)
        left = self.target - columns @ start.ravel()
        first = np.append(start.ravel(), self._start(left))
        return self._judged(fit(self.target, slope, self._with(np.zeros(9)), first, sigma))

    def _start(self, left: FloatArray) -> FloatArray:
        """Unknowns besides K to start with: the constant that is left, the others as believed."""
        others = self.extra[..., 3:] @ self.prior.mean[3:]
        return np.append(np.median(left - others, axis=0), self.prior.mean[3:])

    def _surprise(self, fit: RobustFit) -> float:
        """Deviations by which gravity has another size than expected."""
        if self.gravity is None:
            return 0.0
        rows = slice(-len(self.prior.mean), 3 - len(self.prior.mean) or None)
        vector, covariance = fit.values[rows], fit.covariance[rows, rows]
        size = max(float(np.linalg.norm(vector)), _SMALLEST)
        variance = float(vector @ covariance @ vector) / size**2
        return abs(size - self.gravity[0]) / float(np.sqrt(variance + self.gravity[1] ** 2))

    def _judged(self, fit: RobustFit) -> RobustFit:
        return replace(fit, score=fit.score - 0.5 * self._surprise(fit) ** 2)

    def _with(self, mean: FloatArray | list[float]) -> Prior:
        return Prior(
            np.append(mean, self.prior.mean),
            np.append(np.full(len(mean), _LOOSE), self.prior.sigma),
        )


def order_of(matrix: FloatArray) -> str:
    """The order and signs that put readings right, such as ``(y, -x, z)``."""
    names = []
    for row in matrix:
        axis = int(np.argmax(np.abs(row)))
        names.append(("-" if row[axis] < 0.0 else "") + "xyz"[axis])
    return f"({', '.join(names)})"


def _autocorrelation(values: FloatArray) -> FloatArray:
    """Of vectors ``(N, 3)`` about their median, at lags from 1 on, wild ones clipped."""
    values = values - np.median(values, axis=0)
    limit = 3.0 * float(np.median(np.linalg.norm(values, axis=-1)))
    values = np.clip(values, -limit, limit)
    power = float(np.sum(values**2))
    lags = range(1, max(2, min(len(values) // 4, _MOST_LAGS)))
    if power == 0.0:
        return np.zeros(len(lags))
    return np.array([float(np.sum(values[lag:] * values[:-lag])) / power for lag in lags])
