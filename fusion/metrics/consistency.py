"""Consistency of a filter: whether its errors are as large as its covariances say.

An error of d numbers, normalised and squared by the covariance that the filter states, is χ² with d
degrees of freedom where the filter is right: the NEES of states, the NIS of innovations. Averaged
over R independent runs, R times the average is χ² with R d degrees. Above the upper bound a filter
believes itself too much, below the lower one too little (Y. Bar-Shalom, X. R. Li and T.
Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 5.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray, checked_floats


def normalised_squared(errors: FloatArray, covariances: FloatArray) -> FloatArray:
    """``eᵀ P⁻¹ e`` ``(*)`` of errors ``(*, d)`` with covariances ``(*, d, d)``.

    Raises:
        ValueError: shapes that do not agree, NaN or infinity, or a singular covariance.

    Examples:
        >>> from motorcade.fusion.metrics import normalised_squared
        >>> round(float(normalised_squared([0.2, 0.1], [[0.01, 0.0], [0.0, 0.01]])), 6)
        5.0
    """
    error = checked_floats(errors, "errors", (np.shape(errors)[-1],))
    size = error.shape[-1]
    covariance = checked_floats(covariances, "covariances", (size, size))
    if covariance.shape != (*error.shape, size):
        raise ValueError(
            f"covariances: expected shape {(*error.shape, size)}, got {covariance.shape}"
        )
    try:
        weighed = np.linalg.solve(covariance, error[..., None])[..., 0]
    except np.linalg.LinAlgError as fault:
        raise ValueError("covariances: expected regular matrices, got a singular one") from fault
    return np.asarray(np.sum(error * weighed, axis=-1), dtype=np.float64)


def chi2_bounds(freedom: int, runs: int, probability: float = 0.95) -> tuple[float, float]:
    """Bounds that an average over runs keeps with a probability, as often above them as below.

    Args:
        freedom: degrees of freedom of one run, above zero.
        runs: how many are averaged, above zero.
        probability: above 0 and below 1.

    Raises:
        ValueError: a number out of its range.

    Examples:
        >>> from motorcade.fusion.metrics import chi2_bounds
        >>> low, high = chi2_bounds(freedom=6, runs=50)
        >>> round(low, 2), round(high, 2)
        (5.08, 7.0)
    """
    from scipy.special import gammaincinv

    for name, value in (("freedom", freedom), ("runs", runs)):
        if value < 1:
            raise ValueError(f"{name}: expected 1 or more, got {value}")
    if not 0.0 < probability < 1.0:
        raise ValueError(f"probability: expected above 0 and below 1, got {probability}")
    tail = 0.5 * (1.0 - probability)
    # χ² with n degrees of freedom is a gamma distribution of shape n / 2 and scale 2.
    low, high = 2.0 * gammaincinv(0.5 * runs * freedom, [tail, 1.0 - tail]) / runs
    return float(low), float(high)


def most_by_chance(trials: int, share: float, probability: float = 0.999) -> int:
    """How many of independent trials come up at most, with a probability: a binomial's quantile.

    Args:
        trials: from 0 on.
        share: that comes up in the long run, from 0 to 1.
        probability: above 0 and below 1.

    Raises:
        ValueError: a number out of its range.

    Examples:
        >>> from motorcade.fusion.metrics import most_by_chance
        >>> [most_by_chance(trials, 0.1) for trials in (0, 10, 100, 1000)]
        [0, 5, 20, 130]
    """
    from scipy.special import bdtr

    if trials < 0:
        raise ValueError(f"trials: expected 0 or more, got {trials}")
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"share: expected 0 to 1, got {share}")
    if not 0.0 < probability < 1.0:
        raise ValueError(f"probability: expected above 0 and below 1, got {probability}")
    counts = np.arange(trials + 1)
    return int(np.argmax(bdtr(counts, trials, share) >= probability))


@dataclass(frozen=True, eq=False)
class Consistency:
    """Normalised squared errors of many runs, step by step.

    Fields:
        freedom: degrees of freedom, the expected value.
        runs: how many were averaged.
        average: ``(N,)`` over the runs.
        low, high: bounds of the average at each step.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import Consistency
        >>> values = np.random.default_rng(0).chisquare(6, (50, 200))  # of 50 runs, 200 steps
        >>> found = Consistency.of(values, freedom=6)
        >>> round(found.ratio, 2), round(found.share_within, 2)
        (1.01, 0.95)
    """

    freedom: int
    runs: int
    average: FloatArray
    low: float
    high: float

    @classmethod
    def of(cls, values: FloatArray, freedom: int, probability: float = 0.95) -> Consistency:
        """Average values ``(R, N)`` of R runs.

        Raises:
            ValueError: no runs or steps, NaN or infinity, or a probability out of its range.
        """
        checked = checked_floats(values, "values", (np.shape(values)[-1],))
        if checked.ndim != 2 or checked.size == 0:
            raise ValueError(f"values: expected (runs, steps), got shape {checked.shape}")
        low, high = chi2_bounds(freedom, len(checked), probability)
        return cls(freedom, len(checked), checked.mean(axis=0), low, high)

    @property
    def share_within(self) -> float:
        """Share of the steps whose average lies within the bounds."""
        return float(np.mean((self.average >= self.low) & (self.average <= self.high)))

    @property
    def ratio(self) -> float:
        """The average over all steps, over what is expected: 1 where the filter is right."""
        return float(np.mean(self.average)) / self.freedom
