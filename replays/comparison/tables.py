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
- ``rankings`` and ``ratios_to_motor``: see `motorcade.replays.comparison.statistics`;
- ``exact_ties``: see `motorcade.replays.comparison.run`.

``groups.csv`` has a row a motion, degradation, method, representation and metric: ``seeds`` that
told it, ``mean``, ``low``, ``high``; ``ratio_to_raw``; ``versus_motor`` with its interval (of
costs, less is better) and ``verdict``; ``versus_best`` with its interval, the best being the lowest
mean cost of all methods and representations of that motion and degradation.

The findings in a screenful of text.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from motorcade import __version__
from motorcade.ga.arrays import FloatArray
from motorcade.replays.comparison.evaluator import METRICS
from motorcade.replays.comparison.plan import RAW
from motorcade.replays.comparison.statistics import (
    FLOORS,
    Group,
    Intervals,
    Sample,
    bootstrap,
    cost,
    grouped,
    rankings,
    ratios_to_motor,
    resampling,
    verdicts,
)
from motorcade.replays.comparison.tuning import RANGES, Tuned
from motorcade.replays.io.files import write_bytes, write_csv

FORMAT = "motorcade comparison 2"
PLACE = ("motion", "degradation", "method", "representation")
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
    *PLACE,
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


def write_tables(
    out: Path,
    plan: Mapping[str, Any],
    samples: Sequence[Sample],
    tuned: Mapping[tuple[str, str, str, str], Tuned],
    traits: Sequence[Mapping[str, Any]],
    exact_ties: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """Write the three files, each whole or not at all; returns what ``results.json`` holds.

    Arguments are its fields, `tuned` by its place. Raises OSError: a folder that cannot be written.
    """
    groups = grouped(samples)
    rows = [row for group in groups for row in _group_rows(group)]
    write_csv(out / "cells.csv", _CELLS, _cell_rows(samples))
    write_csv(out / "groups.csv", _GROUPS, rows)
    document = {
        "format": FORMAT,
        "motorcade": __version__,
        "python": platform.python_version(),
        "plan": plan,
        "metrics": FLOORS,
        "ranges": {method: [asdict(one) for one in ranges] for method, ranges in RANGES.items()},
        "parameters": [_parameters(place, one) for place, one in tuned.items()],
        "traits": list(traits),
        "failures": [row for group in groups for row in _failures(group)],
        "verdicts": _counted(rows),
        "rankings": rankings(groups),
        "ratios_to_motor": ratios_to_motor(groups),
        "exact_ties": list(exact_ties),
    }
    write_bytes(out / "results.json", (json.dumps(document, indent=1) + "\n").encode())
    return document


def _cell_rows(samples: Iterable[Sample]) -> Iterable[list[Any]]:
    jitters = [METRICS.index(name) for name in ("linear_jitter_m_s2", "angular_jitter_rad_s2")]
    for sample in samples:
        raw = sample.values[sample.names.index(RAW)][jitters]
        for name, values, failure in zip(sample.names, sample.values, sample.failures, strict=True):
            rounded = [_number(value, 9) for value in (*values, *(values[jitters] / raw))]
            yield [sample.motion, sample.degradation, sample.seed, *name, *rounded, failure]


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
            yield [
                group.motion,
                group.degradation,
                *name,
                metric,
                known,
                *_interval_numbers(means, i, k),
                _number(means.mean[i, k] / raw if raw else np.nan, 6),
                *_interval_numbers(from_motor, i, k),
                said[k] if name[1] not in ("motor", "none") else "",
                *_interval_numbers(from_best, i, k),
            ]


def _interval_numbers(intervals: Intervals, i: int, k: int) -> list[str]:
    return [_number(part[i, k], 6) for part in (intervals.mean, intervals.low, intervals.high)]


def _at(intervals: Intervals, i: int) -> Intervals:
    return Intervals(intervals.mean[i], intervals.low[i], intervals.high[i])


def _argmin(column: FloatArray) -> int:
    return int(np.argmin(np.where(np.isfinite(column), column, np.inf)))


def _failures(group: Group) -> list[dict[str, Any]]:
    return [
        dict(zip(PLACE, (group.motion, group.degradation, *name), strict=True))
        | {"seeds": count, "failure": first}
        for name, (count, first) in zip(group.names, group.failures, strict=True)
        if count
    ]


def _parameters(place: tuple[str, str, str, str], tuned: Tuned) -> dict[str, Any]:
    return dict(zip(PLACE, place, strict=True)) | {
        "parameters": dict(tuned.setting.parameters),
        "how": tuned.how,
        "objective": tuned.objective,
        "trials": tuned.trials,
    }


def _counted(rows: Iterable[Sequence[Any]]) -> list[dict[str, Any]]:
    verdict_at = _GROUPS.index("verdict")
    places: dict[tuple[str, str, str], dict[str, Any]] = {}
    for row in rows:
        if row[verdict_at]:
            key = (row[2], row[3], row[4])
            none = {"better": 0, "tie": 0, "equal": 0, "worse": 0, "better_at": []}
            counts = places.setdefault(key, none)
            counts[row[verdict_at]] += 1
            if row[verdict_at] == "better":
                counts["better_at"].append(list(row[:2]))
    names = ("method", "representation", "metric")
    return [dict(zip(names, key, strict=True)) | counts for key, counts in places.items()]


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}g}" if np.isfinite(value) else ""


_SHOWN = 12


def as_text(results: Mapping[str, Any]) -> str:
    """The best of all by score, what each representation costs beside motors, and the ties."""
    return "\n".join([*_ranking(results), "", *_representations(results), "", *_ties(results)])


def _ranking(results: Mapping[str, Any]) -> list[str]:
    ranked = next((one for one in results["rankings"] if one["metric"] == "score"), None)
    if ranked is None:
        return ["nothing has a result in every cell, so nothing is ranked"]
    lines = [f"{'rank':<10}{'method':<28}{'representation':<18}residual error and jitter, of raw"]
    for row in ranked["rows"][:_SHOWN]:
        bounds = f"{row['rank_low']}-{row['rank_high']}"
        tie = "  ties with the first" if row["ties_with_best"] and row["rank"] > 1 else ""
        lines.append(
            f"{row['rank']:<3}{bounds:<7}{row['method']:<28}{row['representation']:<18}"
            f"{_interval(row, 'ratio_to_raw')}{tie}"
        )
    if ranked["unranked"]:
        lines.append(f"not ranked, as not run or failed in some cell: {len(ranked['unranked'])}")
    return lines


def _representations(results: Mapping[str, Any]) -> list[str]:
    metrics = ("ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2", "angular_jitter_rad_s2")
    rows = [
        ratio
        for ratio in results["ratios_to_motor"]
        if ratio["method"] == ratio["scope"] == "all" and ratio["representation"] != "motor"
    ]
    lines = [f"{'times what motors leave, all methods':<38}" + "".join(f"{m:<24}" for m in metrics)]
    for name in dict.fromkeys(row["representation"] for row in rows):
        of = {row["metric"]: row for row in rows if row["representation"] == name}
        lines.append(
            f"{name:<38}" + "".join(f"{_interval(of[m], 'ratio_to_motor'):<24}" for m in metrics)
        )
    return lines


def _ties(results: Mapping[str, Any]) -> list[str]:
    ties = results["exact_ties"]
    lines = []
    for theory in dict.fromkeys(one["theory"] for one in ties):
        of = [one for one in ties if one["theory"] == theory]
        largest = max(
            row[key] or 0.0
            for row in of
            for key in ("largest_difference_m", "largest_difference_rad")
        )
        holds = "holds" if all(one["holds"] for one in of) else "DOES NOT HOLD"
        lines.append(f"{theory}: {holds}, to {largest:.1g}")
    return lines


def _interval(row: Mapping[str, Any], key: str) -> str:
    if row["ratio_low"] is None:
        return _ratio(row[key])
    return f"{_ratio(row[key])} ({_ratio(row['ratio_low'])}-{_ratio(row['ratio_high'])})"


def _ratio(value: float) -> str:
    """Narrow enough for its column."""
    return f"{value:.3f}" if value < 100.0 else f"{value:.1f}" if value < 1e4 else f"{value:.2g}"
