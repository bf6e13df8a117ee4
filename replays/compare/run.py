"""A plan from beginning to end: parameters, cells, figures; over processes, and taken up again.

What is finished is kept in ``OUT/.finished``, a file for each search and cell, named after all
that it depends on: its fields and the code (`replays.engine.provenance`). A run that was stopped
goes on where it was, one with more seeds or methods computes those, and one after a change of the
code begins anew.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor
from motorcade.replays.compare.cells import Cell, Row, run_cell
from motorcade.replays.compare.figures.statistics import Sample
from motorcade.replays.compare.figures.tables import Outcome, write_tables
from motorcade.replays.compare.measure.ties import exact_ties
from motorcade.replays.compare.measure.traits import Trait, run_trait
from motorcade.replays.compare.plan import SLOW, Plan
from motorcade.replays.compare.tuning import BORROWS, Tuned, Tuning, borrowed, run_tuning
from motorcade.replays.engine.progress import track
from motorcade.replays.engine.provenance import code_digest
from motorcade.replays.files.atomic import write_bytes

__all__ = ["compare", "finished"]

Job = TypeVar("Job", Tuning, Cell, Trait)


def compare(plan: Plan, out: Path, workers: int = 1) -> dict[str, Any]:
    """Run a plan, write its tables into `out`, and return what ``results.json`` holds.

    Args:
        plan: what to run.
        out: folder for the results; what earlier runs finished there is used.
        workers: processes; the results do not depend on their number, but for times.

    Raises:
        ValueError: fewer than one worker.
        OSError: a folder that cannot be written.
    """
    if workers < 1:
        raise ValueError(f"workers: expected 1 or more, got {workers}")
    if workers == 1:
        return _compared(plan, out, None)
    # A fresh interpreter each, as the pipeline's.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        return _compared(plan, out, pool)


def _compared(plan: Plan, out: Path, pool: Executor | None) -> dict[str, Any]:
    for function in (run_tuning, run_cell, run_trait):
        _digest(function)
    found = _tuned(plan, out, pool)
    samples = []
    cells = [cell for batch in _batches(plan) for cell in _cells(plan, batch, found)]
    for cell, rows in finished(run_cell, cells, out, pool, "cells"):
        samples.append(Sample.of(cell, [Row.of(row) for row in rows]))
    traits = [
        Trait(plan.motions[0], plan.degradations[0], plan.tuning_seeds[0], plan.rate_hz,
              plan.duration_s, found[plan.motions[0], plan.degradations[0], *pair].setting)
        for pair in plan.pairs(plan.motions[0], plan.degradations[0])
    ]  # fmt: skip
    # Alone, one after another: they are timed.
    told = [result for _, result in finished(run_trait, traits, out, None, "times")]
    outcome = Outcome(plan.as_dict(), tuple(samples), found, tuple(told), exact_ties())
    return write_tables(outcome, out)


def finished(
    function: Callable[[Job], Any],
    jobs: Sequence[Job],
    out: Path,
    pool: Executor | None,
    what: str,
) -> Iterator[tuple[Job, Any]]:
    """Every job with its result, in the order given; what was kept in `out` is not computed again.

    Results must be what JSON can hold. Each is kept as soon as it is there.
    """
    digest = _digest(function)
    paths = [out / ".finished" / f"{_key(function, job, digest)}.json" for job in jobs]
    missing = [i for i, path in enumerate(paths) if not path.exists()]
    for i, result in track(_computed(function, jobs, missing, pool), what, len(missing)):
        write_bytes(paths[i], json.dumps(result, separators=(",", ":")).encode())
    for job, path in zip(jobs, paths, strict=True):
        yield job, json.loads(path.read_bytes())


def _computed(
    function: Callable[[Job], Any], jobs: Sequence[Job], missing: Sequence[int],
    pool: Executor | None,
) -> Iterator[tuple[int, Any]]:  # fmt: skip
    if pool is None:
        for i in missing:
            yield i, function(jobs[i])
        return
    running = {pool.submit(function, jobs[i]): i for i in missing}
    try:
        for future in as_completed(running):
            yield running[future], future.result()
    finally:
        for future in running:
            future.cancel()


# The code as it was when this process first asked, whatever is edited meanwhile.
_digest = functools.cache(code_digest)


def _key(function: Callable[..., Any], job: Any, digest: str) -> str:
    fields = json.dumps(asdict(job), sort_keys=True)
    told = f"{function.__name__}\n{digest}\n{fields}"
    return hashlib.sha256(told.encode()).hexdigest()[:40]


def _batches(plan: Plan) -> list[tuple[str, ...]]:
    """Methods whose cells are computed together: slow ones alone, at the end."""
    fast = tuple(method for method in plan.methods if method not in SLOW)
    slow = [(method,) for method in plan.methods if method in SLOW]
    return [batch for batch in (fast, *slow) if batch]


def _cells(
    plan: Plan, methods: tuple[str, ...], found: dict[tuple[str, str, str, str], Tuned]
) -> Iterator[Cell]:
    for motion in plan.motions:
        for degradation in plan.degradations:
            pairs = plan.pairs(motion, degradation, methods)
            settings = tuple(found[motion, degradation, *pair].setting for pair in pairs)
            for seed in plan.test_seeds if settings else ():
                yield Cell(motion, degradation, seed, plan.rate_hz, plan.duration_s, settings)


def _tuned(plan: Plan, out: Path, pool: Executor | None) -> dict[tuple[str, str, str, str], Tuned]:
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
    for search, results in finished(run_tuning, searches, out, pool, "parameters"):
        for one in map(Tuned.of, results):
            place = (search.motion, search.degradation)
            found[*place, one.setting.method, one.setting.representation] = one
    for motion in plan.motions:
        for degradation in plan.degradations:
            for method, representation in plan.pairs(motion, degradation):
                lender, lent_on = BORROWS.get(method, (method, degradation))
                own = representation in _sought(plan, motion)
                lent = found[motion, lent_on, lender, representation if own else "motor"]
                if not own or lender != method:
                    lent = borrowed(method, representation, lent)
                found[motion, degradation, method, representation] = lent
    return found


def _searched(plan: Plan) -> dict[str, tuple[str, ...]]:
    """Methods to search parameters for, by degradation; also what others borrow from."""
    own = tuple(method for method in plan.methods if method not in BORROWS)
    wanted = dict.fromkeys(plan.degradations, own)
    for method in plan.methods:
        lender, lent_on = BORROWS.get(method, ("", ""))
        if lender and lender not in wanted.get(lent_on, ()):
            wanted[lent_on] = (*wanted.get(lent_on, ()), lender)
    return wanted


def _lent(plan: Plan, method: str, degradation: str) -> bool:
    """Whether others borrow what is found for a method there."""
    return any(BORROWS.get(one) == (method, degradation) for one in plan.methods)


def _own(plan: Plan, motion: str, method: str) -> list[tuple[str, str]]:
    return [(method, representation) for representation in _sought(plan, motion)]


def _sought(plan: Plan, motion: str) -> list[str]:
    """Representations with a search of their own: on rigid motions similarities are motors."""
    same = MOTIONS[motion].versor is Motor and "motor" in plan.representations
    return [one for one in plan.representations if not (same and one == "similarity")]
