"""What a latency curve and learnt noise say: light values, which results of a run hold.

They stand apart from what makes them: an edit of the filter computes no smoothing anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.ga.arrays import FloatArray

DENSITIES_AND_WALKS = (
    "gyro_density_rad_s_rthz",
    "gyro_walk_rad_s2_rthz",
    "accel_density_m_s2_rthz",
    "accel_walk_m_s3_rthz",
)
"""What is learnt of an `ImuNoise`."""


@dataclass(frozen=True, eq=False)
class LatencyCurve:
    """Root mean square errors of a path over how much later its poses are answered.

    Fields:
        lag_s: ``(K,)``; infinity last, for the whole recording.
        position_m, rotation_deg: ``(K,)``.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.filter.findings import LatencyCurve
        >>> LatencyCurve(np.array([0.0, np.inf]), np.array([9e-3, 4e-3]), np.zeros(2)).position_m
        array([0.009, 0.004])
    """

    lag_s: FloatArray
    position_m: FloatArray
    rotation_deg: FloatArray


@dataclass(frozen=True)
class NoiseScore:
    """How well a noise predicts poses that it was not learnt from.

    Fields:
        log_density: of the next pose: mean natural logarithm, with radians and metres.
        nis_per_dimension: of the next pose: 1 where the noise fits.
        correlation: of its normalised innovations with those 1, 2, 4 and 8 poses before: near zero
            where they are white.
        held_out_log_density: of poses held out for two seconds.
        held_out_nis_per_dimension: likewise.
        held_out_m, held_out_deg: root mean square errors of their predictions.
    """

    log_density: float
    nis_per_dimension: float
    correlation: tuple[float, ...]
    held_out_log_density: float
    held_out_nis_per_dimension: float
    held_out_m: float
    held_out_deg: float


@dataclass(frozen=True)
class LearntNoise:
    """The noise to use, and what it rests on.

    Fields:
        noise: what was learnt where that is better, else what it started from.
        learnt: whether it is what was learnt.
        summary: which, and why, in words.
        factors: what was found over what it started from, by field of `ImuNoise`.
        before, after: the turns that judged, with what it started from and with what was found;
            None where the recording was too short.

    Examples:
        >>> from motorcade.fusion import ADIS16448
        >>> from motorcade.fusion.filter import LearntNoise
        >>> LearntNoise(ADIS16448, False, "the recording is too short").noise is ADIS16448
        True
    """

    noise: ImuNoise
    learnt: bool
    summary: str
    factors: tuple[tuple[str, float], ...] = ()
    before: NoiseScore | None = None
    after: NoiseScore | None = None

    def as_dict(self) -> dict[str, Any]:
        """Figures, ready for JSON."""
        return {
            "learnt": self.learnt,
            "summary": self.summary,
            "factors": dict(self.factors),
            **{name: getattr(self.noise, name) for name in DENSITIES_AND_WALKS},
            **{
                when: None
                if score is None
                else {**vars(score), "correlation": [*score.correlation]}
                for when, score in (("before", self.before), ("after", self.after))
            },
        }
