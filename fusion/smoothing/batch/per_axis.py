"""The most probable path, each axis for itself: by smoothing splines, wrong poses told apart.

Near a path that is known roughly, poses are columns of numbers: the path's steps summed up, and
behind that by how much each measured pose lies off (rolling without slipping: P. E. Jupp, J. T.
Kent, Fitting smooth paths to spherical data, Applied Statistics 36, 1987). Each column has the
spline that it calls for (see `columns`), the path is moved by it, and the columns are taken anew
from there. What is neglected is that a turn of the path turns the errors along with it: the answer
depends on that by products of noise and of the turn from pose to pose, not of noise alone. Only
where the path turns by radians within the time that a stiff spline averages over do these add up
until a correction outgrows the one before; then half of it is taken from there on.

Poses count by how far they lie from what the others say, as Student's errors of few degrees of
freedom have it (K. L. Lange, R. J. A. Little, J. M. G. Taylor, Robust statistical modeling using
the t distribution, J. American Statistical Association 84, 1989). It begins with the longest smooth
chain of them (`inliers`), after runs that are a flat marker's other candidate were mirrored back
(`mirrored`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import lgamma, log

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.prediction import EQUAL, standard_errors
from motorcade.fusion.smoothing.batch.columns import (
    COARSE,
    FINE,
    MEMORIES,
    ORDERS,
    ChosenColumn,
    ColumnModel,
    ColumnSegment,
    Prediction,
    chosen,
    likelihoods,
    moved_together,
    noise_of,
    ratio_of,
    splined,
)
from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga.arrays import FloatArray, IntArray

# Degrees of freedom of errors that poses are first weighed by: so few that one ten deviations off
# hardly counts, whatever the others tell.
HEAVY_TAILS = 6.0
NORMAL_TAILS = float("inf")
LAST_STEPS = 5
_TAILS = (3.0, HEAVY_TAILS, 12.0, 25.0, 50.0, NORMAL_TAILS)
# Poses that would count less under the first are left out.
_REJECTED = 0.1
# The models are chosen on so many rows at most, in a few segments of the path.
_SEGMENTS, _SEGMENT = 4, 1000
_TAIL_ROUNDS = 20
# Poses that lie off by less than this share of a usual step are as good as any, whatever is found
# of their noise: where there is none, splines miss the motion itself by so much.
_RESOLVED, _ROUNDING = 0.002, 1e-12
# Where the others' variance, in that of a pose, is larger than the second they cannot judge a pose:
# ten deviations off would pass for one and a half. One that was left out stays so. Axes whose usual
# variance is larger than the first are not smoothed, and judge none.
_JUDGES, _UNSURE = 10.0, 50.0
# Squares of corrections that grow by more than this from one to the next lead away.
_RUNS_AWAY = 2.0
# Rows at once, for the sake of memory.
_CHUNK = 1 << 14
# Of the poses that counted, so many must be left.
_FEWEST_KEPT = 0.7


@dataclass(frozen=True, eq=False)
class Measured:
    """Measured poses as coordinates ``(N, D)`` of a representation, at stamps ``(N,)``.

    Before the rows `jumps` their level jumps; see `jumps`. Poses that are none of `motion` are left
    out for good.
    """

    representation: Representation
    time_s: FloatArray
    coordinates: FloatArray
    jumps: IntArray
    motion: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class PerAxisPath:
    """A path near to measured poses.

    Fields:
        coordinates: ``(N, D)`` of the representation.
        weights: ``(N,)`` about 1 where a measured pose counts fully, 0 where it is left out.
        squares: ``(N,)`` squared distances of measured poses from what the others make of them, in
            deviations of that: near the number of columns where all is right, infinite where they
            do not tell whether one that is left out is right.
        noise: ``(d,)`` deviations of measured poses of weight 1.
        spread: ``(N, d)`` variance of the path, in that of measured poses of weight 1.
        left_out: ``(N, d)`` measured poses less what the others make of them.
    """

    coordinates: FloatArray
    weights: FloatArray
    squares: FloatArray
    noise: FloatArray
    spread: FloatArray
    left_out: FloatArray


@dataclass(frozen=True)
class AxisModels:
    """The models of all columns, and how well they predict.

    Fields:
        columns: a model each.
        score: logarithm of the density of every pose given the others; the larger the better.
    """

    columns: tuple[ColumnModel, ...]
    score: float

    @property
    def unobservable(self) -> int:
        """Of how many the noise is not told."""
        return sum(bool(one.unobservable) for one in self.columns)


def chosen_models(
    measured: Measured,
    path: FloatArray,
    weights: FloatArray,
    orders: tuple[int, ...] = ORDERS,
    equal: float = EQUAL,
    known: FloatArray | None = None,
) -> AxisModels:
    """The models that measured poses call for, near a path ``(N, D)``; see `columns.chosen`.

    Given `known`, for the last time, errors that last are looked for too; see `lasting`.
    """
    segments = _segments(measured, path, weights)
    columns = chosen(segments, orders, equal, known)
    models = [one.model for one in columns]
    if known is not None:
        models = with_lasting_errors(segments, columns, measured.representation.ends, known)
        interval_s = float(np.median(np.diff(segments[0].time_s)))
        searched = np.isnan(known)
        models = [
            model.told(interval_s) if search else model
            for model, search in zip(models, searched, strict=True)
        ]
    return AxisModels(tuple(models), float(sum(one.density for one in columns)))


def smoothed_per_axis(
    measured: Measured,
    path: FloatArray,
    weights: FloatArray,
    models: AxisModels,
    tails: float,
    steps: int,
) -> PerAxisPath:
    """Smooth measured poses by models, near a path ``(N, D)`` and from weights ``(N,)``.

    Args:
        measured: on the branches of the path.
        path: to start from.
        weights: to start from.
        models: of the columns.
        tails: degrees of freedom of the errors.
        steps: how often columns and weights are taken anew.
    """
    path, axes = np.array(path), len(models.columns)
    spread, left_out = np.empty((2, len(path), axes))
    share, before, kept = 1.0, float("inf"), (path, path)
    for _ in range(steps):
        summed, moved = developed(measured, path)
        squares, noise = np.zeros(len(path)), np.empty(axes)
        unsure, known = np.zeros(len(path), dtype=np.bool_), np.ones(len(path), dtype=np.bool_)
        together = moved_together(
            measured.representation,
            measured.time_s,
            measured.coordinates,
            path,
            weights,
            models.columns,
        )
        for k, model in enumerate(models.columns):
            column = together.get(k) or splined(
                measured.time_s,
                moved[:, k],
                weights,
                model.order,
                model.ratio,
                measured.jumps,
                memory_s=model.memory_s,
            )
            noise[k] = noise_of([column], [weights])
            off = column.left_out / least(noise[k], summed[:, k])
            squares += off**2 / (1.0 + column.variance)
            if np.median(column.variance[weights > 0.0]) < _JUDGES:
                unsure |= column.variance > _UNSURE
            spread[:, k], left_out[:, k] = column.spread, column.left_out
            known &= column.spread <= _UNSURE
            moved[:, k] = column.values if k in together else column.values - summed[:, k]
        squares[unsure & (weights == 0.0)] = np.inf
        counted = weights > 0.0  # what lies between runs away where nothing holds it
        square = np.mean(moved**2, axis=0, where=counted[:, None])
        size = float(np.sum(square / np.maximum(noise, _ROUNDING) ** 2))
        if size > before:
            share *= 0.5
        if size > _RUNS_AWAY * before:
            path, moved = np.array(kept[0]), kept[1]
        else:
            before, kept = size, (np.array(path), moved)
        _move(measured.representation, path, share * moved)
        _let_stand(path, known | (weights > 0.0))
        used, weights = weights, weights_of(squares, axes, tails) * measured.motion
        if np.count_nonzero(weights) < _FEWEST_KEPT * np.count_nonzero(used):
            # Not wrong poses but motion that the models do not have.
            weights = used
        if np.any((weights > 0.0) != counted):
            # Another path is looked for, so that a larger correction leads nowhere astray.
            share, before = 1.0, float("inf")
    return PerAxisPath(path, used, squares, noise, spread, left_out)


def settled(
    measured: Measured, estimate: PerAxisPath, models: AxisModels, tails: float
) -> PerAxisPath:
    """The same by other models and tails."""
    weights = weights_of(estimate.squares, len(models.columns), tails) * measured.motion
    return smoothed_per_axis(measured, estimate.coordinates, weights, models, tails, LAST_STEPS)


def smoother(
    measured: Measured,
    estimate: PerAxisPath,
    columns: tuple[ColumnModel, ...],
    tails: float,
    smoothness: float,
) -> PerAxisPath:
    """The same at another smoothness; poses count as they did, however far it moves from them."""
    interval_s = float(np.median(np.diff(measured.time_s)))
    models = AxisModels(tuple(one.smoother(smoothness, interval_s) for one in columns), 0.0)
    weights = estimate.weights
    for _ in range(LAST_STEPS):
        estimate = smoothed_per_axis(measured, estimate.coordinates, weights, models, tails, 1)
    return estimate


def _move(representation: Representation, path: FloatArray, moved: FloatArray) -> None:
    for start in range(0, len(path), _CHUNK):
        rows = slice(start, start + _CHUNK)
        path[rows] = representation.retract(path[rows], moved[rows])


def _let_stand(path: FloatArray, known: NDArray[np.bool_]) -> None:
    """Lay a path to rest before the first known row and behind the last: polynomials run away.

    A row is unknown where the path's own spread tells as much.
    """
    rows = np.flatnonzero(known)
    path[: rows[0]], path[rows[-1] + 1 :] = path[rows[0]], path[rows[-1]]


def weights_of(squares: FloatArray, columns: int, tails: float) -> FloatArray:
    """How much poses ``(N,)`` count, by their distances; 0 where they are left out."""
    first = (HEAVY_TAILS + columns) / (HEAVY_TAILS + squares)
    weights = first if tails == HEAVY_TAILS else _student(squares, columns, tails)
    return np.asarray(np.where(first < _REJECTED, 0.0, weights), dtype=np.float64)


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


def least(noise: float, summed: FloatArray) -> float:
    """Deviation of an axis's errors, no less than what counts beside the steps of its path."""
    usual_step = float(np.sqrt(np.mean(np.diff(summed) ** 2)))
    return max(float(noise), _RESOLVED * usual_step, _ROUNDING)


def developed(measured: Measured, path: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The path's steps summed up ``(N, d)``, and how far measured poses lie from there."""
    local, count = measured.representation.local, len(path)
    axes = local(path[:1], path[:1]).shape[1]
    summed, offset = np.empty((count, axes)), np.empty((count, axes))
    last = np.zeros(axes)
    for start in range(0, count, _CHUNK):
        rows = slice(start, min(start + _CHUNK, count))
        before = path[max(start - 1, 0) : rows.stop - 1]
        here = summed[rows]
        here[: len(here) - len(before)] = 0.0
        here[len(here) - len(before) :] = local(path[rows.stop - len(before) : rows.stop], before)
        here[0] += last
        np.cumsum(here, axis=0, out=here)
        last = here[-1]
        offset[rows] = here + local(measured.coordinates[rows], path[rows])
    return summed, offset


def _segments(measured: Measured, path: FloatArray, weights: FloatArray) -> list[ColumnSegment]:
    if len(path) <= _SEGMENTS * _SEGMENT:
        _, offset = developed(measured, path)
        return [ColumnSegment(measured.time_s, offset, weights, measured.jumps)]
    # Rows of no weight tell nothing, and long runs of them leave a segment without any.
    kept = np.flatnonzero(weights)
    rows = [kept]
    if len(kept) > _SEGMENTS * _SEGMENT:
        starts = np.linspace(0, len(kept) - _SEGMENT, _SEGMENTS).astype(np.int64)
        rows = [kept[start : start + _SEGMENT] for start in starts]
    return [_segment(measured, path, weights, row) for row in rows]


def _segment(
    measured: Measured, path: FloatArray, weights: FloatArray, rows: IntArray
) -> ColumnSegment:
    """Some rows of a path, of which but these and those between need be developed."""
    between = slice(int(rows[0]), int(rows[-1]) + 1)
    part = replace(measured, coordinates=measured.coordinates[between])
    _, offset = developed(part, path[between])
    time_s, jumps = measured.time_s[rows], _among(rows, measured.jumps)
    return ColumnSegment(time_s, offset[rows - rows[0]], weights[rows], jumps)


def _among(rows: IntArray, jumps: IntArray) -> IntArray:
    """Before which of some rows of a path its level jumps, counted among them."""
    places = np.unique(np.searchsorted(rows, jumps))
    return places[(places > 0) & (places < len(rows))]


# Errors of columns that last for some values, as those of trackers do that reuse their features.
#
# A spline takes such for motion; but no body moves as they do: they wander as its position cannot,
# which has a velocity. So where errors that decay with a memory make the columns of rotation, or of
# translation, clearly likelier together than white ones, and predict each as well, they are taken
# (a process of G. E. Uhlenbeck, L. S. Ornstein, On the theory of the Brownian motion, Physical
# Review 36, 1930; between even stamps it is autoregressive).

_FEWEST = 0.1
# Shares of an error that are left at the next value. Where errors have a memory at all, the first
# explains them better than none does; where noise changes in size a longer one alone would.
_FIRST, _OTHERS = 0.5, (0.3, 0.7, 0.8, 0.9, 0.95)


def with_lasting_errors(
    segments: Sequence[ColumnSegment],
    chosen: Sequence[ChosenColumn],
    ends: Sequence[int],
    known: FloatArray,
) -> list[ColumnModel]:
    """The models of columns, with errors that last where these are likelier, and one memory in each
    group of columns; errors whose deviations ``(K,)`` are known are white.
    """
    models = [one.model for one in chosen]
    interval_s = float(np.median(np.diff(segments[0].time_s)))
    for first, end in zip((0, *ends), (*ends, len(chosen)), strict=True):
        group = range(first, end)
        # What goes through its values shows no errors that could last.
        if any(np.isfinite(known[k]) or models[k].noise_alone(interval_s) < _FEWEST for k in group):
            continue
        for k, lasting in _likeliest(segments, chosen, group).items():
            if standard_errors(lasting.squares[k] - chosen[k].best.squares[k]) <= EQUAL:
                noise = float(lasting.noise[k])
                models[k] = ColumnModel(lasting.order, lasting.ratio, noise, lasting.memory_s)
    return models


def _likeliest(
    segments: Sequence[ColumnSegment], chosen: Sequence[ChosenColumn], group: range
) -> dict[int, Prediction]:
    """The likeliest models of a group whose errors last; none where white ones do as well.

    Their memory must make the values likelier by as much as G. Schwarz asks for of one number more
    (Estimating the dimension of a model, Annals of Statistics 6, 1978). Where all motion would be
    errors that last, as stiff as splines get, it is no memory that was found.
    """
    interval_s = float(np.median(np.diff(segments[0].time_s)))
    white = sum(chosen[k].likelihood for k in group)
    tried = {_FIRST: _searched(segments, group, interval_s, _FIRST)}
    if tried[_FIRST][0] <= white:
        return {}
    count = sum(len(segment.time_s) for segment in segments)
    spanned = [kept for kept in _OTHERS if -np.log(kept) * count >= MEMORIES]
    tried |= {kept: _searched(segments, group, interval_s, kept) for kept in spanned}
    kept = max(tried, key=lambda share: tried[share][0])
    best, models = tried[kept]
    rows = count * len(group)
    stiffest = min(level for _, level in models)
    if best <= white + 0.5 * float(np.log(rows)) or stiffest <= COARSE[0]:
        return {}
    memory_s = -interval_s / float(np.log(kept))
    return {
        k: Prediction.by(segments, order, ratio_of(level, order, interval_s), memory_s)
        for k, (order, level) in zip(group, models, strict=True)
    }


def _searched(
    segments: Sequence[ColumnSegment], group: range, interval_s: float, kept: float
) -> tuple[float, list[tuple[int, float]]]:
    """How likely a group is with a memory, at its likeliest orders and levels, and these."""
    memory_s = -interval_s / float(np.log(kept))
    tried: dict[tuple[int, float], FloatArray] = {}

    def likelihood(model: tuple[int, float], k: int) -> float:
        if model not in tried:
            order, level = model
            tried[model] = likelihoods(
                segments, order, ratio_of(level, order, interval_s), memory_s
            )
        return float(tried[model][k])

    coarse = [(order, float(level)) for order in ORDERS for level in COARSE]
    total, models = 0.0, []
    for k in group:
        order, level = max(coarse, key=lambda model: likelihood(model, k))
        near = [(order, level + step) for step in (0.0, *FINE.tolist())]
        models.append(max(near, key=lambda model: likelihood(model, k)))
        total += likelihood(models[-1], k)
    return total, models
