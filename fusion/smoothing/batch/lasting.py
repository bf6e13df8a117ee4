"""Errors of columns that last for some values, as those of trackers do that reuse their features.

A spline takes such for motion; but no body moves as they do: they wander as its position cannot,
which has a velocity. So where errors that decay with a memory make the columns of rotation, or of
translation, clearly likelier together than white ones, and predict each as well, they are taken (a
process of G. E. Uhlenbeck, L. S. Ornstein, On the theory of the Brownian motion, Physical Review
36, 1930; between even stamps it is autoregressive).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.fusion.prediction import EQUAL, standard_errors
from motorcade.fusion.smoothing.batch.columns import (
    COARSE,
    FINE,
    ORDERS,
    ChosenColumn,
    ColumnModel,
    ColumnSegment,
    Prediction,
    likelihoods,
    ratio_of,
)
from motorcade.ga.arrays import FloatArray

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
    """The models of columns, with errors that last where these are likelier.

    Args:
        segments: of the path.
        chosen: models with white errors, a column each.
        ends: of the groups of columns whose errors have one memory.
        known: ``(K,)`` deviations that are given, NaN where they are not: given errors are white.
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
    tried |= {kept: _searched(segments, group, interval_s, kept) for kept in _OTHERS}
    kept = max(tried, key=lambda share: tried[share][0])
    best, models = tried[kept]
    rows = sum(len(share.time_s) for share in segments) * len(group)
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
