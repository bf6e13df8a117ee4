"""Many jobs by one executor: what is done is kept, and never done again.

A job's result lies in a folder of its own, as an artifact. A command that was stopped, by Ctrl-C or
by a crash, goes on where it was; jobs that failed are tried again, and so are those that opened a
file which has changed since.
"""

from __future__ import annotations

import functools
import hashlib
import json
import logging
import time
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from motorcade.ga.files import files_read
from motorcade.ga.progress import track
from motorcade.replays.engine.artifacts import (
    Stored,
    discard_artifact,
    find_artifact,
    read_artifact,
    write_artifact,
)
from motorcade.replays.engine.executors import outcomes
from motorcade.replays.engine.provenance import code_digest
from motorcade.replays.engine.store import holds

log = logging.getLogger("motorcade.jobs")

JobType = TypeVar("JobType")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Batch(Generic[JobType, Result]):
    """How jobs went, in their own order.

    Fields:
        results: of the jobs that are done.
        failures: why others failed, in one line each.
        left: how many were not done when Ctrl-C came.
        done_before: how many an earlier call had done.
    """

    results: Mapping[JobType, Result]
    failures: Mapping[JobType, str]
    left: int
    done_before: int

    def whole(self, what: str) -> Mapping[JobType, Result]:
        """All results, where there are all.

        Raises KeyboardInterrupt: Ctrl-C came before the last job was done; says how many are;
        RuntimeError: a job failed; says why, and how many did.
        """
        count = len(self.results) + len(self.failures) + self.left
        if self.left:
            raise KeyboardInterrupt(
                f"stopped; {len(self.results)} of {count} {what} are done; the same command does "
                "the rest"
            )
        if self.failures:
            first = next(iter(self.failures.values()))
            failed = f"{len(self.failures)} of {count} {what} failed"
            raise RuntimeError(f"{failed}; the others are kept. The first: {first}")
        return self.results


def run_jobs(
    function: Callable[[JobType], Result],
    jobs: Mapping[JobType, Path],
    executor: str,
    what: str,
) -> Batch[JobType, Result]:
    """Call `function` on every job that has no result which holds, and gather the results of all.

    The same jobs give the same results with any executor. Ctrl-C ends what is running, and what is
    done by then is gathered.

    Args:
        function: a function of a module. The type that it says to return must be one that
            `artifacts` can store and read.
        jobs: the folder of each job's result; on a cluster, one that all workers see.
        executor: see `executors.outcomes`.
        what: the jobs' name in the plural, for what is said of progress.

    Raises:
        ValueError, RuntimeError: the executor is unknown or cannot be reached.
        ArtifactError: a result that cannot be read as the type that the function returns.
    """
    waiting = {job: folder for job, folder in jobs.items() if _done(folder) is None}
    failures: dict[JobType, str] = {}
    running = outcomes(functools.partial(_kept, function), list(waiting.items()), executor)
    try:
        for (job, folder), fault in track(running, what, len(waiting)):
            if fault is not None:
                failures[job] = " ".join(str(fault).split()) or type(fault).__name__
                log.warning("%s: %s", folder.name, failures[job])
    except KeyboardInterrupt:
        running.close()
    kind = typing.get_type_hints(function)["return"]
    done = {job: at for job, folder in jobs.items() if (at := _done(folder)) is not None}
    results = {job: read_artifact(at, kind) for job, at in done.items()}
    failures = {job: why for job, why in failures.items() if job not in done}
    left = len(jobs) - len(done) - len(failures)
    return Batch(results, failures, left, len(jobs) - len(waiting))


def finished(
    function: Callable[[JobType], Result],
    about: Mapping[JobType, object],
    out: Path,
    executor: str,
    what: str,
) -> Mapping[JobType, Result]:
    """Every job's result; what is kept in ``OUT/.finished`` is not computed again.

    `about` says what each job is, ready for JSON (see `job_key`); the rest is as for `run_jobs`.

    Raises KeyboardInterrupt, RuntimeError: not all jobs are done; see `Batch.whole`.
    """
    places = {job: out / ".finished" / job_key(function, what_is) for job, what_is in about.items()}
    return run_jobs(function, places, executor, what).whole(what)


def _kept(function: Callable[[JobType], Any], task: tuple[JobType, Path]) -> None:
    """Do a job where this is called, unless a worker that was given up for lost had done it."""
    job, folder = task
    if _done(folder) is None:
        start = time.perf_counter()
        with files_read() as files:
            result = function(job)
        stored = find_artifact(folder)
        if not holds(stored):  # else another run was faster, and may be reading it
            if stored is not None:
                discard_artifact(stored)
            write_artifact(result, folder, time.perf_counter() - start, files)


def _done(folder: Path) -> Stored | None:
    """A job's result; None where there is none, or a file that it was made from has changed."""
    stored = find_artifact(folder)
    return stored if holds(stored) else None


def job_key(function: Callable[..., Any], about: object) -> str:
    """The name of a result: a digest of what a job is, ready for JSON, and of the code it runs."""
    content = json.dumps([function.__name__, _code(function), about], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()[:24]


# The code as it was when this process first asked, whatever is edited meanwhile.
_code = functools.cache(code_digest)
