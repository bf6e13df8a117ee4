"""The metrics of many paths at the same stamps; the ground truth's side is computed once.

Definitions are those of `motorcade.fusion.metrics`, to which the tests hold every figure; what is
shared is the ground truth at the stamps, its accelerations, stops and turns, and its path at all
lags that are tried. A path costs a fraction of a millisecond so, where each metric alone takes a
hundred.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from motorcade.fusion.metrics.artifacts import stops, winding_count
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import near_steps
from motorcade.replays.compare.measure.lag import LagTable
from motorcade.replays.compare.measure.truth import Truth

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
        found = np.full((len(poses), 2), np.nan)
        for column, rotation in enumerate((False, True)):
            for before, stop, after in self._stops[column]:
                at, stretch = self.true[stop : stop + 1], slice(before, after + 1)
                course = -_way(at, self.true[before : before + 1], rotation)[0]
                length = float(np.linalg.norm(course))
                if length > 0.0:
                    true = np.max(_way(at, self.true[stretch], rotation) @ course)
                    ours = np.max(_way(at, poses[:, stretch], rotation) @ course, axis=-1)
                    over = np.maximum((ours - true) / length, 0.0)
                    found[:, column] = np.fmax(found[:, column], over)
        found[:, 1] = np.rad2deg(found[:, 1])
        return found

    @functools.cached_property
    def _stops(self) -> tuple[list[tuple[int, int, int]], list[tuple[int, int, int]]]:
        made = []
        for rotation in (False, True):
            ways = _way(self.true[:-1], self.true[1:], rotation)
            made.append(stops(np.linalg.norm(ways, axis=-1) / np.diff(self.time_s)))
        return made[0], made[1]

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
