"""Ways drawn by hand: points so far apart that somebody can walk them."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray

STEP, SHORTEST, BENT = 0.15, 0.5, 0.04
"""In heights of the walker: between points, of the whole way, and how far a point may be from the
line between its neighbours to be left out."""
MOST_POINTS = 100


def thinned(points_m: FloatArray, height_m: float) -> FloatArray:
    """A way ``(P, 2)`` through the points of a drawn line ``(N, 2)`` that matter.

    Raises:
        ValueError: a line that is too short to be walked.

    >>> import numpy as np
    >>> from motorcade.replays.studio.server.ways import thinned
    >>> line = np.column_stack([np.linspace(0.0, 3.0, 200), np.zeros(200)])
    >>> thinned(line, 1.0).round(6).tolist()
    [[0.0, 0.0], [3.0, 0.0]]
    """
    kept = list(points_m[:1])
    for point in points_m[1:]:
        if np.linalg.norm(point - kept[-1]) >= STEP * height_m:
            kept.append(point)
    if len(kept) > 1:
        kept[-1] = points_m[-1]  # where the finger was lifted
    path = np.array(kept).reshape(-1, 2)
    if len(path) < 2 or np.ptp(path, axis=0).max() < SHORTEST * height_m:
        raise ValueError("Draw a longer way on the ground.")
    tolerance = BENT * height_m
    path = path[_needed(path, tolerance)]
    while len(path) > MOST_POINTS:
        tolerance *= 2.0
        path = path[_needed(path, tolerance)]
    made: FloatArray = path
    return made


def _needed(path: FloatArray, tolerance_m: float) -> FloatArray:
    """Which points stay (Douglas and Peucker, 1973)."""
    kept = np.zeros(len(path), dtype=bool)
    kept[[0, -1]] = True
    spans = [(0, len(path) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        along = path[last] - path[first]
        inner = path[first + 1 : last] - path[first]
        length = float(np.hypot(*along))
        off = np.hypot(*inner.T)
        if length > 0.0:
            off = np.abs(inner[:, 0] * along[1] - inner[:, 1] * along[0]) / length
        worst = int(np.argmax(off))
        if off[worst] > tolerance_m:
            kept[first + 1 + worst] = True
            spans += [(first, first + 1 + worst), (first + 1 + worst, last)]
    return kept
