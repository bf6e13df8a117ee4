"""Errors of a run's paths, as figures and over time."""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.fusion.metrics import Align
from motorcade.ga.arrays import FloatArray
from motorcade.replays.stages.values.stage_comparison import NOT_COMPARED, StageComparison


@dataclass(frozen=True, eq=False)
class ErrorSeries:
    """Errors of one path over time; seconds count from the first stamp of the measured path."""

    time_s: FloatArray
    position_m: FloatArray
    rotation_deg: FloatArray


@dataclass(frozen=True, eq=False)
class AccelerationSeries:
    """Length of the angular acceleration of one path over time, in the moving frame."""

    time_s: FloatArray
    angular_rad_s2: FloatArray


@dataclass(frozen=True, eq=False)
class PathErrors:
    """Figures and series for each path: `measured`, `fused`, and every smoothed representation.

    `align` is the alignment used; without a ground truth it is "none" and `against_truth` empty.
    So it is where the ground truth has too few poses to align by; `unaligned` then says so.
    `stages` tells whether each stage made the path better.

    >>> from motorcade.replays import PathErrors
    >>> figures = {"measured": {"linear_jitter_m_s2": 1.2}, "motor": {"linear_jitter_m_s2": 0.4}}
    >>> errors = PathErrors("none", figures, against_truth={}, acceleration={})  # no ground truth
    >>> min(errors.figures, key=lambda path: errors.figures[path]["linear_jitter_m_s2"])
    'motor'
    """

    align: Align
    figures: dict[str, dict[str, float | None]]
    against_truth: dict[str, ErrorSeries]
    acceleration: dict[str, AccelerationSeries]
    stages: StageComparison = NOT_COMPARED
    unaligned: str = ""
