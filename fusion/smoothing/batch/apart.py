"""The most probable path, each axis for itself: by smoothing splines, wrong poses told apart.

Near a path that is known roughly, poses are columns of numbers: the path's steps summed up, and
behind that by how much each measured pose lies off (rolling without slipping: P. E. Jupp, J. T.
Kent, Fitting smooth paths to spherical data, Applied Statistics 36, 1987). Each column has the
spline that it calls for (see `columns`), the path is moved by it, and the columns are taken anew
from there. What is neglected is that a turn of the path turns the errors along with it: the answer
depends on that by products of noise and of the turn from pose to pose, not of noise alone.

Poses count by how far they lie from what the others say, as Student's errors of few degrees of
freedom have it (K. L. Lange, R. J. A. Little, J. M. G. Taylor, Robust statistical modeling using
the t distribution, J. American Statistical Association 84, 1989). It begins with the longest smooth
chain of them (`inliers`), after runs that are a flat marker's other candidate were mirrored back
(`mirrored`).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import lgamma, log

import numpy as np

from motorcade.fusion.smoothing.batch.columns import (
    EQUAL,
    ORDERS,
    ColumnModel,
    ColumnStretch,
    chosen,
    noise_of,
    splined,
)
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga.arrays import FloatArray

# Degrees of freedom of errors that poses are first weighed by: so few that one ten deviations off
# hardly counts, whatever the others tell.
HEAVY_TAILS = 6.0
NORMAL_TAILS = float("inf")
_TAILS = (3.0, HEAVY_TAILS, 12.0, 25.0, 50.0, NORMAL_TAILS)
# Poses that would count less under the first are left out.
_REJECTED = 0.1
# The models are chosen on so many rows at most, in a few stretches of the path.
_STRETCHES, _STRETCH = 4, 1000
_TAIL_ROUNDS = 20
# Poses that lie off by less than this share of a usual step are as good as any, whatever is found
# of their noise: where there is none, splines miss the motion itself by so much.
_RESOLVED, _ROUNDING = 0.002, 1e-12
# Of the poses that counted, so many must be left.
_FEWEST_KEPT = 0.7


@dataclass(frozen=True, eq=False)
class Measured:
    """Measured poses as coordinates ``(N, D)`` of a representation, at stamps ``(N,)``."""

    representation: Representation
    time_s: FloatArray
    coordinates: FloatArray


@dataclass(frozen=True, eq=False)
class ApartPath:
    """A path near to measured poses.

    Fields:
        coordinates: ``(N, D)`` of the representation.
        weights: ``(N,)`` about 1 where a measured pose counts fully, 0 where it is left out.
        squares: ``(N,)`` squared distances of measured poses from what the others make of them, in
            deviations of that: near the number of columns where all is right.
        noise: ``(d,)`` deviations of measured poses of weight 1.
        variance: ``(N, d)`` of the path.
    """

    coordinates: FloatArray
    weights: FloatArray
    squares: FloatArray
    noise: FloatArray
    variance: FloatArray


@dataclass(frozen=True)
class ApartModels:
    """The models of all columns, and how well they predict.

    Fields:
        columns: a model each.
        score: logarithm of the density of every pose given the others; the larger the better.
    """

    columns: tuple[ColumnModel, ...]
    score: float


def chosen_models(
    measured: Measured,
    path: FloatArray,
    weights: FloatArray,
    orders: tuple[int, ...] = ORDERS,
    equal: float = EQUAL,
) -> ApartModels:
    """The models that measured poses call for, near a path ``(N, D)``; see `columns.chosen`."""
    _, offset = _developed(measured, path)
    stretches = _stretches(measured.time_s, offset, weights)
    found = [chosen(stretches, k, orders, equal) for k in range(offset.shape[1])]
    return ApartModels(tuple(model for model, _ in found), float(sum(score for _, score in found)))


def smoothed_apart(
    measured: Measured,
    path: FloatArray,
    weights: FloatArray,
    models: ApartModels,
    tails: float,
    steps: int,
) -> ApartPath:
    """Smooth measured poses by models, near a path ``(N, D)`` and from weights ``(N,)``.

    Args:
        measured: on the branches of the path.
        path: to start from.
        weights: to start from.
        models: of the columns.
        tails: degrees of freedom of the errors.
        steps: how often columns and weights are taken anew.
    """
    representation = measured.representation
    for _ in range(steps):
        developed, offset = _developed(measured, path)
        moved, variance = np.empty(offset.shape), np.empty(offset.shape)
        squares = np.zeros(len(offset))
        noise = np.empty(offset.shape[1])
        for k, model in enumerate(models.columns):
            column = splined(measured.time_s, offset[:, k], weights, model.order, model.ratio)
            noise[k] = noise_of([column], [weights])
            moved[:, k] = column.values - developed[:, k]
            variance[:, k] = noise[k] ** 2 * column.variance / (1.0 + weights * column.variance)
            least = max(float(noise[k]), _RESOLVED * _usual_step(developed[:, k]), _ROUNDING)
            squares += (column.left_out / least) ** 2 / (1.0 + column.variance)
        path = representation.retract(path, moved)
        used, weights = weights, weights_of(squares, offset.shape[1], tails)
        if np.count_nonzero(weights) < _FEWEST_KEPT * np.count_nonzero(used):
            # Not wrong poses but motion that the models do not have.
            weights = used
    return ApartPath(path, used, squares, noise, variance)


def weights_of(squares: FloatArray, columns: int, tails: float) -> FloatArray:
    """How much poses ``(N,)`` count, by their distances; 0 where they are left out."""
    first = (HEAVY_TAILS + columns) / (HEAVY_TAILS + squares)
    made = first if tails == HEAVY_TAILS else _student(squares, columns, tails)
    return np.asarray(np.where(first < _REJECTED, 0.0, made), dtype=np.float64)


def tails_of(squares: FloatArray, weights: FloatArray, columns: int) -> float:
    """The degrees of freedom under which distances ``(N,)`` of poses that count are likeliest."""
    kept = squares[weights > 0.0]
    likelihoods = []
    for tails in _TAILS:
        # Each at its own likeliest scale, by Lange's iteration.
        scale = 1.0
        for _ in range(_TAIL_ROUNDS):
            weighed = _student(kept / scale, columns, tails) * kept
            scale = max(float(np.mean(weighed)) / columns, 1e-30)
        density = -0.5 * columns * log(scale)
        if tails == NORMAL_TAILS:
            density -= 0.5 * (columns * log(2.0) + float(np.mean(kept)) / scale)
        else:
            density += lgamma(0.5 * (tails + columns)) - lgamma(0.5 * tails)
            density -= 0.5 * columns * log(tails)
            density -= 0.5 * (tails + columns) * float(np.mean(np.log1p(kept / scale / tails)))
        likelihoods.append(density)
    return _TAILS[int(np.argmax(likelihoods))]


def _student(squares: FloatArray, columns: int, tails: float) -> FloatArray:
    if tails == NORMAL_TAILS:
        return np.ones_like(squares)
    return np.asarray((tails + columns) / (tails + squares), dtype=np.float64)


def _usual_step(column: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.diff(column) ** 2)))


def _developed(measured: Measured, path: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The path's steps summed up ``(N, d)``, and how far measured poses lie from there."""
    representation = measured.representation
    steps = representation.local(path[1:], path[:-1])
    developed = np.zeros((len(path), steps.shape[1]))
    np.cumsum(steps, axis=0, out=developed[1:])
    return developed, developed + representation.local(measured.coordinates, path)


def _stretches(time_s: FloatArray, offset: FloatArray, weights: FloatArray) -> list[ColumnStretch]:
    if len(time_s) <= _STRETCHES * _STRETCH:
        return [ColumnStretch(time_s, offset, weights)]
    # Rows of no weight tell nothing, and long runs of them leave a stretch without any.
    kept = np.flatnonzero(weights)
    rows = [kept]
    if len(kept) > _STRETCHES * _STRETCH:
        starts = np.linspace(0, len(kept) - _STRETCH, _STRETCHES).astype(np.int64)
        rows = [kept[start : start + _STRETCH] for start in starts]
    return [ColumnStretch(time_s[row], offset[row], weights[row]) for row in rows]
