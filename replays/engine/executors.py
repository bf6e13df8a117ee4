"""Many jobs, one after another, on this machine's processes, or on a Dask cluster.

One job's failure never ends the others, not even where its process dies.
"""

from __future__ import annotations

import os
import re
import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    as_completed,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from multiprocessing import active_children, get_context
from queue import SimpleQueue
from typing import Any, TypeVar

from motorcade.ga.names import nearest_name, one_line

Job = TypeVar("Job")
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
    function: Callable[[Job], Result], jobs: Sequence[Job], executor: str
) -> Generator[tuple[Job, Result | BaseException], None, None]:
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
        running: dict[Future[Result], Job] = {
            pool.submit(_alone, function, job): job for job in jobs
        }
        for future in as_completed(running):
            fault = future.exception()
            yield running.pop(future), future.result() if fault is None else fault


def _alone(function: Callable[[Job], Result], job: Job) -> Result:
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
