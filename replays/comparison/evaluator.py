"""The metrics of many paths at the same stamps; the ground truth's side is computed once.

Definitions are those of `motorcade.fusion.metrics`, to which the tests hold every figure; what is
shared is the ground truth at the stamps, its accelerations, stops and turns, and its path at all
lags that are tried. A path costs a fraction of a millisecond so, where each metric alone takes a
hundred.

Lags of many paths at once, from a table of the ground truth at every lag that is tried.

The lag is that of `motorcade.fusion.metrics.lag`: the peak of the correlation of what was measured
with the ground truth read earlier, unknown where the ground truth does not move, the peak lies at
the edge, or it is too flat to place. Between the lags of the table, 10 ms apart, the correlation is
the quartic through five of them, which places the peak to some microseconds.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.metrics.artifacts import stops, winding_count
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import near_steps
from motorcade.replays.comparison.truth import Truth

ERRORS = (
    "ape_rmse_m",
    "rotation_rmse_deg",
    "linear_jitter_m_s2",
    "angular_jitter_rad_s2",
    "log_scale_rmse",
)
"""The metrics that parameters are tuned by; the last one of similarities only."""

METRICS = (
    *ERRORS,
    "lag_ms",
    "angular_rate_lag_ms",
    "overshoot_m",
    "rotation_overshoot_deg",
    "rotation_path_ratio",
    "peak_rate_ratio",
    "spurious_turns",
)
"""What `PathEvaluator.measure` tells, in order."""


class PathEvaluator:
    """Measures paths at given stamps against the ground truth there.

    Args:
        time_ns: stamps ``(N,)``, five or more, that the ground truth knows.
        truth: in the world of the paths.
    """

    def __init__(self, time_ns: IntArray, truth: Truth) -> None:
        self.truth = truth
        self.time_s = truth.seconds(time_ns)
        self.true, self.true_log_scale = truth.poses(self.time_s)
        steps = np.diff(self.time_s)
        near = near_steps(steps)
        self._whole = near[1:] & near[:-1]
        self._true_accelerations = self._accelerations(self.true)

    def errors(self, paths: Sequence[Trajectory]) -> FloatArray:
        """`ERRORS` ``(P, 5)`` of paths at these stamps; NaN where poses have no scale."""
        return self._errors(*_stacked(paths))

    def measure(self, paths: Sequence[Trajectory]) -> FloatArray:
        """`METRICS` ``(P, 12)`` of paths at these stamps; NaN where one cannot be told."""
        poses, log_scale = _stacked(paths)
        return np.concatenate(
            [
                self._errors(poses, log_scale),
                1e3 * self._positions.lags_s(poses.translation_m),
                1e3 * self._rates.lags_s(self._rates_of(poses)),
                self._overshoot(poses),
                self._turning(poses),
            ],
            axis=1,
        )

    def _errors(self, poses: Motor, log_scale: FloatArray | None) -> FloatArray:
        away = np.sum((poses.translation_m - self.true.translation_m) ** 2, axis=-1)
        turned = np.rad2deg((self.true.rotor.inverse() @ poses.rotor).angle())
        ours = self._accelerations(poses)
        jitter = [
            np.sqrt(np.mean(np.sum((a - b) ** 2, axis=-1), axis=-1))
            for a, b in zip(ours, self._true_accelerations, strict=True)
        ]
        scale = np.full(len(away), np.nan)
        if log_scale is not None and self.true_log_scale is not None:
            scale = np.sqrt(np.mean((log_scale - self.true_log_scale) ** 2, axis=-1))
        ape, rotation = np.sqrt(np.mean(away, axis=-1)), np.sqrt(np.mean(turned**2, axis=-1))
        return np.stack([ape, rotation, *jitter, scale], axis=-1)

    def _accelerations(self, poses: Motor) -> tuple[FloatArray, FloatArray]:
        """As `fusion.metrics.accelerations`, of many paths, without those across holes."""
        steps = np.diff(self.time_s)[:, None]
        between = 0.5 * (steps[1:] + steps[:-1])
        rate = (poses[..., :-1].rotor.inverse() @ poses[..., 1:].rotor).as_rotation_vector()
        velocity = np.diff(poses.translation_m, axis=-2) / steps
        linear, angular = (np.diff(v, axis=-2) / between for v in (velocity, rate / steps))
        return linear[..., self._whole, :], angular[..., self._whole, :]

    @functools.cached_property
    def _positions(self) -> LagTable:
        return LagTable.of_positions(self.truth, self.time_s)

    @functools.cached_property
    def _rates(self) -> LagTable:
        return LagTable.of_rates(self.truth, self.time_s)

    def _rates_of(self, poses: Motor) -> FloatArray:
        turns = poses[..., :-1].rotor.inverse() @ poses[..., 1:].rotor
        return turns.as_rotation_vector() / np.diff(self.time_s)[:, None]

    def _overshoot(self, poses: Motor) -> FloatArray:
        """Largest overshoot of position in metres and rotation in degrees ``(P, 2)``."""
        overshoot = np.full((len(poses), 2), np.nan)
        for column, rotation in enumerate((False, True)):
            for before, stop, after in self._stops[column]:
                at, segment = self.true[stop : stop + 1], slice(before, after + 1)
                course = -_way(at, self.true[before : before + 1], rotation)[0]
                length = float(np.linalg.norm(course))
                if length > 0.0:
                    true = np.max(_way(at, self.true[segment], rotation) @ course)
                    ours = np.max(_way(at, poses[:, segment], rotation) @ course, axis=-1)
                    over = np.maximum((ours - true) / length, 0.0)
                    overshoot[:, column] = np.fmax(overshoot[:, column], over)
        overshoot[:, 1] = np.rad2deg(overshoot[:, 1])
        return overshoot

    @functools.cached_property
    def _stops(self) -> tuple[list[tuple[int, int, int]], list[tuple[int, int, int]]]:
        rows = []
        for rotation in (False, True):
            ways = _way(self.true[:-1], self.true[1:], rotation)
            rows.append(stops(np.linalg.norm(ways, axis=-1) / np.diff(self.time_s)))
        return rows[0], rows[1]

    def _turning(self, poses: Motor) -> FloatArray:
        """The gimbal index ``(P, 3)``."""
        steps_s = np.diff(self.time_s)
        turned, true = _steps_rad(poses), _steps_rad(self.true)
        if not np.sum(true) > 1e-9:
            return np.full((len(poses), 3), np.nan)
        error = self.true.rotor.inverse() @ poses.rotor
        turns = np.array([float(winding_count(error[i])) for i in range(len(poses))])
        path = np.sum(turned, axis=-1) / np.sum(true)
        peak = np.max(turned / steps_s, axis=-1) / np.max(true / steps_s)
        return np.stack([path, peak, turns], axis=-1)


def _stacked(paths: Sequence[Trajectory]) -> tuple[Motor, FloatArray | None]:
    """Rigid poses ``(P, N)`` and logarithms of scales ``(P, N)`` where there are some."""
    poses = paths[0].poses
    if isinstance(poses, Motor):
        return Motor.stack([path.motors for path in paths]), None
    parts = [path.poses.as_motor_scale() for path in paths if isinstance(path.poses, Similarity)]
    scales = np.stack([scale for _, scale in parts])
    return Motor.stack([motor for motor, _ in parts]), np.log(scales)


def _steps_rad(poses: Motor) -> FloatArray:
    return (poses[..., :-1].rotor.inverse() @ poses[..., 1:].rotor).angle()


def _way(at: Motor, poses: Motor, rotation: bool) -> FloatArray:
    """Way from one pose to others, as seen from it."""
    if rotation:
        return (at.rotor.inverse() @ poses.rotor).as_rotation_vector()
    return poses.translation_m - at.translation_m


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
        overshoots = np.full((len(paths), 1), np.nan)
        if len(self.kept) < _FEWEST or len(self.lag_s) < 5 or not _changes(self.true):
            return overshoots
        centred = ours - ours.mean(axis=1, keepdims=True)
        size = np.linalg.norm(centred, axis=(1, 2))
        true = self.true - self.true.mean(axis=1, keepdims=True)
        flat = true.reshape(len(true), -1)
        flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
        height = np.einsum("pk,lk->pl", centred.reshape(len(ours), -1), flat)
        for i, heights in enumerate(height):
            if size[i] > _EVEN * np.linalg.norm(ours[i]):
                overshoots[i, 0] = self._peak(centred[i], heights, true)
        return overshoots

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
    """Lags to try, and which segments stay in the ground truth at all of them."""
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
