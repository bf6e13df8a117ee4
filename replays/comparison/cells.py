"""One cell: a true motion, degraded once, smoothed in every way asked for, and measured.

A method that refuses or fails leaves a row that says why; the others go on. What a cell gives
depends on nothing but its fields and the code, so cells can be computed anywhere and kept.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.fusion.smoothing import smooth
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.comparison.evaluator import METRICS, PathEvaluator
from motorcade.replays.comparison.plan import OWN, degradation_named
from motorcade.replays.comparison.truth import RecordedMotion, truth_of

FOR_POSITIONS = "position."
"""Begins the name of a parameter that positions are smoothed by, where rotations have another."""
RAW = ("raw", "none")
"""Method and representation of the row that measures the poses as they come."""
# Digits that are kept: rounding of the last ones may differ from machine to machine.
_DIGITS = 9
_FARTHEST = 1e9


@dataclass(frozen=True)
class Setting:
    """A method in a representation, or `OWN`, with its parameters: pairs of name and value.

    Those of names that begin with `FOR_POSITIONS` are of positions, the others then of rotations.
    """

    method: str
    representation: str
    parameters: tuple[tuple[str, float], ...] = ()

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """Smooth a trajectory so.

        Raises ValueError: what the method refuses, or a result that runs away.
        """
        parameters: dict[str, Any] = dict(self.parameters)
        name = None if self.representation == OWN else self.representation
        others = {
            key.removeprefix(FOR_POSITIONS): parameters.pop(key)
            for key in list(parameters)
            if key.startswith(FOR_POSITIONS)
        }
        smoothed: Trajectory = smooth(trajectory, self.method, name, **parameters)
        if others:
            moved: Trajectory = smooth(trajectory, self.method, name, **parameters | others)
            smoothed = _parts_joined(smoothed, moved)
        farthest = float(np.max(np.abs(smoothed.poses.coefficients)))
        if not farthest < _FARTHEST:
            raise ValueError(f"the result runs away, to coefficients of {farthest:.3g}")
        return smoothed


def _parts_joined(turned: Trajectory, moved: Trajectory) -> Trajectory:
    """The rotations of one path, and positions and scales of another."""
    rigid = Motor.from_rotor_translation(turned.poses.rotor, moved.poses.translation_m)
    poses: Motor | Similarity = rigid
    if isinstance(moved.poses, Similarity):
        poses = Similarity.from_motor_scale(rigid, moved.poses.scale)
    return Trajectory(turned.time_ns, poses, turned.parent, turned.child)


@dataclass(frozen=True)
class MeasuredRow:
    """What one method in one representation made of a cell.

    Fields:
        values: by name of `METRICS`; None where one cannot be told. Empty where the method failed.
        failure: why there is no result, else "".
    """

    method: str
    representation: str
    values: dict[str, float | None]
    failure: str = ""


@dataclass(frozen=True)
class ComparisonCell:
    """What is to be smoothed and measured; rows are the raw poses' and one for each setting."""

    motion: str
    degradation: str
    seed: int
    rate_hz: float
    duration_s: float
    settings: tuple[Setting, ...]
    recorded: RecordedMotion | None = None


def run_cell(cell: ComparisonCell) -> tuple[MeasuredRow, ...]:
    """The rows of a cell."""
    degraded, evaluator = inputs_of(
        cell.motion, cell.degradation, cell.seed, cell.rate_hz, cell.duration_s, cell.recorded
    )
    return tuple(measured_rows(degraded, evaluator, cell.settings))


def inputs_of(
    motion: str,
    degradation: str,
    seed: int,
    rate_hz: float,
    duration_s: float,
    recorded: RecordedMotion | None = None,
) -> tuple[Trajectory, PathEvaluator]:
    """The degraded poses of a cell, and the evaluator of their stamps.

    Draws depend on the seed and the names alone: every method sees the same poses.
    """
    truth = truth_of(motion, duration_s, recorded)
    drawn = np.random.default_rng([seed, _number(motion), _number(degradation)])
    clean = truth.sampled(rate_hz, duration_s)
    degraded = degradation_named(degradation, truth.has_scale).apply(clean, drawn)
    return degraded, PathEvaluator(degraded.time_ns, truth)


def measured_rows(
    degraded: Trajectory, evaluator: PathEvaluator, settings: Iterable[Setting]
) -> list[MeasuredRow]:
    """Smooth by every setting and measure, raw poses first."""
    names, paths, failed = [RAW], [degraded], []
    for setting in settings:
        name = (setting.method, setting.representation)
        try:
            smoothed = setting.smooth(degraded)
        except Exception as error:  # one failing method never ends the others; its row says why
            failed.append(MeasuredRow(*name, {}, why(error)))
            continue
        names.append(name)
        paths.append(smoothed)
    values = evaluator.measure(paths)
    return [
        MeasuredRow(*name, _rounded_metrics(row)) for name, row in zip(names, values, strict=True)
    ] + failed


def why(error: Exception) -> str:
    """An error as one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"[:300]


def _rounded_metrics(values: FloatArray) -> dict[str, float | None]:
    return {
        name: float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None
        for name, value in zip(METRICS, values, strict=True)
    }


def _number(name: str) -> int:
    return zlib.crc32(name.encode())
