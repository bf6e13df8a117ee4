"""Held-out prediction: the one measure of which of two paths, or models, is the better.

Measurements are left out, each candidate is made without them, and what it predicts there is
compared with what was measured (M. Stone, Cross-validatory choice and assessment of statistical
predictions, J. Royal Statistical Society B 36, 1974). Errors of both are of the same measurements,
so they are compared in pairs, and a difference counts where their own scatter does not explain it.
Smoothers leave out each value (`smoothing.batch.columns`) or runs of poses (`batch.predicted`), the
noise of an IMU is judged by two seconds at once (`filter.learning`), the stages of a pipeline by
every fifth pose. Errors that last over what is left out are in the measurements as well, and are
not seen.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

EQUAL = 1.0
"""Standard errors of their difference up to which predictions count as equal. Chosen on V1_02 and
synthetic motions."""
_EVERY, _FEWEST = 5, 40
"""Of so many measured poses one is held out, so that its neighbours are kept, and those that a
cubic takes besides; of fewer poses too few (8) for a root mean square to mean anything."""
_REACH = 3.0
"""A held-out pose with no kept one within so many usual intervals stands in a gap, where only
extrapolation is judged, not the path."""
_SEGMENTS = 20
"""Errors last within one of so many segments of a recording, and hardly from one to the next."""
_LEAST = np.finfo(np.float64).tiny


def held_out(count: int) -> NDArray[np.bool_]:
    """Which of so many measured poses ``(count,)`` are held out: every fifth, none of a few."""
    rows = np.arange(count) % _EVERY == _EVERY // 2
    return rows if count >= _FEWEST else np.zeros(count, dtype=np.bool_)


def judged_stamps(measured: Trajectory) -> IntArray:
    """Stamps of held-out poses with two kept ones on either side, and near."""
    out = held_out(len(measured))
    kept_ns, stamps = measured.time_ns[~out], measured.time_ns[out]
    after = np.searchsorted(kept_ns, stamps)
    inside = (after > 1) & (after < len(kept_ns) - 1)
    stamps, after = stamps[inside], after[inside]
    usual_ns = float(np.median(np.diff(measured.time_ns)))
    near: NDArray[np.bool_] = kept_ns[after] - kept_ns[after - 1] <= _REACH * usual_ns
    return stamps[near]


def standard_errors(differences: FloatArray) -> FloatArray:
    """Means of differences ``(*, N)``, in their standard errors; 0 where there are none."""
    mean, count = np.mean(differences, axis=-1), differences.shape[-1]
    square = np.einsum("...j,...j->...", differences, differences) / count
    scatter = np.sqrt(np.maximum(square - mean**2, 0.0) / count)
    behind = np.divide(mean, scatter, out=np.zeros_like(mean), where=scatter > 0.0)
    return np.asarray(behind, dtype=np.float64)


def surely_above_zero(differences: FloatArray, chance: float = 0.05) -> bool:
    """Whether what pairs ``(N,)`` differ by is above zero by more than chance, to one side.

    By Student's distribution, which knows of the scatter itself only what N pairs tell.
    """
    from scipy.special import stdtr

    count = len(differences)
    if count < 2:
        return False
    student = standard_errors(differences) * np.sqrt((count - 1) / count)
    return bool(stdtr(count - 1, student) > 1.0 - chance)


def surely_grown(before: FloatArray, after: FloatArray, chance: float) -> bool:
    """Whether errors ``(N,)`` grew by a factor that segments of a recording do not by chance.

    Of differences of squares, a segment where the path is lost would hide how all others grew.
    """
    if len(before) < 2 * _SEGMENTS:
        return False
    was, now = (
        np.log([max(np.mean(part**2), _LEAST) for part in np.array_split(errors, _SEGMENTS)])
        for errors in (before, after)
    )
    return surely_above_zero(now - was, chance)
