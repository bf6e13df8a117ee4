"""Times of calls, on one core: without Python's share where the compiled kernels are present."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from statistics import median
from time import perf_counter, process_time
from typing import Any

from motorcade.ga import kernels

__all__ = ["median_seconds", "on_one_core", "seconds_a_call"]

ROUNDS = 25


def seconds_a_call(name: str, seconds: float, *operands: Any) -> float:
    """Median processor seconds of one call of a kernel, over rounds that fill about `seconds`."""
    kernel = kernels.function(name)
    kernel(*operands)
    if kernels.backend == "numpy":
        return median_seconds(lambda: kernel(*operands), seconds)
    from motorcade.ga.kernels._compiled import repeat

    def spent(times: int) -> float:
        start = process_time()
        repeat(name, times, *operands)
        return (process_time() - start) / times

    times = max(1, int(seconds / ROUNDS / max(repeat(name, 1, *operands), 1e-8)))
    return median(spent(times) for _ in range(ROUNDS))


def median_seconds(call: Callable[[], object], seconds: float) -> float:
    """Median seconds of a Python call, over rounds that fill about `seconds`."""
    start = perf_counter()
    call()
    times = max(1, int(seconds / ROUNDS / max(perf_counter() - start, 1e-7)))
    spent = []
    for _ in range(ROUNDS):
        start = perf_counter()
        for _ in range(times):
            call()
        spent.append((perf_counter() - start) / times)
    return median(spent)


@contextmanager
def on_one_core() -> Iterator[None]:
    """Keep this process, and those it starts, on one core with one thread."""
    cores, threads = os.sched_getaffinity(0), kernels.threads()
    os.sched_setaffinity(0, {max(cores)})
    kernels.set_threads(1)
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)
        kernels.set_threads(threads)
