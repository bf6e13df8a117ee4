"""Jumps of level: where a path goes on elsewhere, as after a map was corrected or the camera found.

Nothing moves so: between two poses the value is another and its derivatives go on. Such a jump is
kept, and the path is smoothed on both sides of it. It is told from one wrong pose, and from a
camera that moves fast, by what each would save of squared residuals: a free value before a row, a
free slope, and a pose left out, each of which costs one number an axis (I. Chang, G. C. Tiao, C.
Chen, Estimation of time series parameters in the presence of outliers, Technometrics 30, 1988; C.
Chen, L.-M. Liu, Joint estimation of model parameters and outlier effects in time series, J.
American Statistical Association 88, 1993).

A level that goes and comes back to where it was is no correction but a run of poses that are wrong
together, as of a camera found in the wrong place: nothing else returns by chance within the noise.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from operator import itemgetter
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from motorcade.fusion.smoothing.batch.columns import splined
from motorcade.fusion.smoothing.batch.per_axis import (
    AxisModels,
    Measured,
    chosen_models,
    developed,
    least,
)
from motorcade.fusion.smoothing.batch.predicted import FEWEST_AT_LEVEL
from motorcade.fusion.smoothing.native import _columns
from motorcade.ga.arrays import FloatArray, IntArray

# A path without jumps is told to have one this rarely.
_FALSE_ALARM = 0.01
# By how much larger than normal ones this quantile of errors is, so much more a jump must save: of
# thousands of errors with heavy tails two or three look like one. Jumps themselves are fewer.
_TAIL = 0.98
# What a jump must save beside a free slope and a pose left out. Chosen on V1_02 and synthetic
# motions.
_AHEAD = 4.0 / 3.0
# Rows to both sides in which the largest saving counts, and another cause is looked for.
_NEAR = 2
# Poses to both sides that tell how large errors are there.
_AROUND = 40
_ROUNDS = 5
# What is neglected where a body turns fast is a share of the offset, which is gone after few.
_ROUNDS_BACK = 3


def with_jumps(
    measured: Measured, path: FloatArray, weights: FloatArray, models: AxisModels
) -> tuple[Measured, AxisModels]:
    """Measured poses with their jumps of level, and the models of order 2 that they then call for.

    Args:
        measured: poses.
        path: near them ``(N, D)``.
        weights: ``(N,)`` of the poses, 0 where one is left out.
        models: that poses call for without jumps.
    """
    for _ in range(_ROUNDS):
        more = _more_jumps(measured, path, weights, models)
        if not more.size:
            break
        measured = replace(measured, jumps=np.union1d(measured.jumps, more))
        models = chosen_models(measured, path, weights, (2,))
    for row in measured.jumps.tolist():
        without = replace(measured, jumps=measured.jumps[measured.jumps != row])
        jump, single = (_savings(one, path, weights, models) for one in (without, measured))
        least_saved = _least_saved(single[2], np.flatnonzero(weights), len(models.columns))
        if jump[0, row] < least_saved[row]:
            measured = without
    return measured, models


class ReturnedLevel(NamedTuple):
    """A run of rows whose level returns behind it, and their coordinates ``(K, D)`` moved back."""

    first: int
    last: int
    coordinates: FloatArray


def returned_levels(
    measured: Measured, path: FloatArray, weights: FloatArray, models: AxisModels
) -> list[ReturnedLevel]:
    """Runs between two jumps behind which the level is that before; of less than half the poses.

    One offset an axis then explains the poses as well as two jumps do, but for what chance does; or
    better than one jump, where too few poses for another have returned before an end.
    """
    count, jumps = len(weights), measured.jumps.tolist()
    pairs = [
        *pairwise(jumps),
        *((row, jumps[0]) for row in range(1, min(FEWEST_AT_LEVEL, jumps[0]))),
        *((jumps[-1], row) for row in range(max(count - FEWEST_AT_LEVEL, jumps[-1]) + 1, count)),
    ]
    most = _quantile(len(models.columns), 1.0 - _FALSE_ALARM)
    by_jumps = squares_left(measured, path, weights, models)
    tried, returned = list[tuple[float, ReturnedLevel]](), list[ReturnedLevel]()
    for first, last in pairs:
        if 2 * np.count_nonzero(weights[first:last]) < count:
            left, worse, run = _moved_back(measured, path, weights, models, first, last)
            if worse < most and (left + most < by_jumps or {first, last} <= set(jumps)):
                tried.append((left, run))
    for _, run in sorted(tried, key=itemgetter(0)):
        if all(run.first > o.last or run.last < o.first for o in returned):
            returned.append(run)
    return returned


def _moved_back(
    measured: Measured,
    path: FloatArray,
    weights: FloatArray,
    models: AxisModels,
    first: int,
    last: int,
) -> tuple[float, float, ReturnedLevel]:
    """Squared residuals, in the noise's variance, that one offset of a run leaves, and by how much
    more than its two jumps do; and the run moved by it: first by its leaps, then by generalised
    least squares.
    """
    local, retract = measured.representation.local, measured.representation.retract
    leaps = []
    for row in (first, last):
        before = path[row - 1 : row]
        usual = retract(before, local(before, path[max(row - 2, 0)][None]))
        leaps.append(local(path[row : row + 1], usual))
    offset, run = 0.5 * (leaps[0] - leaps[1])[0], slice(first, last)
    coordinates, path = np.array(measured.coordinates), np.array(path)
    others, both = (join(measured.jumps, [first, last]) for join in (np.setdiff1d, np.union1d))
    for _ in range(_ROUNDS_BACK):
        for rows in (coordinates, path):
            rows[run] = retract(rows[run], np.tile(-offset, (last - first, 1)))
        summed, values = developed(replace(measured, coordinates=coordinates), path)
        left, worse, offset = 0.0, 0.0, np.empty(values.shape[1])
        for k, model in enumerate(models.columns):
            noise, unit = least(model.noise, summed[:, k]), np.zeros(len(values))
            unit[run] = noise
            columns = np.column_stack([values[:, k], unit, values[:, k] + unit] * 2)
            kind = (model.order, model.ratio, model.memory_s)
            free, held = (
                _columns.spline(measured.time_s, columns, weights, jumps, *kind)[1]
                for jumps in (both, others)
            )
            product = 0.5 * (held[2] - held[0] - held[1])
            offset[k] = noise * product / held[1]
            squares = held[0] - product**2 / held[1]
            left, worse = left + squares / noise**2, worse + (squares - free[0]) / noise**2
    moved = retract(coordinates[run], np.tile(-offset, (last - first, 1)))
    return left, worse, ReturnedLevel(first, last, moved)


def squares_left(
    measured: Measured, path: FloatArray, weights: FloatArray, models: AxisModels
) -> float:
    """Squared residuals that measured poses with their jumps leave, in the noise's variance."""
    summed, values = developed(measured, path)
    left = 0.0
    for k, model in enumerate(models.columns):
        kind = (model.order, model.ratio, model.memory_s)
        column = np.ascontiguousarray(values[:, k : k + 1])
        squares = _columns.spline(measured.time_s, column, weights, measured.jumps, *kind)[1]
        left += squares[0] / least(model.noise, summed[:, k]) ** 2
    return left


def _more_jumps(
    measured: Measured, path: FloatArray, weights: FloatArray, models: AxisModels
) -> IntArray:
    """Rows before which the level jumps, beside those that are known."""
    kept = np.flatnonzero(weights)
    jump, slope, single = _savings(measured, path, weights, models)
    least_saved = _least_saved(single, kept, len(models.columns))
    other = _largest_near(np.maximum(slope, single))
    jumping = (jump > least_saved) & (jump >= _largest_near(jump)) & (jump > _AHEAD * other)
    # Between two poses that count any row would do: the level changes with the later one.
    rows = kept[np.searchsorted(kept, np.flatnonzero(jumping))]
    rows = rows[weights[rows - 1] > 0.0]  # over a run left out it is judged with the run
    edges = np.concatenate([[kept[0]], measured.jumps, [kept[-1] + 1]])
    places, borders = np.searchsorted(kept, rows), np.searchsorted(kept, edges)
    far = np.min(np.abs(places[:, None] - borders), axis=1, initial=len(kept))
    return np.unique(rows[far >= FEWEST_AT_LEVEL])


def _least_saved(single: FloatArray, kept: IntArray, axes: int) -> FloatArray:
    """What a jump before each row ``(N,)`` must save, by what leaving its pose out does."""
    tail = float(np.quantile(single[kept], _TAIL)) / _quantile(axes, _TAIL)
    rare = _quantile(axes, 1.0 - _FALSE_ALARM / len(kept))
    return max(1.0, tail) * rare * _size_around(single, kept, axes)


def _savings(
    measured: Measured, path: FloatArray, weights: FloatArray, models: AxisModels
) -> FloatArray:
    """Squared residuals ``(3, N)``, in the noise's variance, that each cause at a row would save.

    These are a jump of the level before it, one of the slope, and that its pose is wrong.
    """
    summed, offset = developed(measured, path)
    saved, shocks = np.zeros((3, len(offset))), np.empty((len(offset), 1, 2))
    for k, model in enumerate(models.columns):
        column = splined(
            measured.time_s,
            offset[:, k],
            weights,
            model.order,
            model.ratio,
            measured.jumps,
            shocks,
            model.memory_s,
        )
        variance = least(model.noise, summed[:, k]) ** 2
        saved[:2] += shocks[:, 0].T ** 2 / variance
        counted = weights > 0.0
        saved[2, counted] += (column.left_out**2 / (1.0 + column.variance))[counted] / variance
    return saved


def _size_around(single: FloatArray, kept: IntArray, axes: int) -> FloatArray:
    """How many times their variance the errors around each row ``(N,)`` have, but for the nearest.

    Noise that grows for a while makes all savings larger, and so does motion beyond the model.
    """
    total = np.concatenate([[0.0], np.cumsum(single[kept])])
    places = np.searchsorted(kept, np.arange(len(single)))
    squares, rows = np.zeros((2, len(single)))
    for first, last in ((-_AROUND, -FEWEST_AT_LEVEL), (FEWEST_AT_LEVEL, _AROUND)):
        begin, end = (np.clip(places + far, 0, len(kept)) for far in (first, last))
        squares += total[end] - total[begin]
        rows += end - begin
    return np.maximum(1.0, squares / np.maximum(rows, 1.0) / axes)


def _largest_near(savings: FloatArray) -> FloatArray:
    padded = np.pad(savings, _NEAR)
    return np.asarray(
        np.max(np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEAR + 1), axis=1)
    )


def _quantile(freedom: int, probability: float) -> float:
    """Of a sum of so many squares of normal numbers (E. B. Wilson, M. M. Hilferty, 1931)."""
    ninth = 2.0 / (9.0 * freedom)
    return float(freedom * (1.0 - ninth + NormalDist().inv_cdf(probability) * ninth**0.5) ** 3)
