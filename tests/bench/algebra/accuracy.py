"""`make bench SUITE=accuracy`: how far kernels are from fifty digits."""

from __future__ import annotations

from collections.abc import Mapping

from tests.ga.kernels.accuracy_conversions import conversion_errors
from tests.ga.kernels.accuracy_motors import largest_errors
from tests.ga.kernels.accuracy_similarities import similarity_errors

__all__ = ["accuracy_table", "bench_accuracy"]


def bench_accuracy() -> dict[str, dict[str, float]]:
    """Largest normwise error of every kernel over hard samples, by precision."""
    return {
        dtype: largest_errors(dtype) | similarity_errors(dtype) | conversion_errors(dtype)
        for dtype in ("float32", "float64")
    }


def accuracy_table(found: Mapping[str, Mapping[str, float]]) -> str:
    """The largest errors, a row a kernel."""
    precisions = list(found)
    lines = [
        f"{'largest normwise error to 50 digits':<38}" + "".join(f"{p:>12}" for p in precisions)
    ]
    for name in found[precisions[0]]:
        lines.append(f"{name:<38}" + "".join(f"{found[p][name]:>12.2g}" for p in precisions))
    return "\n".join(lines)
