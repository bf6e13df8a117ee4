"""How the paths of a run are judged: their errors, whether stages agree, what each stage gained.

The report, as files, stands with them. They are apart from the paths so that an edit here leaves
what is smoothed as it is.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from motorcade.fusion.metrics import Align
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.audit import AuditFinding, Verdict, worst


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


@dataclass(frozen=True)
class StageComparison:
    """How far the path is from what it is judged by, after each stage, on the same stamps.

    Fields:
        judged_by: the ground truth; without one, measured poses that the path was made without.
        poses: at how many stamps.
        position_rmse_m, rotation_rmse_deg: by stage: camera_poses, fused, smoothed. What poses are
            held out have errors of their own, which are in these figures.
        worse: a sentence for each stage whose path is farther off than the one before, and why.

    >>> from motorcade.replays.stages.values.errors import StageComparison
    >>> found = StageComparison("nothing", 0, {}, {}, ())
    >>> found.as_dict()["worse"]
    []
    """

    judged_by: JudgedBy
    poses: int
    position_rmse_m: dict[str, float]
    rotation_rmse_deg: dict[str, float]
    worse: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The same, ready for JSON."""
        return asdict(self) | {"worse": list(self.worse)}


NOT_COMPARED = StageComparison("nothing", 0, {}, {}, ())
"""What is told where there is nothing to judge by."""


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


@dataclass(frozen=True, eq=False)
class Integrity:
    """What was checked of a run, and the path that the character is drawn along.

    Fields:
        checks: those that this run allows: what the stage found, then what measuring the poses
            found of what it was told.
        registration_px: of each path, ``(M,)`` how far what is drawn along it lies from the
            footage, a frame; empty where no poses were measured in images.
        drawn: the first smoothed path, or the measured one where that contradicts the measurements.
        drawn_is: which of them.

    >>> import numpy as np
    >>> from motorcade.fusion.motions import MOTIONS
    >>> from motorcade.replays import Integrity
    >>> from motorcade.tracking import AuditFinding
    >>> told = "180 of 200 frames have no pose"
    >>> check = AuditFinding("coverage", "doubtful", 0.9, "share of frames", told)
    >>> path = MOTIONS["handheld"].sampled(rate_hz=50.0, duration_s=1.0)
    >>> found = Integrity((check,), {}, path, "smoothed")
    >>> found.verdict, found.doubts
    ('doubtful', ('180 of 200 frames have no pose',))
    """

    checks: tuple[AuditFinding, ...]
    registration_px: dict[str, FloatArray]
    drawn: Trajectory
    drawn_is: Literal["smoothed", "measured"]

    @property
    def verdict(self) -> Verdict:
        """The worst of all checks."""
        return worst(self.checks)

    @property
    def doubts(self) -> tuple[str, ...]:
        """A sentence for each check that failed; none where the result can be relied on."""
        return tuple(check.sentence for check in self.checks if not check.passed)

    def as_dict(self) -> dict[str, Any]:
        """Verdict, doubts and checks, ready for JSON."""
        return {
            "verdict": self.verdict,
            "doubts": list(self.doubts),
            "drawn": self.drawn_is,
            "checks": [asdict(check) for check in self.checks],
        }


JudgedBy = Literal["ground truth", "held-out poses", "nothing"]


@dataclass(frozen=True)
class ReportFiles:
    """The page, its figures as JSON, and what lies beside it where it would be too large inside.

    Fields:
        page, summary: the page and its figures.
        footage: a copy of the footage that the viewer plays; None where it is inside.
        viewer: the viewer; None where it is inside.
    """

    page: Path
    summary: Path
    footage: Path | None = None
    viewer: Path | None = None
