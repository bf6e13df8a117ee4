"""What an answer gains by coming later: errors of fixed-lag paths over their lag."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from motorcade.fusion.filter.findings import LatencyCurve
from motorcade.fusion.filter.fused import Fused
from motorcade.fusion.metrics.poses.pose_error import absolute_translation_m, rotation_rad
from motorcade.ga import Trajectory

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
