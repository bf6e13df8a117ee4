"""Lag: how much later an estimate moves than the ground truth, from their cross-correlation.

Positive lag is late; poses ahead of the ground truth have negative lag. The ground truth is read at
the estimate's stamps minus the lag tried, so uneven stamps and gaps do no harm, and both sides are
differenced over the same steps, so an estimate equal to the ground truth has no lag at all.
Position and angular rate are correlated apart: one shows what smoothing did to translations, the
other what it did to rotations.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.metrics.smooth_path import NotObservableError, SmoothPath
from motorcade.ga import Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.stamps import near_steps

_COARSE_STEP_S = 0.01
_GRID_S = 0.005
_PEAK_TOLERANCE_S = 1e-5
_ROOT_TOLERANCE_S = 1e-12
_BATCHES = 20
_MOST_LAG_S = 60.0
# Changes smaller than this part of the values may be rounding.
_EVEN = 1e-9
# Over longer steps a mean rate in the moving frame says little about the moment.
_LONGEST_STEP_S = 0.25
_FEWEST_STAMPS = 4


def position_lag_s(estimate: Trajectory, truth: Trajectory, max_lag_s: float = 0.5) -> float:
    """Lag of the positions in seconds.

    The worlds must be aligned (a shift between them does no harm, a turn does).

    Raises:
        NotObservableError: trajectories that overlap too little, that do not move, or whose
            correlation still rises at the edge of ``±max_lag_s`` or has a peak too flat to place:
            a standard error above half the estimate's median interval.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import position_lag_s
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.ga import Trajectory
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=100.0, duration_s=10.0)
        >>> late = Trajectory(true.time_ns + 20_000_000, true.poses)
        >>> round(position_lag_s(late, true), 4)
        0.02
    """
    path = SmoothPath.through(truth)
    time_s = path.seconds(estimate.time_ns)
    time_s, kept, limit_s = _inner(path, time_s, time_s, max_lag_s)
    ours = estimate.motors.translation_m[kept]
    return _peak(ours, lambda lag: path.positions_m(time_s - lag), limit_s, _half_step(estimate))


def angular_rate_lag_s(estimate: Trajectory, truth: Trajectory, max_lag_s: float = 0.5) -> float:
    """Lag of the angular rates in seconds; rates are those of the moving frame, in its own axes.

    Raises:
        NotObservableError: as `position_lag_s`, or steps longer than 0.25 s.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import angular_rate_lag_s
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.ga import Trajectory
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=100.0, duration_s=10.0)
        >>> late = Trajectory(true.time_ns + 20_000_000, true.poses)
        >>> round(angular_rate_lag_s(late, true), 4)
        0.02
    """
    path = SmoothPath.through(truth)
    time_s = path.seconds(estimate.time_ns)
    steps = np.diff(time_s)
    _, kept, limit_s = _inner(path, time_s[:-1], time_s[1:], max_lag_s)
    near = near_steps(steps) & (steps <= _LONGEST_STEP_S)
    chosen = np.flatnonzero(kept & near)
    if chosen.size < _FEWEST_STAMPS:
        raise NotObservableError(
            f"lag: expected {_FEWEST_STAMPS} steps of at most {_LONGEST_STEP_S} s between poses, "
            f"got {chosen.size}"
        )
    usual_s = float(np.median(steps[chosen]))
    steps = steps[chosen, None]
    ends, index = np.unique([chosen, chosen + 1], return_inverse=True)
    first, second = index.reshape(2, -1)

    def rates(rotors: Rotor) -> FloatArray:
        turns = rotors[first].inverse() @ rotors[second]
        return np.asarray(turns.as_rotation_vector() / steps, dtype=np.float64)

    rough = _even_rates(path, usual_s, time_s[chosen], limit_s)

    return _peak(
        rates(estimate.motors.rotor[ends]),
        lambda lag: rates(path.rotors(time_s[ends] - lag)),
        limit_s,
        _half_step(estimate),
        rough=lambda lag: rough(time_s[chosen] - lag),
    )


def _even_rates(
    path: SmoothPath, step_s: float, around_s: FloatArray, reach_s: float
) -> Callable[[FloatArray], FloatArray]:
    """Mean angular rates of the ground truth over a step from any time, between those of a grid.

    The grid stands within a reach of increasing times ``(N,)``: gaps between them cost nothing.
    """
    first_s, last_s = path.span_s
    most = int(np.ceil((last_s - step_s - first_s) / _GRID_S))
    begin = np.floor((around_s - reach_s - first_s) / _GRID_S).astype(np.int64)
    end = np.ceil((around_s + reach_s - first_s) / _GRID_S).astype(np.int64) + 1
    begin = np.maximum(begin, np.append(0, np.maximum.accumulate(end)[:-1]))  # each place once
    places = np.concatenate([np.arange(a, b) for a, b in zip(begin, end, strict=True)])
    grid_s = first_s + _GRID_S * places[places < most]
    turns = path.rotors(grid_s).inverse() @ path.rotors(grid_s + step_s)
    grid = turns.as_rotation_vector() / step_s
    return lambda time_s: np.stack([np.interp(time_s, grid_s, column) for column in grid.T], -1)


def _half_step(estimate: Trajectory) -> float:
    return 0.5 * float(np.median(np.diff(estimate.time_s)))


def _inner(
    path: SmoothPath, start_s: FloatArray, end_s: FloatArray, max_lag_s: float
) -> tuple[FloatArray, NDArray[np.bool_], float]:
    """Start times that stay inside the ground truth at every lag tried, their mask, the limit."""
    if not 0.0 < max_lag_s <= _MOST_LAG_S:
        raise ValueError(f"max_lag_s: expected above 0 and up to {_MOST_LAG_S:g}, got {max_lag_s}")
    first, last = path.span_s
    begin = max(first, float(start_s.min(initial=last)))
    overlap = min(last, float(end_s.max(initial=first))) - begin
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
    """Correlation of changes with values, each ``(N, 3)``."""
    true = _changing(true)
    return _product(ours, true) / (_norm(ours) * _norm(true))


def _norm(values: FloatArray) -> float:
    return float(np.sqrt(_product(values, values)))


def _product(ones: FloatArray, others: FloatArray) -> float:
    """As NumPy's, but by this thread: BLAS wakes others for so little, thousands of times."""
    return float(np.sum(ones * others))


def _changing(values: FloatArray) -> FloatArray:
    centred: FloatArray = values - values.mean(axis=0)
    if _norm(centred) <= _EVEN * _norm(values):
        raise NotObservableError(
            "lag: expected trajectories that move, got one that stands still or turns evenly"
        )
    return centred


def _peak(
    ours: FloatArray,
    true: Callable[[float], FloatArray],
    limit_s: float,
    largest_error_s: float,
    rough: Callable[[float], FloatArray] | None = None,
) -> float:
    """Lag in ``±limit_s`` at which `true` (N, 3) correlates best with `ours`.

    `rough` stands for `true` where that is slow: it finds the hill, `true` the way up from there.
    """
    count = int(limit_s / _COARSE_STEP_S)
    lags = _COARSE_STEP_S * np.arange(-count, count + 1)
    search, changes = rough or true, _changing(ours)
    best = int(np.argmax([_similarity(changes, search(float(lag))) for lag in lags]))
    if rough is not None:
        best = _climbed(lambda i: _similarity(changes, true(float(lags[i]))), best, len(lags))
    if best in (0, len(lags) - 1):
        raise NotObservableError(
            f"lag: expected a peak of the correlation within ±{limit_s:.3f} s, got one at the edge"
        )
    peak = _refined(ours, true, float(lags[best]))
    error_s = standard_error_s(ours, *_scores(ours, true, peak))
    if not error_s <= largest_error_s:
        raise NotObservableError(
            f"lag: expected a peak of the correlation known to {1e3 * largest_error_s:.3g} ms, "
            f"got a standard error of {1e3 * error_s:.3g} ms"
        )
    return peak


def _climbed(height: Callable[[int], float], start: int, count: int) -> int:
    """The local maximum that `start` leads up to, among 0 to ``count - 1``."""
    known: dict[int, float] = {}
    while True:
        near = range(max(start - 1, 0), min(start + 2, count))
        known |= {i: height(i) for i in near if i not in known}
        best = max(near, key=known.__getitem__)
        if best == start:
            return start
        start = best


def _refined(ours: FloatArray, true: Callable[[float], FloatArray], peak: float) -> float:
    """The peak within a coarse step of `peak`.

    Brent's search finds it to 0.01 ms; closer, the correlation is level to rounding (for slow
    motion farther out), and the zero of its slope is found instead.
    """
    from scipy.optimize import brentq, minimize_scalar

    changes = _changing(ours)

    def slope(lag: float) -> float:
        return float(np.sum(_scores(ours, true, lag)[0]))

    optimum = minimize_scalar(
        lambda lag: -_similarity(changes, true(lag)),
        bounds=(peak - _COARSE_STEP_S, peak + _COARSE_STEP_S),
        method="bounded",
        options={"xatol": _PEAK_TOLERANCE_S},
    )
    peak = float(optimum.x)
    for reach in (10.0 * _PEAK_TOLERANCE_S, 100.0 * _PEAK_TOLERANCE_S, _COARSE_STEP_S):
        if slope(peak - reach) > 0.0 > slope(peak + reach):
            return float(brentq(slope, peak - reach, peak + reach, xtol=_ROOT_TOLERANCE_S))
    return peak


def _scores(
    ours: FloatArray, true: Callable[[float], FloatArray], lag: float
) -> tuple[FloatArray, float]:
    """`fit_scores` at a lag."""
    step = _PEAK_TOLERANCE_S
    return fit_scores(ours, true(lag), (true(lag + step) - true(lag - step)) / (2.0 * step))


def fit_scores(
    ours: FloatArray, true: FloatArray, derivative: FloatArray
) -> tuple[FloatArray, float]:
    """Each stamp's share (N,) in the slope of the fit of `true` to `ours`, and its curvature.

    All are ``(N, 3)``, the derivative is by the lag. The fit is ``ours ≈ scale · true(lag) +
    offset``, whose best lag is the correlation's peak; the part of the derivative that scale and
    offset could take is left out. Where `true` runs against `ours`, nothing fits and both are zero.
    """
    a, b, change = (x - x.mean(axis=0) for x in (ours, true, derivative))
    size = float(np.sum(b * b))
    scale = max(float(np.sum(a * b)) / size, 0.0)
    change = scale * (change - b * (float(np.sum(b * change)) / size))
    return np.sum((a - scale * b) * change, axis=1), float(np.sum(change * change))


def standard_error_s(ours: FloatArray, scores: FloatArray, curvature: float) -> float:
    """Standard error of the peak, by batch means: errors of neighbouring stamps go together.

    It holds for slow errors of positions as for white ones; for rates, whose errors cancel from
    step to step, it is a few times too large. What rounding could shift the peak by is added:
    motion straight ahead at one speed looks the same at every lag.
    """
    if curvature <= 0.0:
        return np.inf
    count = min(_BATCHES, scores.size)
    batches = np.array([batch.sum() for batch in np.array_split(scores, count)])
    variance = count / (count - 1) * float(np.sum(batches**2))
    level = np.finfo(np.float64).eps * float(np.sum((ours - ours.mean(axis=0)) ** 2))
    return float(np.sqrt(variance + level * curvature)) / curvature
