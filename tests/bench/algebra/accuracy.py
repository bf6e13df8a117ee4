"""`make bench SUITE=accuracy`: how far kernels are from fifty digits, and from 80 bits anywhere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tests.ga.kernels.accuracy_conversions import conversion_errors
from tests.ga.kernels.accuracy_fresh import LIMITS, fresh_errors
from tests.ga.kernels.accuracy_motors import largest_errors
from tests.ga.kernels.accuracy_similarities import similarity_errors

__all__ = ["FRESH", "accuracy_table", "bench_accuracy"]

FRESH = 1_000_000
"""Inputs of each kernel."""


def bench_accuracy() -> dict[str, Any]:
    """Largest errors of kernels, by precision: over hard samples, and over fresh ones beside their
    condition.
    """
    precisions = ("float32", "float64")
    return {
        "hard": {
            dtype: largest_errors(dtype) | similarity_errors(dtype) | conversion_errors(dtype)
            for dtype in precisions
        },
        "fresh": {dtype: fresh_errors(dtype, FRESH) for dtype in precisions},
    }


def accuracy_table(found: Mapping[str, Any]) -> str:
    """The largest errors, a row a kernel."""
    hard, fresh = found["hard"], found["fresh"]
    precisions = list(hard)
    names = "".join(f"{precision:>12}" for precision in precisions)
    lines = [f"{'largest normwise error to 50 digits':<38}{names}"]
    for kernel in hard[precisions[0]]:
        errors = "".join(f"{hard[precision][kernel]:>12.2g}" for precision in precisions)
        lines.append(f"{kernel:<38}{errors}")
    lines += ["", f"{FRESH:,} fresh inputs of motors, translations of 1e-3 to 1e3:"]
    lines += [f"{'roundings times the condition':<38}{names}{'limit':>12}"]
    for kernel, limit in LIMITS.items():
        worst = "".join(f"{fresh[precision][kernel][1]:>12.2g}" for precision in precisions)
        lines.append(f"{kernel:<38}{worst}{limit:>12g}")
    lines += [f"{'largest normwise error':<38}{names}"]
    for kernel in LIMITS:
        errors = "".join(f"{fresh[precision][kernel][0]:>12.2g}" for precision in precisions)
        lines.append(f"{kernel:<38}{errors}")
    return "\n".join(lines)
