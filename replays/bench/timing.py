"""Time of one kernel call, without Python's share where the compiled kernels are present."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import Any

from motorcade.ga import kernels

__all__ = ["median_seconds", "seconds_a_call"]

ROUNDS = 25


def seconds_a_call(name: str, seconds: float, *operands: Any) -> float:
    """Median seconds of one call of a kernel, over rounds that fill about `seconds`."""
    kernel = kernels.function(name)
    kernel(*operands)
    if kernels.backend == "numpy":
        return median_seconds(lambda: kernel(*operands), seconds)
    from motorcade.ga.kernels._compiled import repeat

    once = repeat(name, 1, *operands)
    times = max(1, int(seconds / ROUNDS / max(once, 1e-8)))
    return median(repeat(name, times, *operands) / times for _ in range(ROUNDS))


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
