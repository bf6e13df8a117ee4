"""Many jobs by one executor, this machine's processes or a Dask cluster: what is done is kept.

A job's result lies in a folder of its own, as an artifact. A command that was stopped, by Ctrl-C or
by a crash, goes on where it was; jobs that failed are tried again, and so are those that opened a
file which has changed since. One job's failure never ends the others, not even where its process
dies.
"""

from __future__ import annotations

import functools
import hashlib
import json
import logging
import os
import re
import signal
import threading
import time
import typing
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import (
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    as_completed,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import active_children, get_context
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Generic, TypeVar

from motorcade.ga.files import files_read
from motorcade.ga.names import nearest_name, one_line
from motorcade.ga.progress import track
from motorcade.replays.engine.artifacts import (
    Stored,
    discard_artifact,
    find_artifact,
    read_artifact,
    write_artifact,
)
from motorcade.replays.engine.store import code_digest, holds

JobType = TypeVar("JobType")
Result = TypeVar("Result")

CLUSTER = ("tcp://", "tls://")
"""How the address of a Dask scheduler begins."""
_PROCESSES = re.compile(r"processes(?::(?P<count>[1-9][0-9]{0,3}))?")
_KINDS = "local, processes, processes:4, or the address of a Dask scheduler such as tcp://host:8786"
_ANSWERS_WITHIN_S = 10
_WORKERS_WITHIN_S = 60
_one_at_a_time = threading.Lock()


def check_executor(name: str) -> str:
    """`name` as given; ValueError where it is none of those known."""
    if name == "local" or _PROCESSES.fullmatch(name) or name.startswith(CLUSTER):
        return name
    meant = nearest_name(name, ("local", "processes"))
    raise ValueError(f"--executor: expected {_KINDS}; got {one_line(name)}{meant}")


def outcomes(
    function: Callable[[JobType], Result], jobs: Sequence[JobType], executor: str
) -> Generator[tuple[JobType, Result | BaseException], None, None]:
    """Call `function` on every job; yields each with its result or the error that ended it.

    Closing the generator, or an interrupt, ends the processes where they stand.

    Args:
        function: a function of a module, which other processes can import.
        jobs: what it is called with; must be picklable unless `executor` is "local".
        executor: "local" (here, in order), "processes" (a process a core), "processes:4" (so
            many), or the address of a Dask scheduler, whose workers need this package and the same
            paths.

    Raises:
        ValueError: an unknown executor.
        RuntimeError: no cluster at the address, or one without workers.
    """
    check_executor(executor)
    if executor == "local":
        for job in jobs:
            try:
                yield job, function(job)
            except Exception as error:  # one job's failure never ends the others
                yield job, error
        return
    opened = _cluster(executor) if executor.startswith(CLUSTER) else _processes(executor)
    with opened as pool:
        running: dict[Future[Result], JobType] = {
            pool.submit(_alone, function, job): job for job in jobs
        }
        for future in as_completed(running):
            fault = future.exception()
            yield running.pop(future), future.result() if fault is None else fault


def _alone(function: Callable[[JobType], Result], job: JobType) -> Result:
    """One job a process at a time, whatever threads a worker has: it may take that with it."""
    with _one_at_a_time:
        return function(job)


@contextmanager
def _processes(executor: str) -> Iterator[Executor]:
    named = _PROCESSES.fullmatch(executor)
    count = named and named["count"]
    pool = _SeparateProcesses(int(count) if count else os.cpu_count() or 1)
    try:
        yield pool
    except BaseException:  # stopped: nobody waits for what is still running
        pool.kill()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


class _SeparateProcesses(Executor):
    """A pool in which a process that dies takes only its own job with it."""

    def __init__(self, count: int) -> None:
        self._others = set(active_children())
        self._threads = ThreadPoolExecutor(count)
        self._pools: SimpleQueue[ProcessPoolExecutor] = SimpleQueue()
        for _ in range(count):
            self._pools.put(_one_process())

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Call in the next process that is free."""
        return self._threads.submit(self._call, partial(fn, *args, **kwargs))

    def _call(self, call: Callable[[], Any]) -> Any:
        pool = self._pools.get()
        try:
            return pool.submit(call).result()
        except BrokenProcessPool as fault:
            pool.shutdown()
            pool = _one_process()
            raise RuntimeError("the process died: killed, out of memory, or a crash") from fault
        finally:
            self._pools.put(pool)

    def kill(self) -> None:
        """End the processes where they stand, and forget the jobs that wait."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for process in set(active_children()) - self._others:
            process.kill()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let running jobs finish, then end the processes."""
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        while not self._pools.empty():
            self._pools.get().shutdown(wait)


def _one_process() -> ProcessPoolExecutor:
    # A fresh interpreter: OpenGL contexts and threads do not survive a fork.
    return ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_leave_quietly)


def _leave_quietly() -> None:
    """Ctrl-C reaches every process of a terminal; that of the command answers for all of them."""
    signal.signal(signal.SIGINT, lambda number, frame: os._exit(130))


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    """The workers of a Dask cluster; a job whose worker dies is given to another, three times."""
    from distributed import Client

    try:
        client = Client(address, timeout=_ANSWERS_WITHIN_S)
    except (OSError, TimeoutError, ValueError) as fault:
        problem = f"no Dask scheduler answers at {address}: {one_line(fault, 120)}"
        raise RuntimeError(f"{problem}; start one with `dask scheduler`") from fault
    with client:
        try:
            client.wait_for_workers(1, timeout=_WORKERS_WITHIN_S)
        except TimeoutError as fault:
            problem = f"the Dask cluster at {address} has no workers"
            raise RuntimeError(f"{problem}; start some with `dask worker {address}`") from fault
        with client.get_executor(pure=False) as pool:
            yield pool


log = logging.getLogger("motorcade.jobs")


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
        executor: see `outcomes`.
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
