"""What is found beside a path: what answers gain by coming later, and the noise that was learnt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.fusion.filter.fused import Fused
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.metrics.poses.pose_error import absolute_translation_m, rotation_rad
from motorcade.ga import Trajectory
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
        >>> from motorcade.fusion.filter import LatencyCurve
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


LAGS_S = (0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0)
"""From no lag to where the curve is flat: a few seconds after it nothing tells of a pose any more,
as velocity and tilt are forgotten by then."""


def latency_curve(
    fused_with: Callable[[float], Fused],
    reference: Trajectory | None = None,
    lags_s: Sequence[float] = LAGS_S,
) -> LatencyCurve:
    """Fuse with one lag after another.

    Args:
        fused_with: fuses with a lag in seconds, always at the same stamps.
        reference: what errors are measured against, in the same world, at all stamps; None: the
            path of the whole recording, so that they are what looking ahead still changes.
        lags_s: lags that are tried, besides the whole recording.

    Examples:
        >>> import numpy as np
        >>> from functools import partial
        >>> from motorcade.fusion import ADIS16448, ContinuousPath, fuse
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.filter import latency_curve
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> from motorcade.ga import Motor
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 2.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)
        >>> by = partial(fuse, measured, sensor.stream, ADIS16448, Motor.identity())
        >>> curve = latency_curve(lambda lag_s: by(lag_s=lag_s), sensor.path, (0.0, 0.5))
        >>> bool(np.all(np.diff(curve.position_m) < 0.0))
        True
    """
    lags = np.array([*lags_s, np.inf])
    whole = fused_with(np.inf).trajectory
    true = whole.motors if reference is None else reference.motors_at(whole.time_ns)
    errors = []
    for lag_s in lags:
        estimated = (whole if lag_s == np.inf else fused_with(float(lag_s)).trajectory).motors
        metres = absolute_translation_m(estimated, true)
        degrees = np.rad2deg(rotation_rad(estimated, true))
        errors.append([np.sqrt(np.mean(metres**2)), np.sqrt(np.mean(degrees**2))])
    position_m, rotation_deg = np.array(errors).T
    return LatencyCurve(lags, position_m, rotation_deg)
