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
from motorcade.replays.compare.cells import ComparisonCell, run_cell
from motorcade.replays.compare.figures.statistics import Sample
from motorcade.replays.compare.figures.tables import Outcome, write_tables
from motorcade.replays.compare.measure.ties import exact_ties
from motorcade.replays.compare.measure.traits import Trait, run_trait
from motorcade.replays.compare.plan import SLOW, ComparisonPlan
from motorcade.replays.compare.tuning import BORROWS, Tuned, Tuning, borrowed, run_tuning
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
    cells = [cell for batch in _batches(plan) for cell in _cells(plan, batch, found)]
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
        )
        for pair in plan.pairs(plan.motions[0], plan.degradations[0])
    ]
    # Alone, one after another: they are timed.
    told = finished(run_trait, {trait: asdict(trait) for trait in traits}, out, "local", "times")
    outcome = Outcome(plan.as_dict(), samples, found, tuple(told.values()), exact_ties())
    return write_tables(outcome, out)


def _batches(plan: ComparisonPlan) -> list[tuple[str, ...]]:
    """Methods whose cells are computed together: slow ones alone, at the end."""
    fast = tuple(method for method in plan.methods if method not in SLOW)
    slow = [(method,) for method in plan.methods if method in SLOW]
    return [batch for batch in (fast, *slow) if batch]


def _cells(
    plan: ComparisonPlan, methods: tuple[str, ...], found: dict[tuple[str, str, str, str], Tuned]
) -> Iterator[ComparisonCell]:
    for motion in plan.motions:
        for degradation in plan.degradations:
            pairs = plan.pairs(motion, degradation, methods)
            settings = tuple(found[motion, degradation, *pair].setting for pair in pairs)
            for seed in plan.test_seeds if settings else ():
                yield ComparisonCell(
                    motion, degradation, seed, plan.rate_hz, plan.duration_s, settings
                )


def _tuned(
    plan: ComparisonPlan, out: Path, executor: str
) -> dict[tuple[str, str, str, str], Tuned]:
    """What was found for (motion, degradation, method, representation)."""
    searches = []
    for motion in plan.motions:
        for degradation, methods in _searched(plan).items():
            pairs = tuple(
                pair
                for method in methods
                for pair in _own(plan, motion, method)
                if plan.runs(motion, degradation, *pair) or _lent(plan, method, degradation)
            )
            searches.append(
                Tuning(motion, degradation, plan.tuning_seeds, plan.rate_hz, plan.duration_s, pairs)
            )
    found = {}
    about = {search: asdict(search) for search in searches}
    for search, results in finished(run_tuning, about, out, executor, "searches").items():
        for one in results:
            place = (search.motion, search.degradation)
            found[*place, one.setting.method, one.setting.representation] = one
    for motion in plan.motions:
        for degradation in plan.degradations:
            for method, representation in plan.pairs(motion, degradation):
                lender, lent_on = BORROWS.get(method, (method, degradation))
                own = representation in _searched_in(plan, motion)
                lent = found[motion, lent_on, lender, representation if own else "motor"]
                if not own or lender != method:
                    lent = borrowed(method, representation, lent)
                found[motion, degradation, method, representation] = lent
    return found


def _searched(plan: ComparisonPlan) -> dict[str, tuple[str, ...]]:
    """Methods to search parameters for, by degradation; also what others borrow from."""
    own = tuple(method for method in plan.methods if method not in BORROWS)
    wanted = dict.fromkeys(plan.degradations, own)
    for method in plan.methods:
        lender, lent_on = BORROWS.get(method, ("", ""))
        if lender and lender not in wanted.get(lent_on, ()):
            wanted[lent_on] = (*wanted.get(lent_on, ()), lender)
    return wanted


def _lent(plan: ComparisonPlan, method: str, degradation: str) -> bool:
    """Whether others borrow what is found for a method there."""
    return any(BORROWS.get(one) == (method, degradation) for one in plan.methods)


def _own(plan: ComparisonPlan, motion: str, method: str) -> list[tuple[str, str]]:
    return [(method, representation) for representation in _searched_in(plan, motion)]


def _searched_in(plan: ComparisonPlan, motion: str) -> list[str]:
    """Representations with a search of their own: on rigid motions similarities are motors."""
    same = MOTIONS[motion].versor is Motor and "motor" in plan.representations
    return [one for one in plan.representations if not (same and one == "similarity")]
