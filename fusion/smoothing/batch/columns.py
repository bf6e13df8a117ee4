"""Smoothing splines of single columns, and which of them a column calls for.

A column is a number at stamps: one axis of a path. White noise of some density drives its first,
second or third derivative but one (`order` derivatives change, and the one above is noise), and its
measured values have white noise besides; the most probable path is a smoothing spline (G. Wahba,
Improper priors, spline smoothing and the problem of guarding against model errors in regression, J.
Royal Statistical Society B 40, 1978).

Order and density are those that predict best: each value from all others, by generalised
cross-validation (P. Craven, G. Wahba, Smoothing noisy data with spline functions, Numerische
Mathematik 31, 1979). What predicts nearly as well, by no more than the errors' own scatter
explains, counts as equal, and of equals the likeliest is taken: prediction alone is blind to noise
that lasts for some poses, likelihood alone is led astray by motion that the model does not have.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.fusion.smoothing.native import _columns
from motorcade.ga.arrays import FloatArray

ORDERS = (1, 2, 3)
# Logarithms of the process's variance from one value to the next over the noise's that are tried:
# from splines as stiff as a thousand values to such as go through every one; then around the best.
_COARSE, _FINE = np.arange(-28.0, 8.5, 3.0), np.array([-2.0, -1.0, 1.0, 2.0])
# Values farther apart than this do not resolve what hands and vehicles do, and any model takes such
# motion for noise: the spline then goes through every one.
_UNRESOLVED_S = 0.125
_EXACT = 14.0
# Hands tremble at up to 12 Hz and wheels hop as fast: values farther apart than this fold such
# motion back. Where the spline besides follows motion of fewer values a turn than that, too narrow
# a band is left to tell noise in, and it goes through every value. The latter was set on KITTI's
# roads; V1_02 and synthetic motions lose nothing by it.
_FOLDED_S, _FEWEST_A_TURN = 1.0 / 24.0, 3.5
# Predictions count as equal up to so many standard errors of their difference. Chosen on V1_02 and
# synthetic motions.
EQUAL = 1.0


# Stamps, values and weights.
_Part = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True)
class ColumnModel:
    """How a column moves, and how noisy its values are.

    Fields:
        order: how many derivatives change smoothly.
        ratio: density of the noise that drives the highest, in deviations of a value.
        noise: deviation of a value.
    """

    order: int
    ratio: float
    noise: float

    @property
    def density(self) -> float:
        """Of the process, in the column's unit over s^(order + 1) √Hz."""
        return self.ratio * self.noise


@dataclass(frozen=True, eq=False)
class ColumnPath:
    """A smoothed column.

    Fields:
        values: ``(N,)``.
        left_out: ``(N,)`` measured values less what all others make of them.
        variance: ``(N,)`` of what they make, in that of the noise of a value of weight 1.
    """

    values: FloatArray
    left_out: FloatArray
    variance: FloatArray


@dataclass(frozen=True, eq=False)
class ColumnStretch:
    """Columns ``(N, K)`` at stamps ``(N,)`` with the weights ``(N,)`` of their rows; 0 is none."""

    time_s: FloatArray
    values: FloatArray
    weights: FloatArray


def splined(
    time_s: FloatArray, column: FloatArray, weights: FloatArray, order: int, ratio: float
) -> ColumnPath:
    """The smoothing spline of a column ``(N,)``, of which more than `order` rows have a weight."""
    count = len(time_s)
    values, left_out, variance = np.empty((count, 1)), np.empty((count, 1)), np.empty(count)
    given = np.ascontiguousarray(column[:, None])
    _columns.spline(time_s, given, weights, order, ratio, (values, left_out, variance))
    return ColumnPath(values[:, 0], left_out[:, 0], variance)


def noise_of(paths: Sequence[ColumnPath], weights: Sequence[FloatArray]) -> float:
    """Deviation of a value of weight 1, from how far values lie from what the others make."""
    squares = rows = 0.0
    for path, weight in zip(paths, weights, strict=True):
        squares += float(np.sum(weight * path.left_out**2 / (1.0 + weight * path.variance)))
        rows += float(np.count_nonzero(weight))
    return float(np.sqrt(squares / rows))


def chosen(
    stretches: Sequence[ColumnStretch],
    column: int,
    orders: tuple[int, ...] = ORDERS,
    equal: float = EQUAL,
) -> tuple[ColumnModel, float]:
    """The model that a column of some stretches calls for; see the module.

    Args:
        stretches: of the path.
        column: which one.
        orders: that come into question.
        equal: standard errors up to which predictions count as equal; infinite takes the likeliest.

    Returns:
        It, and the logarithm of the density of every value given the others, at its best scale.
    """
    parts = [(one.time_s, one.values[:, column], one.weights) for one in stretches]
    interval_s = float(np.median(np.diff(parts[0][0])))
    levels, fine = (
        (_COARSE, _FINE) if interval_s <= _UNRESOLVED_S else (np.array([_EXACT]), _FINE[:0])
    )
    tried: list[_Prediction] = []

    def predicted(level: float, order: int) -> _Prediction:
        ratio = float(np.exp(0.5 * level)) / interval_s ** (order + 0.5)
        return _Prediction.by(parts, order, ratio)

    for order in orders:
        coarse = [predicted(level, order) for level in levels]
        best = levels[int(np.argmin([one.score for one in coarse]))]
        tried += coarse + [predicted(level, order) for level in best + fine]
    best_of_all = min(tried, key=lambda one: one.score)
    equals = [one for one in tried if one.standard_errors_behind(best_of_all) <= equal]
    taken = max(equals, key=lambda one: _likelihood(parts, one.order, one.ratio))
    if interval_s > _FOLDED_S and taken.values_a_turn(interval_s) < _FEWEST_A_TURN:
        taken = predicted(_EXACT, taken.order)
    rows = sum(len(weight) for _, _, weight in parts)
    density = -0.5 * rows * float(np.log(max(best_of_all.score, 1e-300)))
    return ColumnModel(taken.order, taken.ratio, taken.noise), density


@dataclass(frozen=True, eq=False)
class _Prediction:
    """How well a model predicts values from the others: squared residuals ``(N,)`` of each."""

    order: int
    ratio: float
    noise: float
    squares: FloatArray

    @classmethod
    def by(cls, parts: Sequence[_Part], order: int, ratio: float) -> _Prediction:
        paths = [splined(*part, order, ratio) for part in parts]
        weights = [weight for _, _, weight in parts]
        all_weights = np.concatenate(weights)
        used = all_weights > 0.0
        kept = all_weights[used]
        off = np.concatenate([path.left_out for path in paths])[used]
        share = 1.0 / (1.0 + kept * np.concatenate([path.variance for path in paths])[used])
        # Residuals over the mean share of its noise that a value's residual has: values beside
        # gaps, which tell little, say little.
        squares = kept * (off * share / float(np.mean(share))) ** 2
        return cls(order, ratio, noise_of(paths, weights), squares)

    @property
    def score(self) -> float:
        return float(np.mean(self.squares))

    def values_a_turn(self, interval_s: float) -> float:
        """Of the fastest motion that the spline follows, where process and noise are as strong."""
        rate = (self.ratio / np.sqrt(interval_s)) ** (1.0 / (self.order + 1))
        return float(2.0 * np.pi / (rate * interval_s))

    def standard_errors_behind(self, other: _Prediction) -> float:
        differences = self.squares - other.squares
        scatter = float(np.std(differences))
        return float(np.mean(differences)) * np.sqrt(len(differences)) / scatter if scatter else 0.0


def _likelihood(parts: Sequence[_Part], order: int, ratio: float) -> float:
    """Logarithm of the likelihood of a column, at its likeliest noise."""
    rows = squares = logarithms = 0.0
    for time_s, column, weights in parts:
        found = _columns.spline(
            time_s, np.ascontiguousarray(column[:, None]), weights, order, ratio
        )
        rows, squares, logarithms = rows + found[0], squares + found[1], logarithms + found[2]
    if rows == 0.0:
        return -float("inf")  # all of them only open the state, and tell no model from another
    return -0.5 * (rows * float(np.log(max(squares, 1e-300) / rows)) + logarithms + rows)
