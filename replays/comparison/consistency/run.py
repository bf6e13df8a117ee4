"""Many runs of every filter on every motion, over the cores, and what they come to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.metrics.consistency import Consistency
from motorcade.ga.arrays import FloatArray
from motorcade.replays.comparison.consistency.experiment import (
    FILTERS,
    PARTS,
    Experiment,
    Judged,
    judge,
    simulate,
)
from motorcade.replays.engine.jobs import job_key, run_jobs
from motorcade.replays.io.atomic import write_csv

_RUNS_A_JOB = 20
_INNOVATION_FREEDOM = 6
# Errors are told of once the wrong start is forgotten.
_SETTLED_S = 5.0


@dataclass(frozen=True)
class ConsistencyPlan:
    """What to compare.

    Fields:
        motions: names of rigid motions.
        filters: names of filters.
        runs: of each motion; every filter sees the same ones.
        seed: of the first run, the next have those that follow.
        duration_s: of a run.

    Raises:
        ValueError: an unknown name, none at all, or a number out of its range.
    """

    motions: tuple[str, ...] = ("gimbal_crossing", "handheld", "walk_and_look")
    filters: tuple[str, ...] = ("motor", "quaternion", "euler")
    runs: int = 100
    seed: int = 0
    duration_s: float = 120.0

    def __post_init__(self) -> None:
        if not self.motions or not self.filters:
            raise ValueError("plan: expected one motion and one filter or more, got none")
        for name in self.filters:
            if name not in FILTERS:
                raise ValueError(
                    f"plan.filters: expected some of {', '.join(FILTERS)}, got {name!r}"
                )
        if self.runs < 1 or self.seed < 0:
            raise ValueError(
                f"plan: expected runs >= 1 and seed >= 0, got {self.runs} and {self.seed}"
            )
        if not 2.0 * _SETTLED_S <= self.duration_s < np.inf:
            raise ValueError(
                f"plan.duration_s: expected {2.0 * _SETTLED_S:g} or more, got {self.duration_s}"
            )
        for experiment in self.experiments():
            experiment.path()

    def experiments(self) -> tuple[Experiment, ...]:
        """One a motion."""
        return tuple(Experiment(name, self.duration_s) for name in self.motions)


@dataclass(frozen=True, eq=False)
class Verdict:
    """What all runs of one filter on one motion come to; arrays are over the measured stamps.

    Fields:
        time_s: from the start.
        nees: by part of the state.
        nis: of the innovations, without the first stamp.
        rotation_rms_deg, position_rms_m: over the runs, stamp by stamp.
        rotation_spread_deg: the 10th, 50th and 90th percentile over the runs, stamp by stamp.
        rotation_worst_deg: of any run at any stamp after five seconds.
        left_out: measurements that the gate refused, of all runs.
    """

    time_s: FloatArray
    nees: Mapping[str, Consistency]
    nis: Consistency
    rotation_rms_deg: FloatArray
    position_rms_m: FloatArray
    rotation_spread_deg: tuple[FloatArray, FloatArray, FloatArray]
    rotation_worst_deg: float
    left_out: int

    @property
    def settled(self) -> slice:
        """Stamps after five seconds."""
        return slice(int(np.searchsorted(self.time_s, _SETTLED_S)), None)


def run_plan(
    plan: ConsistencyPlan, out: Path, executor: str = "local"
) -> dict[str, dict[str, Verdict]]:
    """Verdicts by motion and filter, and the table ``consistency.csv``.

    What is finished is kept in ``OUT/.finished``, a folder for every twenty runs of a motion. A
    call that was stopped goes on where it was, one with more runs or motions computes those.

    Args:
        plan: what to run.
        out: folder for the results; on a cluster, one that all workers see.
        executor: see `motorcade.replays.engine.executors.outcomes`; the verdicts do not depend on
            it.

    Raises:
        KeyboardInterrupt: stopped by Ctrl-C; what is finished is kept, and no table is written.
        ValueError, RuntimeError: the executor is unknown or cannot be reached.
        OSError: a folder that cannot be written.
    """
    jobs = {job: out / ".finished" / job_key(run_seeds, asdict(job)) for job in _jobs(plan)}
    judged = run_jobs(run_seeds, jobs, executor, "parts").whole("parts")
    parts: dict[str, list[dict[str, Judged]]] = {motion: [] for motion in plan.motions}
    for job, of in judged.items():
        parts[job.experiment.motion].append(of)
    verdicts = {motion: _verdicts(plan, of) for motion, of in parts.items()}
    rows = as_json(plan, verdicts)["rows"]
    write_csv(out / "consistency.csv", list(rows[0]), [list(row.values()) for row in rows])
    return verdicts


def _jobs(plan: ConsistencyPlan) -> Iterator[SeedRange]:
    last = plan.seed + plan.runs
    for experiment in plan.experiments():
        for first in range(plan.seed, last, _RUNS_A_JOB):
            count = min(_RUNS_A_JOB, last - first)
            yield SeedRange(experiment, plan.filters, first, count)


def as_json(plan: ConsistencyPlan, verdicts: Mapping[str, Mapping[str, Verdict]]) -> dict[str, Any]:
    """The figures as a JSON-ready tree: a row a motion and filter; keys carry units."""
    return {
        "runs": plan.runs,
        "seed": plan.seed,
        "duration_s": plan.duration_s,
        "probability": 0.95,
        "rows": [
            {"motion": motion, "filter": name, **_row(verdict)}
            for motion, of in verdicts.items()
            for name, verdict in of.items()
        ],
    }


def as_table(figures: Mapping[str, Any]) -> str:
    """The figures of `as_json` as aligned text: shares of steps within the bounds, and errors."""
    judged = [*(f"nees_{part}" for part in PARTS), "nis"]
    heads = (*PARTS, "NIS", "rotation", "worst", "position", "left out")
    lines = [
        f"steps within the 95 % bounds of {figures['runs']} runs of {figures['duration_s']:g} s",
        f"{'':<34}" + "".join(f"{head:>10}" for head in heads),
    ]
    for row in figures["rows"]:
        shares = "".join(f"{100 * row[f'{name}_share_within']:>8.1f} %" for name in judged)
        errors = (
            f"{row['rotation_rmse_deg']:>9.3g}°{row['rotation_worst_deg']:>9.3g}°"
            f"{1e3 * row['position_rmse_m']:>7.3g} mm{row['left_out']:>10}"
        )
        lines.append(f"{row['motion'] + ', ' + row['filter']:<34}{shares}{errors}")
    return "\n".join(lines)


def _row(verdict: Verdict) -> dict[str, Any]:
    judged = {f"nees_{part}": one for part, one in verdict.nees.items()} | {"nis": verdict.nis}
    row: dict[str, Any] = {}
    for name, one in judged.items():
        row[f"{name}_share_within"] = one.share_within
        row[f"{name}_over_expected"] = one.ratio
    rotation, position = (
        float(np.sqrt(np.mean(values[verdict.settled] ** 2)))
        for values in (verdict.rotation_rms_deg, verdict.position_rms_m)
    )
    return row | {
        "rotation_rmse_deg": rotation,
        "rotation_worst_deg": verdict.rotation_worst_deg,
        "position_rmse_m": position,
        "left_out": verdict.left_out,
    }


@dataclass(frozen=True)
class SeedRange:
    """Runs of one motion that are done together: `count` seeds from the first."""

    experiment: Experiment
    filters: tuple[str, ...]
    first_seed: int
    count: int


def run_seeds(job: SeedRange) -> dict[str, Judged]:
    """Simulate the runs and judge every filter on them."""
    simulated = simulate(job.experiment, range(job.first_seed, job.first_seed + job.count))
    return {name: judge(simulated, job.experiment, name) for name in job.filters}


def _verdicts(plan: ConsistencyPlan, judged: Sequence[Mapping[str, Judged]]) -> dict[str, Verdict]:
    return {name: _verdict([one[name] for one in judged]) for name in plan.filters}


def _verdict(parts: Sequence[Judged]) -> Verdict:
    """Of all runs, from those of each job."""

    def joined(values: Sequence[FloatArray]) -> FloatArray:
        return np.concatenate(values)

    time_s = parts[0].time_s
    rotation = np.rad2deg(joined([one.rotation_rad for one in parts]))
    position = joined([one.position_m for one in parts])
    nis = joined([one.nis for one in parts])[:, 1:]
    settled = int(np.searchsorted(time_s, _SETTLED_S))
    low, middle, high = np.percentile(rotation, (10, 50, 90), axis=0)
    return Verdict(
        time_s,
        {
            part: Consistency.of(joined([one.nees[part] for one in parts]), at.stop - at.start)
            for part, at in PARTS.items()
        },
        Consistency.of(nis, _INNOVATION_FREEDOM),
        np.sqrt(np.mean(rotation**2, axis=0)),
        np.sqrt(np.mean(position**2, axis=0)),
        (low, middle, high),
        float(rotation[:, settled:].max()),
        int(sum(np.sum(one.left_out) for one in parts)),
    )
