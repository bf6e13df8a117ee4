"""What is wrong with an inertial recording, one line each, and what cannot be told of it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

FaultName = Literal[
    "measurements_refused",
    "stamp_unit",
    "stuck",
    "poses_inverted",
    "unrelated",
    "rate_unit",
    "position_unit",
    "force_unit",
    "rate_scale",
    "force_scale",
    "extrinsics_inverted",
    "extrinsics_turned",
    "rate_axes",
    "force_axes",
    "rate_sign",
    "force_sign",
    "clock_drift",
    "delay",
    "axes",
    "gravity",
    "lean",
    "saturated",
    "attitude_unknown",
    "rate_unexplained",
    "force_unexplained",
    "rate_bias",
    "force_bias",
    "deviations_modelled",
]
"""Worst first: the first says that the path is wrong, the last only what deviations leave out."""

_ORDER: tuple[FaultName, ...] = get_args(FaultName)


@dataclass(frozen=True)
class HealthFinding:
    """A fault: its name, and one line that says what was found and what mends it.

    Fields:
        fault: its name.
        summary: the line.
        instead: name of another fault that every measurement would show alike; None where there is
            none. The line then names both.

    Examples:
        >>> from motorcade.fusion.health import HealthFinding
        >>> HealthFinding("delay", "the IMU's stamps are 0.5 s late: time_offset_s=0.5").fault
        'delay'
    """

    fault: FaultName
    summary: str
    instead: FaultName | None = None


@dataclass(frozen=True)
class Health:
    """What a check of an IMU beside a path has found.

    Fields:
        findings: what is wrong, worst first; empty where nothing is.
        unknown: what the motion does not tell, one line each: no fault, but no proof either.

    Examples:
        >>> from motorcade.fusion.health import HealthFinding, Health
        >>> Health((HealthFinding("delay", "the IMU's stamps are 0.5 s late"),), ()).sound
        False
    """

    findings: tuple[HealthFinding, ...] = ()
    unknown: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        ordered = sorted(self.findings, key=lambda finding: _ORDER.index(finding.fault))
        object.__setattr__(self, "findings", tuple(ordered))

    @property
    def sound(self) -> bool:
        """Whether nothing was found but what deviations leave out."""
        return not set(self.faults) - {"deviations_modelled"}

    @property
    def failed(self) -> bool:
        """Whether more poses were refused than accepted: no path then, only an opinion."""
        return "measurements_refused" in self.faults

    @property
    def faults(self) -> tuple[FaultName, ...]:
        """Names of what was found."""
        return tuple(one.fault for one in self.findings)

    @property
    def summary(self) -> str:
        """All in one line."""
        if self.findings:
            return "; ".join(one.summary for one in self.findings)
        if self.unknown:
            return "; ".join(self.unknown)
        return "the IMU agrees with the path"

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "sound": self.sound,
            "failed": self.failed,
            "findings": [asdict(one) for one in self.findings],
            "unknown": list(self.unknown),
        }
