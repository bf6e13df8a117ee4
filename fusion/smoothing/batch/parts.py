"""Long paths in overlapping parts: memory and time stay those of a part.

What a pose tells fades away along the path. Under white acceleration of density q and noise σ at
intervals dt it does so by ``exp(-t / √2 τ)`` with ``τ = (σ √dt / q)^(1/2)``, the steady state of
the smoother of a constant velocity. A part reaches beyond what is kept of it by as many poses as
leave 1e-9 of that, and by some more for poses that are rejected; so the parts give what the whole
gives but for the tolerance at which it ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from motorcade.fusion.smoothing.batch.inliers import Sizes
from motorcade.ga.arrays import FloatArray

__all__ = ["PathPart", "parts"]

# Times √2 τ after which 1e-9 is left.
_FADED = 21.0
_REJECTED_POSES = 200
_FEWEST_KEPT = 1500


class PathPart(NamedTuple):
    """Rows of the path that are estimated together, and those of them that are kept."""

    rows: slice
    kept: slice


def parts(time_s: FloatArray, sizes: Sequence[Sizes]) -> Iterator[PathPart]:
    """Cut a path at stamps ``(N,)`` for the sizes of its noise and motion; `kept` joins up."""
    overlap = _overlap(time_s, sizes)
    size = max(_FEWEST_KEPT, 2 * overlap)
    count = max(1, len(time_s) // size)
    edges = np.linspace(0, len(time_s), count + 1).astype(np.int64).tolist()
    for first, last in pairwise(edges):
        start = max(0, first - overlap)
        yield PathPart(
            slice(start, min(len(time_s), last + overlap)), slice(first - start, last - start)
        )


def _overlap(time_s: FloatArray, sizes: Sequence[Sizes]) -> int:
    if len(time_s) <= _FEWEST_KEPT:
        return 0
    interval_s = float(np.quantile(np.diff(time_s), 0.05))
    longest = max(one.noise * sqrt(interval_s) / one.acceleration for one in sizes)
    reach = _FADED * sqrt(2.0 * longest) / interval_s
    return min(len(time_s), ceil(reach) + _REJECTED_POSES)
