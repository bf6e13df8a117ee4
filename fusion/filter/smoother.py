"""The backward pass: over the stamps again, so that every estimate knows all the data.

H. E. Rauch, F. Tung and C. T. Striebel, Maximum likelihood estimates of linear dynamic systems,
AIAA Journal 3(8), 1965. Errors stand on the right of the filter's estimates; between measurements
they are carried back linearly, which is exact for this error but for the biases.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorcade.fusion.filter.error_state import Forward
from motorcade.fusion.filter.extended_pose import joined
from motorcade.ga import FloatArray

__all__ = ["smooth_backwards"]

_CHUNK = 1024


def smooth_backwards(run: Forward) -> tuple[FloatArray, FloatArray]:
    """Errors ``(N, 15)`` to take off the filter's estimates, and covariances ``(N, 15, 15)``."""
    errors = np.zeros((len(run.time_ns), run.covariance.shape[-1]))
    covariance = run.covariance.copy()
    for k, gain, expected in _gains(run):
        known = run.correction.get(k + 1)
        after = errors[k + 1] if known is None else joined(known, errors[k + 1])
        errors[k] = gain @ after
        spread = covariance[k] + gain @ (covariance[k + 1] - expected) @ gain.T
        covariance[k] = 0.5 * (spread + spread.T)
    return errors, covariance


def _gains(run: Forward) -> Iterator[tuple[int, FloatArray, FloatArray]]:
    """Stamps from the last but one to the first, their gains, and the covariance predicted next."""
    for end in range(len(run.time_ns) - 1, 0, -_CHUNK):
        start = max(0, end - _CHUNK)
        known, matrix = run.covariance[start:end], run.transition[start + 1 : end + 1]
        carried = matrix @ known
        expected = carried @ matrix.swapaxes(-1, -2) + run.added(start, end)
        for k in range(start, end):
            if k + 1 in run.doubt:
                expected[k - start] += run.doubt[k + 1]
        gains = np.linalg.solve(expected, carried).swapaxes(-1, -2)
        for k in reversed(range(start, end)):
            yield k, gains[k - start], expected[k - start]
