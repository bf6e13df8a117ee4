"""Whether the stages of a run agree with each other and with the pictures."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True)
class IntegrityCheck:
    """One thing that can be checked without a ground truth: how often it fails, and may fail.

    Fields:
        name: coverage, inertial, innovations, registration or agreement.
        failures: frames or measurements that fail it.
        count: how many there are.
        allowed: how many may fail in a run that is right.
        summary: all of that in one sentence, with the figures behind it.

    >>> from motorcade.replays.values.integrity import IntegrityCheck
    >>> IntegrityCheck("coverage", 12, 200, 100, "12 of 200 frames have no pose").passed
    True
    """

    name: Literal["coverage", "inertial", "innovations", "registration", "agreement"]
    failures: int
    count: int
    allowed: int
    summary: str

    @property
    def passed(self) -> bool:
        """Whether no more fail than may."""
        return self.failures <= self.allowed


@dataclass(frozen=True, eq=False)
class Integrity:
    """What was checked of a run, and the path that the character is drawn along.

    Fields:
        checks: those that this run allows.
        registration_px: of each path, ``(M,)`` how far what is drawn along it lies from the
            footage, a frame; empty where no poses were measured in pictures.
        drawn: the first smoothed path, or the measured one where that contradicts the measurements.
        drawn_is: which of them.

    >>> import numpy as np
    >>> from motorcade.fusion.motions import MOTIONS
    >>> from motorcade.replays import Integrity
    >>> from motorcade.replays.values.integrity import IntegrityCheck
    >>> check = IntegrityCheck("coverage", 180, 200, 100, "180 of 200 frames have no pose")
    >>> path = MOTIONS["handheld"].sampled(rate_hz=50.0, duration_s=1.0)
    >>> Integrity((check,), {}, path, "smoothed").doubts
    ('180 of 200 frames have no pose',)
    """

    checks: tuple[IntegrityCheck, ...]
    registration_px: dict[str, FloatArray]
    drawn: Trajectory
    drawn_is: Literal["smoothed", "measured"]

    @property
    def doubts(self) -> tuple[str, ...]:
        """A sentence for each check that failed; none where the result can be relied on."""
        return tuple(check.summary for check in self.checks if not check.passed)

    def as_dict(self) -> dict[str, Any]:
        """Checks and doubts, ready for JSON."""
        return {
            "doubts": list(self.doubts),
            "drawn": self.drawn_is,
            "checks": [asdict(check) | {"passed": check.passed} for check in self.checks],
        }
