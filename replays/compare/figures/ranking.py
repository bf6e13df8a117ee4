"""Rankings: methods and representations by how much of the raw poses' error they leave.

A score is the geometric mean over the motions and degradations of a scope of (metric / raw metric),
seed by seed; ``score`` is the same of the mean of the four ratios, which is what parameters are
tuned by. Each seed of a motion gives one score; motions and their seeds are drawn anew to tell how
far scores and ranks can be trusted. Only what has a result in every cell of the scope is ranked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.replays.compare.cells import RAW
from motorcade.replays.compare.figures.statistics import (
    PRACTICAL_SHARE,
    Group,
    bootstrap,
    resampling,
)
from motorcade.replays.compare.measure.evaluator import METRICS

RANKED = (
    "score",
    "ape_rmse_m",
    "rotation_rmse_deg",
    "linear_jitter_m_s2",
    "angular_jitter_rad_s2",
)
_COLUMNS = [METRICS.index(metric) for metric in RANKED[1:]]

Name = tuple[str, str]


def rankings(groups: Sequence[Group]) -> list[dict[str, Any]]:
    """A ranking for every scope and metric; ranks begin at 1 and the best comes first.

    `rank_low` and `rank_high` bound the rank in 95 % of the resamples; `ties_with_best` says that
    the paired interval of the difference from the first contains 0, or its mean is below 1 %.
    """
    made = []
    for scope, chosen in _scopes(groups):
        names, scores, unranked = _scores(chosen)
        if not names:
            continue
        counts = _resampled(chosen)
        for k, metric in enumerate(RANKED):
            rows = _ranked(names, scores[:, :, k], counts)
            made.append(
                {
                    "scope": scope,
                    "metric": metric,
                    "rows": rows,
                    "unranked": [list(name) for name in unranked],
                }
            )
    return made


def ratios_to_motor(groups: Sequence[Group]) -> list[dict[str, Any]]:
    """Geometric mean of (metric / the same method's on motors), over the cells of each scope.

    For every method and, as method "all", over those that are complete in every representation.
    """
    made = []
    for scope, chosen in _scopes(groups):
        names, scores, unranked = _scores(chosen)
        if not names:
            continue
        counts = _resampled(chosen)
        at = {name: i for i, name in enumerate(names)}
        parts: dict[str, list[FloatArray]] = {}
        partly = {method for method, _ in unranked}
        for method, representation in names:
            if (method, "motor") not in at or representation == "none":
                continue
            ratio = scores[:, at[method, representation]] - scores[:, at[method, "motor"]]
            if method not in partly:
                parts.setdefault(representation, []).append(ratio)
            made += _ratio_rows(scope, method, representation, ratio, counts)
        for representation, ratios in parts.items():
            made += _ratio_rows(scope, "all", representation, np.mean(ratios, axis=0), counts)
    return made


def _scopes(groups: Sequence[Group]) -> list[tuple[str, list[Group]]]:
    made = [("all", list(groups))]
    for field in ("motion", "degradation"):
        values = dict.fromkeys(getattr(group, field) for group in groups)
        made += [
            (f"{field}:{value}", [g for g in groups if getattr(g, field) == value])
            for value in values
        ]
    return made


def _scores(groups: Sequence[Group]) -> tuple[list[Name], FloatArray, list[Name]]:
    """Names, logarithms of scores ``(M * S, P, 5)``, and the names that are not complete.

    A row is a seed of a motion, the mean over its degradations; motions one after another.
    """
    names = list(dict.fromkeys(name for group in groups for name in group.names))
    motions, seeds = _motions(groups), len(groups[0].seeds)
    total = np.zeros((len(motions) * seeds, len(names), len(RANKED)))
    for group in groups:
        first = motions.index(group.motion) * seeds
        part = total[first : first + seeds]
        column = {name: i for i, name in enumerate(group.names)}
        raw = group.values[:, column[RAW]][:, _COLUMNS]
        for i, name in enumerate(names):
            if name not in column:
                part[:, i] = np.nan
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = group.values[:, column[name]][:, _COLUMNS] / raw
                logs = np.log(np.concatenate([np.mean(ratio, axis=1)[:, None], ratio], axis=1))
            part[:, i] += logs * (len(motions) / len(groups))
    whole = np.all(np.isfinite(total), axis=(0, 2))
    kept = [name for name, good in zip(names, whole, strict=True) if good]
    return kept, total[:, whole], [n for n, good in zip(names, whole, strict=True) if not good]


def _resampled(groups: Sequence[Group]) -> FloatArray:
    return resampling(len(groups[0].seeds), len(_motions(groups)))


def _motions(groups: Sequence[Group]) -> list[str]:
    return list(dict.fromkeys(group.motion for group in groups))


def _ranked(names: list[Name], scores: FloatArray, counts: FloatArray) -> list[dict[str, Any]]:
    found = bootstrap(scores, counts)
    drawn = counts @ scores / scores.shape[0]
    ranks = 1 + np.argsort(np.argsort(drawn, axis=1, kind="stable"), axis=1, kind="stable")
    low, high = np.percentile(ranks, (2.5, 97.5), axis=0, method="nearest")
    order = np.argsort(found.mean, kind="stable")
    behind = bootstrap(scores - scores[:, order[:1]], counts)
    return [
        {
            "rank": place + 1,
            "method": names[i][0],
            "representation": names[i][1],
            "ratio_to_raw": _rounded(np.exp(found.mean[i])),
            "ratio_low": _rounded(np.exp(found.low[i])),
            "ratio_high": _rounded(np.exp(found.high[i])),
            "rank_low": int(low[i]),
            "rank_high": int(high[i]),
            "ties_with_best": bool(
                behind.mean[i] <= np.log1p(PRACTICAL_SHARE) or behind.low[i] <= 0.0
            ),
        }
        for place, i in enumerate(order)
    ]


def _ratio_rows(
    scope: str, method: str, representation: str, ratio: FloatArray, counts: FloatArray
) -> list[dict[str, Any]]:
    found = bootstrap(ratio, counts)
    return [
        {
            "scope": scope,
            "method": method,
            "representation": representation,
            "metric": metric,
            "ratio_to_motor": _rounded(np.exp(found.mean[k])),
            "ratio_low": _rounded(np.exp(found.low[k])),
            "ratio_high": _rounded(np.exp(found.high[k])),
        }
        for k, metric in enumerate(RANKED)
    ]


def _rounded(value: float) -> float | None:
    return float(f"{value:.6g}") if np.isfinite(value) else None
