"""Lags of many paths at once, from a table of the ground truth at every lag that is tried.

The lag is that of `motorcade.fusion.metrics.lag`: the peak of the correlation of what was measured
with the ground truth read earlier, unknown where the ground truth does not move, the peak lies at
the edge, or it is too flat to place. Between the lags of the table, 10 ms apart, the correlation is
the quartic through five of them, which places the peak to some microseconds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import near_steps
from motorcade.replays.compare.measure.truth import Truth

_STEP_S = 0.01
_LARGEST_S = 0.5
_FEWEST = 4
# Rates from the table are that even where the motion is.
_EVEN = 1e-6
_BATCHES = 20
_LONGEST_STEP_S = 0.25
_AROUND = np.arange(-2, 3)
# Coefficients of the quartic through values at -2 ... 2.
_QUARTIC = np.linalg.inv(np.vander(_AROUND.astype(np.float64), 5, increasing=True))
# Value and slope at x of the parabola through -1, 0, 1 are these rows times (1, x, x²).
_PARABOLA = np.linalg.inv(np.vander(np.arange(-1.0, 2.0), 3, increasing=True))


@dataclass(frozen=True, eq=False)
class LagTable:
    """The ground truth ``(L, K, 3)`` at lags ``(L,)`` for the stamps (or steps) `kept` ``(K,)``.

    `largest_error_s`, half the median interval, is how badly a peak may be known.
    """

    lag_s: FloatArray
    true: FloatArray
    kept: IntArray
    largest_error_s: float

    @classmethod
    def of_positions(cls, truth: Truth, time_s: FloatArray) -> LagTable:
        """For positions at stamps ``(N,)``."""
        lag_s, kept = _inner(truth, time_s, time_s, np.ones(time_s.size, dtype=np.bool_))
        true, _ = truth.between_rows(time_s[kept] - lag_s[:, None])
        return cls(lag_s, true, kept, _half_step(time_s))

    @classmethod
    def of_rates(cls, truth: Truth, time_s: FloatArray) -> LagTable:
        """For mean angular rates over the steps between stamps ``(N,)``."""
        steps = np.diff(time_s)
        near = near_steps(steps) & (steps <= _LONGEST_STEP_S)
        lag_s, kept = _inner(truth, time_s[:-1], time_s[1:], near)
        _, first = truth.between_rows(time_s[kept] - lag_s[:, None])
        _, second = truth.between_rows(time_s[kept + 1] - lag_s[:, None])
        turns = (first.inverse() @ second).as_rotation_vector()
        return cls(lag_s, turns / steps[kept, None], kept, _half_step(time_s))

    def lags_s(self, paths: FloatArray) -> FloatArray:
        """Lags ``(P, 1)`` of values ``(P, N, 3)`` at the stamps or steps; NaN where unknown."""
        ours = paths[:, self.kept]
        found = np.full((len(paths), 1), np.nan)
        if len(self.kept) < _FEWEST or len(self.lag_s) < 5 or not _changes(self.true):
            return found
        centred = ours - ours.mean(axis=1, keepdims=True)
        size = np.linalg.norm(centred, axis=(1, 2))
        true = self.true - self.true.mean(axis=1, keepdims=True)
        flat = true.reshape(len(true), -1)
        flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
        height = np.einsum("pk,lk->pl", centred.reshape(len(ours), -1), flat)
        for i, heights in enumerate(height):
            if size[i] > _EVEN * np.linalg.norm(ours[i]):
                found[i, 0] = self._peak(centred[i], heights, true)
        return found

    def _peak(self, ours: FloatArray, height: FloatArray, true: FloatArray) -> float:
        best = int(np.argmax(height))
        if best in (0, len(height) - 1) or not height[best] > 0.0:
            return np.nan
        centre = min(max(best, 2), len(height) - 3)
        place = centre + _top(height[centre + _AROUND], best - centre)
        nearest = min(max(round(place), 1), len(height) - 2)
        error_s = _standard_error_s(ours, true[nearest - 1 : nearest + 2], place - nearest)
        if not error_s <= self.largest_error_s:
            return np.nan
        return float(self.lag_s[0] + _STEP_S * place)


def _inner(
    truth: Truth, start_s: FloatArray, end_s: FloatArray, usable: NDArray[np.bool_]
) -> tuple[FloatArray, IntArray]:
    """Lags to try, and which stretches stay in the ground truth at all of them."""
    first, last = truth.span_s
    overlap = min(last, float(end_s.max())) - max(first, float(start_s.min()))
    count = int(min(_LARGEST_S, 0.25 * overlap) / _STEP_S + 1e-9)
    lag_s: FloatArray = np.arange(-count, count + 1) * np.float64(_STEP_S)
    inside = (start_s - lag_s[-1] >= first) & (end_s + lag_s[-1] <= last)
    kept: IntArray = np.flatnonzero(inside & usable).astype(np.int64)
    return lag_s, kept


def _changes(true: FloatArray) -> bool:
    middle = true[len(true) // 2]
    centred = middle - middle.mean(axis=0)
    return bool(np.linalg.norm(centred) > _EVEN * np.linalg.norm(middle))


def _half_step(time_s: FloatArray) -> float:
    return 0.5 * float(np.median(np.diff(time_s)))


def _top(height: FloatArray, start: float) -> float:
    """Where the quartic through five values at -2 ... 2 is highest, near `start`."""
    c = _QUARTIC @ height
    x = float(start)
    for _ in range(20):
        slope = c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * 4.0 * c[4]))
        curvature = 2.0 * c[2] + x * (6.0 * c[3] + x * 12.0 * c[4])
        if not curvature < 0.0:
            break
        step = min(max(-slope / curvature, -0.5), 0.5)
        x = min(max(x + step, start - 1.0), start + 1.0)
        if abs(step) < 1e-12:
            break
    return x


def _standard_error_s(ours: FloatArray, true: FloatArray, x: float) -> float:
    """Standard error of a peak, by batch means; see `fusion.metrics.lag`.

    `ours` ``(K, 3)`` is centred, and so is the ground truth ``(3, K, 3)`` at the lags around the
    peak, which lies `x` steps from the middle one.
    """
    value = np.array([1.0, x, x * x]) @ _PARABOLA
    rate = np.array([0.0, 1.0, 2.0 * x]) @ _PARABOLA / _STEP_S
    b, change = np.tensordot(value, true, 1), np.tensordot(rate, true, 1)
    size = float(np.sum(b * b))
    scale = max(float(np.sum(ours * b)) / size, 0.0)
    change = scale * (change - b * (float(np.sum(b * change)) / size))
    curvature = float(np.sum(change * change))
    if curvature <= 0.0:
        return np.inf
    scores = np.sum((ours - scale * b) * change, axis=1)
    count = min(_BATCHES, scores.size)
    batches = np.array([batch.sum() for batch in np.array_split(scores, count)])
    variance = count / (count - 1) * float(np.sum(batches**2))
    level = np.finfo(np.float64).eps * float(np.sum(ours**2))
    return float(np.sqrt(variance + level * curvature)) / curvature
