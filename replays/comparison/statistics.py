"""What the cells say: means and paired differences with intervals, verdicts, rankings.

All intervals are percentile bootstrap intervals of 95 %, drawn from a fixed generator (B. Efron,
R. J. Tibshirani, An introduction to the bootstrap, 1993, ch. 13). On one motion seeds are drawn,
and drawn whole: every method and representation saw the same poses, so differences are formed seed
by seed before they are averaged. Over several motions, which stand for many more, motions are drawn
first, and of each that was drawn its seeds (A. C. Davison, D. V. Hinkley, Bootstrap methods and
their application, 1997, 3.8). With 6 seeds, or 13 motions, such intervals hold some 87 or 91 times
out of 100 rather than 95; and no allowance is made for how many of them are looked at.

Differences are of costs, for which less is better: the metric itself, or its distance from the best
value where that is not zero (lag counts by its size, ratios by their distance from 1). A verdict is

- ``equal``: no seed differs beyond the ninth digit or so;
- ``tie``: the interval contains 0, or the mean is below the practical bound: 1 % of what motors
  cost, or the metric's floor in `FLOORS`;
- ``better`` or ``worse`` than the same method on motors, else.

Rankings are by how much of the raw poses' error is left: a score is the geometric mean over the
motions and degradations of a scope of (metric / raw metric), seed by seed; ``score`` is the same of
the mean of the four ratios, which is what parameters are tuned by. Motions and their seeds are
drawn anew to tell how far ranks can be trusted. Only what has a result in every cell is ranked.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.replays.comparison.evaluator import METRICS
from motorcade.replays.comparison.plan import RAW, ComparisonCell, MeasuredRow

RESAMPLES = 2000
_SEED = 20240229
_LEVEL = (2.5, 97.5)
PRACTICAL_SHARE = 0.01
_EQUAL_SHARE = 1e-7
_BEST_IS_ONE = ("rotation_path_ratio", "peak_rate_ratio")

FLOORS = {
    "ape_rmse_m": 1e-5,
    "rotation_rmse_deg": 1e-3,
    "linear_jitter_m_s2": 1e-3,
    "angular_jitter_rad_s2": 1e-3,
    "log_scale_rmse": 1e-5,
    "lag_ms": 0.1,
    "angular_rate_lag_ms": 0.1,
    "overshoot_m": 1e-4,
    "rotation_overshoot_deg": 1e-2,
    "rotation_path_ratio": 1e-3,
    "peak_rate_ratio": 1e-2,
    "spurious_turns": 0.0,
}
"""Differences up to these have no practical meaning, in the metric's unit."""


@dataclass(frozen=True, eq=False)
class Sample:
    """The rows of one cell as numbers: ``values (R, M)`` for `names` ``(R,)``, NaN: unknown."""

    motion: str
    degradation: str
    seed: int
    names: tuple[tuple[str, str], ...]
    values: FloatArray
    failures: tuple[str, ...]

    @classmethod
    def of(cls, cell: ComparisonCell, rows: Sequence[MeasuredRow]) -> Sample:
        """From a cell and its rows."""
        place = cell.inputs
        return cls.named(place.motion, place.degradation, place.seed, rows)

    @classmethod
    def named(cls, motion: str, degradation: str, seed: int, rows: Sequence[MeasuredRow]) -> Sample:
        """From rows that belong to any place."""
        values = [[row.values.get(metric) for metric in METRICS] for row in rows]
        return cls(
            motion,
            degradation,
            seed,
            tuple((row.method, row.representation) for row in rows),
            np.array(values, dtype=np.float64),
            tuple(row.failure for row in rows),
        )


@dataclass(frozen=True, eq=False)
class Group:
    """All seeds of a motion and a degradation.

    Fields:
        names: methods and representations ``(P,)``; the first is `RAW`.
        seeds: ``(S,)``.
        values: ``(S, P, M)`` metrics; NaN where one was not told.
        failures: ``(P,)`` of how many seeds there is no result, and the first reason.
    """

    motion: str
    degradation: str
    names: tuple[tuple[str, str], ...]
    seeds: tuple[int, ...]
    values: FloatArray
    failures: tuple[tuple[int, str], ...]


@dataclass(frozen=True, eq=False)
class Intervals:
    """Means ``(*)`` with the ends of their intervals; NaN where there was nothing to average."""

    mean: FloatArray
    low: FloatArray
    high: FloatArray


def grouped(samples: Iterable[Sample]) -> list[Group]:
    """Samples by motion and degradation, in the order in which they first come."""
    places: dict[tuple[str, str], dict[int, list[Sample]]] = {}
    for sample in samples:
        seeds = places.setdefault((sample.motion, sample.degradation), {})
        seeds.setdefault(sample.seed, []).append(sample)
    return [_group(*place, seeds) for place, seeds in places.items()]


def _group(motion: str, degradation: str, seeds: dict[int, list[Sample]]) -> Group:
    others = (name for parts in seeds.values() for part in parts for name in part.names)
    names = tuple(dict.fromkeys([RAW, *others]))
    column = {name: i for i, name in enumerate(names)}
    values = np.full((len(seeds), len(names), len(METRICS)), np.nan)
    failures: list[tuple[int, str]] = [(0, "") for _ in names]
    for row, parts in enumerate(seeds.values()):
        for part in parts:
            for name, figures, failure in zip(part.names, part.values, part.failures, strict=True):
                values[row, column[name]] = figures
                if failure:
                    count, first = failures[column[name]]
                    failures[column[name]] = (count + 1, first or failure)
    return Group(motion, degradation, names, tuple(seeds), values, tuple(failures))


def cost(values: FloatArray) -> FloatArray:
    """Costs ``(*, M)`` of metrics ``(*, M)``: less is better, 0 is best."""
    magnitudes: FloatArray = np.abs(values)
    for metric in _BEST_IS_ONE:
        at = METRICS.index(metric)
        magnitudes[..., at] = np.abs(values[..., at] - 1.0)
    return magnitudes


def resampling(seeds: int, motions: int = 1, resamples: int = RESAMPLES) -> FloatArray:
    """How often each resample draws each seed of each motion ``(B, motions * S)``.

    Always the same for that many. As many motions are drawn as there are, and for each that is
    drawn as many of its seeds.
    """
    rng = np.random.default_rng(_SEED)
    of_motion = rng.multinomial(motions, np.full(motions, 1.0 / motions), resamples)
    counts = rng.multinomial(of_motion * seeds, np.full(seeds, 1.0 / seeds))
    return counts.reshape(resamples, -1).astype(np.float64)


def bootstrap(values: FloatArray, counts: FloatArray) -> Intervals:
    """Means over rows of ``(S, *)`` with intervals, given how often resamples draw each row.

    Seeds with NaN are left out for themselves. From fewer than two there is no interval.
    """
    flat = values.reshape(len(values), -1)
    known = np.isfinite(flat)
    filled, some = np.where(known, flat, 0.0), known.astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.sum(filled, axis=0) / np.sum(some, axis=0)
        drawn = (counts @ filled) / (counts @ some)
    ends = np.full((2, flat.shape[1]), np.nan)
    enough = np.sum(known, axis=0) >= 2
    whole = enough & np.all(np.isfinite(drawn), axis=0)
    if np.any(whole):
        ends[:, whole] = np.percentile(drawn[:, whole], _LEVEL, axis=0)
    for at in np.flatnonzero(enough & ~whole):  # resamples that drew no known seed say nothing
        ends[:, at] = np.nanpercentile(drawn[:, at], _LEVEL)
    return Intervals(*(part.reshape(values.shape[1:]) for part in (mean, *ends)))


def verdicts(difference: FloatArray, intervals: Intervals, base: FloatArray) -> list[str]:
    """Verdicts ``(M,)`` on differences ``(S, M)`` from costs ``(S, M)``; see the module.

    "" where nothing can be said.
    """
    rows = []
    with np.errstate(invalid="ignore"):
        size = np.array([_mean(column) for column in base.T])
        largest = np.array([_largest(column) for column in difference.T])
    for i, metric in enumerate(METRICS):
        mean, low, high = intervals.mean[i], intervals.low[i], intervals.high[i]
        if not np.isfinite(mean):
            rows.append("")
        elif largest[i] <= _EQUAL_SHARE * size[i]:
            rows.append("equal")
        elif not np.isfinite(low):
            rows.append("")
        elif low <= 0.0 <= high or abs(mean) <= max(FLOORS[metric], PRACTICAL_SHARE * size[i]):
            rows.append("tie")
        else:
            rows.append("better" if mean < 0.0 else "worse")
    return rows


def _mean(column: FloatArray) -> float:
    known = column[np.isfinite(column)]
    return float(np.mean(known)) if known.size else np.nan


def _largest(column: FloatArray) -> float:
    known = column[np.isfinite(column)]
    return float(np.max(np.abs(known))) if known.size else np.nan


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
    return [
        {
            "scope": scope,
            "metric": metric,
            "rows": _ranked(names, scores[:, :, k], counts),
            "unranked": [list(name) for name in unranked],
        }
        for scope, names, scores, unranked, counts in _ranked_scopes(groups)
        for k, metric in enumerate(RANKED)
    ]


def ratios_to_motor(groups: Sequence[Group]) -> list[dict[str, Any]]:
    """Geometric mean of (metric / the same method's on motors), over the cells of each scope.

    For every method and, as method "all", over those that are complete in every representation.
    """
    rows = []
    for scope, names, scores, unranked, counts in _ranked_scopes(groups):
        at = {name: i for i, name in enumerate(names)}
        parts: dict[str, list[FloatArray]] = {}
        partly = {method for method, _ in unranked}
        for method, representation in names:
            if (method, "motor") not in at or representation == "none":
                continue
            ratio = scores[:, at[method, representation]] - scores[:, at[method, "motor"]]
            if method not in partly:
                parts.setdefault(representation, []).append(ratio)
            rows += _ratio_rows(scope, method, representation, ratio, counts)
        for representation, ratios in parts.items():
            rows += _ratio_rows(scope, "all", representation, np.mean(ratios, axis=0), counts)
    return rows


def _scopes(groups: Sequence[Group]) -> list[tuple[str, list[Group]]]:
    scopes = [("all", list(groups))]
    for field in ("motion", "degradation"):
        values = dict.fromkeys(getattr(group, field) for group in groups)
        scopes += [
            (f"{field}:{value}", [g for g in groups if getattr(g, field) == value])
            for value in values
        ]
    return scopes


def _ranked_scopes(
    groups: Sequence[Group],
) -> Iterator[tuple[str, list[Name], FloatArray, list[Name], FloatArray]]:
    """Scopes in which something is complete, with `_scores` and how often rows are drawn."""
    for scope, chosen in _scopes(groups):
        names, scores, unranked = _scores(chosen)
        if names:
            counts = resampling(len(chosen[0].seeds), len(_motions(chosen)))
            yield scope, names, scores, unranked, counts


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


def _motions(groups: Sequence[Group]) -> list[str]:
    return list(dict.fromkeys(group.motion for group in groups))


def _ranked(names: list[Name], scores: FloatArray, counts: FloatArray) -> list[dict[str, Any]]:
    interval = bootstrap(scores, counts)
    drawn = counts @ scores / scores.shape[0]
    ranks = 1 + np.argsort(np.argsort(drawn, axis=1, kind="stable"), axis=1, kind="stable")
    low, high = np.percentile(ranks, (2.5, 97.5), axis=0, method="nearest")
    order = np.argsort(interval.mean, kind="stable")
    behind = bootstrap(scores - scores[:, order[:1]], counts)
    return [
        {
            "rank": place + 1,
            "method": names[i][0],
            "representation": names[i][1],
            "ratio_to_raw": _rounded(np.exp(interval.mean[i])),
            "ratio_low": _rounded(np.exp(interval.low[i])),
            "ratio_high": _rounded(np.exp(interval.high[i])),
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
    interval = bootstrap(ratio, counts)
    return [
        {
            "scope": scope,
            "method": method,
            "representation": representation,
            "metric": metric,
            "ratio_to_motor": _rounded(np.exp(interval.mean[k])),
            "ratio_low": _rounded(np.exp(interval.low[k])),
            "ratio_high": _rounded(np.exp(interval.high[k])),
        }
        for k, metric in enumerate(RANKED)
    ]


def _rounded(value: float) -> float | None:
    return float(f"{value:.6g}") if np.isfinite(value) else None
