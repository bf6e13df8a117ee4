"""Whether the stages of a run agree with each other and with the pictures."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.audit import AuditFinding, Verdict, worst


@dataclass(frozen=True, eq=False)
class Integrity:
    """What was checked of a run, and the path that the character is drawn along.

    Fields:
        checks: those that this run allows: what the stage found, then what measuring the poses
            found of what it was told.
        registration_px: of each path, ``(M,)`` how far what is drawn along it lies from the
            footage, a frame; empty where no poses were measured in pictures.
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
