"""A plan from beginning to end: parameters, cells, figures.

What is finished is kept in ``OUT/.finished``, a folder for each search and cell, named after all
that it depends on: its fields and the code. A run that was stopped goes on where it was, one with
more seeds or methods computes those, and one after a change of the code begins anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor
from motorcade.replays.comparison.cells import ComparisonCell, run_cell
from motorcade.replays.comparison.plan import ComparisonPlan
from motorcade.replays.comparison.statistics import Sample
from motorcade.replays.comparison.tables import Outcome, write_tables
from motorcade.replays.comparison.traits import Trait, exact_ties, run_trait
from motorcade.replays.comparison.tuning import SearchPlace, Tuned, Tuning, run_tuning
from motorcade.replays.engine.jobs import finished


def run_comparison(plan: ComparisonPlan, out: Path, executor: str = "local") -> dict[str, Any]:
    """Run a plan, write its tables into `out`, and return what ``results.json`` holds.

    Args:
        plan: what to run.
        out: folder for the results; what earlier runs finished there is used.
        executor: see `motorcade.replays.engine.executors.outcomes`; the results do not depend on
            it, but for times.

    Raises:
        KeyboardInterrupt: stopped by Ctrl-C; what is finished is kept, and no table is written.
        ValueError, RuntimeError: the executor is unknown or cannot be reached.
        OSError: a folder that cannot be written.
    """
    found = _tuned(plan, out, executor)
    cells = list(_cells(plan, found))
    measured = finished(run_cell, {cell: asdict(cell) for cell in cells}, out, executor, "cells")
    samples = tuple(Sample.of(cell, rows) for cell, rows in measured.items())
    traits = [
        Trait(
            plan.motions[0],
            plan.degradations[0],
            plan.tuning_seeds[0],
            plan.rate_hz,
            plan.duration_s,
            found[plan.motions[0], plan.degradations[0], *pair].setting,
            plan.recording(plan.motions[0]),
        )
        for pair in plan.pairs()
    ]
    # Alone, one after another: they are timed.
    told = finished(run_trait, {trait: asdict(trait) for trait in traits}, out, "local", "times")
    outcome = Outcome(plan.as_dict(), samples, found, tuple(told.values()), exact_ties())
    return write_tables(outcome, out)


def _cells(
    plan: ComparisonPlan, found: dict[tuple[str, str, str, str], Tuned]
) -> Iterator[ComparisonCell]:
    for motion in plan.motions:
        for degradation in plan.degradations:
            settings = tuple(found[motion, degradation, *pair].setting for pair in plan.pairs())
            for seed in plan.test_seeds:
                yield ComparisonCell(
                    motion,
                    degradation,
                    seed,
                    plan.rate_hz,
                    plan.duration_s,
                    settings,
                    plan.recording(motion),
                )


def _tuned(
    plan: ComparisonPlan, out: Path, executor: str
) -> dict[tuple[str, str, str, str], Tuned]:
    """What was found for (motion, degradation, method, representation)."""
    lenders = {
        (motion, place): place.lender(_rigid(plan, motion))
        for motion in plan.motions
        for place in _places(plan)
    }
    wanted: dict[tuple[str, str], dict[tuple[str, str], None]] = {}
    for (motion, _), one in lenders.items():
        pairs = wanted.setdefault((motion, one.degradation), {})
        pairs[one.method, one.representation] = None
    searches = [
        Tuning(
            motion,
            degradation,
            plan.tuning_seeds,
            plan.rate_hz,
            plan.duration_s,
            tuple(pairs),
            plan.recording(motion),
        )
        for (motion, degradation), pairs in wanted.items()
    ]
    about = {search: asdict(search) for search in searches}
    searched = {
        (search.motion, SearchPlace(search.degradation, *pair)): one
        for search, results in finished(run_tuning, about, out, executor, "searches").items()
        for pair, one in zip(search.pairs, results, strict=True)
    }
    found = {}
    for (motion, place), lender in lenders.items():
        result = searched[motion, lender]
        key = (motion, place.degradation, place.method, place.representation)
        found[key] = result if lender == place else place.borrowed(result)
    return found


def _places(plan: ComparisonPlan) -> list[SearchPlace]:
    return [SearchPlace(name, *pair) for name in plan.degradations for pair in plan.pairs()]


def _rigid(plan: ComparisonPlan, motion: str) -> bool:
    return plan.recording(motion) is not None or MOTIONS[motion].versor is Motor
