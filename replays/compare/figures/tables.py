"""The results as files: ``cells.csv``, ``groups.csv`` and ``results.json``.

Keys of ``results.json``:

- ``format``, ``motorcade``, ``python``;
- ``plan``: the fields of `ComparisonPlan`;
- ``metrics``: name to practical floor, in the unit that the name ends with;
- ``parameters``: a row a motion, degradation, method and representation: ``parameters``, ``how``
  ("search", "defaults", "borrowed"), ``objective``, ``trials``;
- ``ranges``: what was searched;
- ``traits``: a row a method and representation: ``left_defect_m``, ``left_defect_rad`` (world's
  frame), ``right_defect_m``, ``right_defect_rad`` (sensor's frame), ``time_us_per_pose``;
- ``failures``: a row a motion, degradation, method and representation that failed: on how many
  seeds, and why at first;
- ``verdicts``: a row a method, representation and metric: over how many motions and degradations
  it is ``better``, ``tie``, ``equal`` or ``worse`` than the same method on motors, and where it is
  better;
- ``rankings`` and ``ratios_to_motor``: see `motorcade.replays.compare.figures.ranking`;
- ``exact_ties``: see `motorcade.replays.compare.measure.ties`.

``groups.csv`` has a row a motion, degradation, method, representation and metric: ``seeds`` that
told it, ``mean``, ``low``, ``high``; ``ratio_to_raw``; ``versus_motor`` with its interval (of
costs, less is better) and ``verdict``; ``versus_best`` with its interval, the best being the lowest
mean cost of all methods and representations of that motion and degradation.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade import __version__
from motorcade.ga.arrays import FloatArray
from motorcade.replays.compare.cells import RAW
from motorcade.replays.compare.figures.ranking import rankings, ratios_to_motor
from motorcade.replays.compare.figures.statistics import (
    FLOORS,
    Group,
    Intervals,
    Sample,
    bootstrap,
    cost,
    grouped,
    resampling,
    verdicts,
)
from motorcade.replays.compare.measure.evaluator import METRICS
from motorcade.replays.compare.tuning import RANGES, Tuned
from motorcade.replays.files.atomic import write_bytes, write_csv

FORMAT = "motorcade comparison 2"
_PLACE = ("motion", "degradation", "method", "representation")
_CELLS = (
    "motion",
    "degradation",
    "seed",
    "method",
    "representation",
    *METRICS,
    "linear_jitter_ratio",
    "angular_jitter_ratio",
    "failure",
)
_GROUPS = (
    *_PLACE,
    "metric",
    "seeds",
    "mean",
    "low",
    "high",
    "ratio_to_raw",
    "versus_motor",
    "versus_motor_low",
    "versus_motor_high",
    "verdict",
    "versus_best",
    "versus_best_low",
    "versus_best_high",
)


@dataclass(frozen=True, eq=False)
class Outcome:
    """All that a comparison found; fields as in ``results.json``, `found` by its place."""

    plan: Mapping[str, Any]
    samples: tuple[Sample, ...]
    found: Mapping[tuple[str, str, str, str], Tuned]
    traits: tuple[Mapping[str, Any], ...]
    exact_ties: Sequence[Mapping[str, Any]]


def write_tables(outcome: Outcome, out: Path) -> dict[str, Any]:
    """Write the three files, each whole or not at all; returns what ``results.json`` holds.

    Raises:
        OSError: a folder that cannot be written.
    """
    groups = grouped(outcome.samples)
    rows = [row for group in groups for row in _group_rows(group)]
    write_csv(out / "cells.csv", _CELLS, _cell_rows(outcome.samples))
    write_csv(out / "groups.csv", _GROUPS, rows)
    told = {
        "format": FORMAT,
        "motorcade": __version__,
        "python": platform.python_version(),
        "plan": outcome.plan,
        "metrics": FLOORS,
        "ranges": {method: [asdict(one) for one in ranges] for method, ranges in RANGES.items()},
        "parameters": [_parameters(place, one) for place, one in outcome.found.items()],
        "traits": list(outcome.traits),
        "failures": [row for group in groups for row in _failures(group)],
        "verdicts": _counted(rows),
        "rankings": rankings(groups),
        "ratios_to_motor": ratios_to_motor(groups),
        "exact_ties": list(outcome.exact_ties),
    }
    write_bytes(out / "results.json", (json.dumps(told, indent=1) + "\n").encode())
    return told


def _cell_rows(samples: Iterable[Sample]) -> Iterable[list[Any]]:
    jitters = [METRICS.index(name) for name in ("linear_jitter_m_s2", "angular_jitter_rad_s2")]
    for sample in samples:
        raw = sample.values[sample.names.index(RAW)][jitters]
        for name, values, failure in zip(sample.names, sample.values, sample.failures, strict=True):
            told = [_number(value, 9) for value in (*values, *(values[jitters] / raw))]
            yield [sample.motion, sample.degradation, sample.seed, *name, *told, failure]


def _group_rows(group: Group) -> Iterable[list[Any]]:
    counts = resampling(len(group.seeds))
    costs = cost(group.values)
    means = bootstrap(group.values, counts)
    best = np.array([_argmin(column) for column in bootstrap(costs, counts).mean.T])
    behind = costs - costs[:, best, np.arange(len(METRICS))][:, None]
    from_best = bootstrap(behind, counts)
    at = {name: i for i, name in enumerate(group.names)}
    motors = [at.get((name[0], "motor"), -1) for name in group.names]
    base = np.where(np.array(motors)[:, None] >= 0, costs[:, motors], np.nan)
    from_motor = bootstrap(costs - base, counts)
    for i, name in enumerate(group.names):
        if not np.any(np.isfinite(group.values[:, i])):
            continue
        said = verdicts((costs - base)[:, i], _at(from_motor, i), base[:, i])
        for k, metric in enumerate(METRICS):
            known = int(np.count_nonzero(np.isfinite(group.values[:, i, k])))
            raw = means.mean[at[RAW], k]
            figures = [
                means.mean[i, k],
                means.low[i, k],
                means.high[i, k],
                means.mean[i, k] / raw if raw else np.nan,
            ]
            versus = [part[i, k] for part in (from_motor.mean, from_motor.low, from_motor.high)]
            against = [part[i, k] for part in (from_best.mean, from_best.low, from_best.high)]
            yield [
                group.motion,
                group.degradation,
                *name,
                metric,
                known,
                *(_number(v, 6) for v in figures),
                *(_number(v, 6) for v in versus),
                said[k] if name[1] not in ("motor", "none") else "",
                *(_number(v, 6) for v in against),
            ]


def _at(found: Intervals, i: int) -> Intervals:
    return Intervals(found.mean[i], found.low[i], found.high[i])


def _argmin(column: FloatArray) -> int:
    return int(np.argmin(np.where(np.isfinite(column), column, np.inf)))


def _failures(group: Group) -> list[dict[str, Any]]:
    return [
        dict(zip(_PLACE, (group.motion, group.degradation, *name), strict=True))
        | {"seeds": count, "failure": first}
        for name, (count, first) in zip(group.names, group.failures, strict=True)
        if count
    ]


def _parameters(place: tuple[str, str, str, str], one: Tuned) -> dict[str, Any]:
    return dict(zip(_PLACE, place, strict=True)) | {
        "parameters": dict(one.setting.parameters),
        "how": one.how,
        "objective": one.objective,
        "trials": one.trials,
    }


def _counted(rows: Iterable[Sequence[Any]]) -> list[dict[str, Any]]:
    verdict_at = _GROUPS.index("verdict")
    places: dict[tuple[str, str, str], dict[str, Any]] = {}
    for row in rows:
        if row[verdict_at]:
            key = (row[2], row[3], row[4])
            counts = places.setdefault(
                key, {"better": 0, "tie": 0, "equal": 0, "worse": 0, "better_at": []}
            )
            counts[row[verdict_at]] += 1
            if row[verdict_at] == "better":
                counts["better_at"].append(list(row[:2]))
    names = ("method", "representation", "metric")
    return [dict(zip(names, key, strict=True)) | counts for key, counts in places.items()]


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}g}" if np.isfinite(value) else ""
