"""Lag: how much later than the truth an estimate moves, from the peak of their cross-correlation.

Positive lag is late; poses ahead of the truth have negative lag. The truth is read at the
estimate's stamps minus the lag tried, so uneven stamps and holes do no harm, and the peak is found
between samples by fitting parabolas. Position and angular rate are correlated apart: one shows
what smoothing did to translations, the other what it did to rotations.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.metrics.smooth_path import NotObservableError, SmoothPath
from motorcade.ga import FloatArray, Trajectory

__all__ = ["angular_rate_lag_s", "position_lag_s"]

_COARSE_STEP_S = 0.01
_REFINEMENTS = 4
_GAP_INTERVALS = 3.0
# Over longer steps a mean rate in the moving frame says little about the moment.
_LONGEST_STEP_S = 0.25
_FEWEST_STAMPS = 4


def position_lag_s(estimate: Trajectory, truth: Trajectory, max_lag_s: float = 0.5) -> float:
    """Lag of the positions in seconds.

    The worlds must be aligned (a shift between them does no harm, a turn does).

    Raises:
        NotObservableError: trajectories that overlap too little, that do not move, or whose
            correlation still rises at the edge of ``±max_lag_s``.
    """
    path = SmoothPath(truth)
    time_s = path.seconds(estimate.time_ns)
    time_s, kept, limit_s = _inner(path, time_s, time_s, max_lag_s)
    ours = estimate.poses.translation_m[kept]
    return _peak(lambda lag: _similarity(ours, path.positions_m(time_s - lag)), limit_s)


def angular_rate_lag_s(estimate: Trajectory, truth: Trajectory, max_lag_s: float = 0.5) -> float:
    """Lag of the angular rates in seconds; rates are those of the moving frame, in its own axes.

    Raises:
        NotObservableError: as `position_lag_s`, or steps longer than 0.25 s.
    """
    path = SmoothPath(truth)
    time_s = path.seconds(estimate.time_ns)
    start_s, end_s = time_s[:-1], time_s[1:]
    steps = end_s - start_s
    rotors = estimate.poses.rotor
    rates = (rotors[:-1].inverse() @ rotors[1:]).as_rotation_vector() / steps[:, None]
    start_s, kept, limit_s = _inner(path, start_s, end_s, max_lag_s)
    end_s = end_s[kept]
    near = end_s - start_s <= min(_GAP_INTERVALS * float(np.median(steps)), _LONGEST_STEP_S)
    if np.count_nonzero(near) < _FEWEST_STAMPS:
        raise NotObservableError(
            f"lag: expected {_FEWEST_STAMPS} steps of at most {_LONGEST_STEP_S} s between poses, "
            f"got {np.count_nonzero(near)}"
        )
    start_s, end_s, ours = start_s[near], end_s[near], rates[kept][near]
    return _peak(
        lambda lag: _similarity(ours, path.mean_rates_rad_s(start_s - lag, end_s - lag)), limit_s
    )


def _inner(
    path: SmoothPath, start_s: FloatArray, end_s: FloatArray, max_lag_s: float
) -> tuple[FloatArray, NDArray[np.bool_], float]:
    """Start times that stay inside the truth for every lag tried, their mask, and the limit."""
    if not max_lag_s > 0.0:
        raise ValueError(f"max_lag_s: expected above 0, got {max_lag_s}")
    first, last = path.span_s
    overlap = min(last, float(end_s.max(initial=first))) - max(
        first, float(start_s.min(initial=last))
    )
    limit_s = min(max_lag_s, 0.25 * overlap)
    kept = (start_s >= first + limit_s) & (end_s <= last - limit_s) & path.covers(start_s)
    count = np.count_nonzero(kept)
    if limit_s < _COARSE_STEP_S or count < _FEWEST_STAMPS:
        raise NotObservableError(
            f"lag: expected trajectories that overlap by {4 * _COARSE_STEP_S} s with "
            f"{_FEWEST_STAMPS} stamps or more, got {max(overlap, 0.0):.3f} s with {count}"
        )
    return start_s[kept], kept, limit_s


def _similarity(ours: FloatArray, true: FloatArray) -> float:
    ours, true = ours - ours.mean(axis=0), true - true.mean(axis=0)
    size = float(np.linalg.norm(ours) * np.linalg.norm(true))
    if size == 0.0:
        raise NotObservableError("lag: expected trajectories that move, got one that stands still")
    return float(np.sum(ours * true)) / size


def _peak(correlation: Callable[[float], float], limit_s: float) -> float:
    count = int(limit_s / _COARSE_STEP_S)
    lags = _COARSE_STEP_S * np.arange(-count, count + 1)
    values = [correlation(float(lag)) for lag in lags]
    best = int(np.argmax(values))
    if best in (0, len(values) - 1):
        raise NotObservableError(
            f"lag: expected a peak of the correlation within ±{limit_s:.3f} s, got one at the edge"
        )
    peak, step = float(lags[best]), _COARSE_STEP_S
    for _ in range(_REFINEMENTS):
        left, middle, right = (correlation(peak + k * step) for k in (-1, 0, 1))
        curvature = left - 2.0 * middle + right
        if curvature >= 0.0:
            break
        peak += float(np.clip(0.5 * (left - right) / curvature, -1.0, 1.0)) * step
        step *= 0.3
    return peak
