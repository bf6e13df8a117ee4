"""Camera poses simulated from ground truth: noisy, at a camera's rate, degraded as one may ask.

They stand in for a tracker where a recording has ground truth but no images. What goes wrong
beyond noise is a degradation: outliers, blackouts, stamps that are late, or several in turn.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.motions.degradations import Degradation
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import checked_positive
from motorcade.ga.stamps import stamps_at_rate
from motorcade.tracking.measurements import PoseMeasurements

_MOST = 1e9  # of any of the numbers, whose squares are covariances


def simulate_camera_poses(
    truth: Trajectory,
    rate_hz: float,
    sigma_m: float,
    sigma_rad: float,
    rng: np.random.Generator,
    degradation: Degradation | None = None,
) -> PoseMeasurements:
    """Measure `truth` at `rate_hz` with independent Gaussian errors in the camera's axes.

    Args:
        truth: ``world_T_camera``; between its stamps it follows the screw.
        rate_hz: measurements a second, from the first stamp of `truth` to its last, but none in
            gaps of more than ten seconds (see `motorcade.ga.stamps`).
        sigma_m: deviation of the position an axis, above zero.
        sigma_rad: deviation of the rotation an axis; both also make the measurements' covariance.
        rng: source of the errors.
        degradation: what happens to the noisy poses besides, such as
            ``InTurn((Outliers(0.02, 0.5, 0.5), Blackouts(2.0, 15.0), Latency(0.02)))``; the
            covariances do not tell of it.

    Raises:
        ValueError: a rate or deviation that is not positive, or a rate that makes more than
            50,000 poses and 500 more a pose of `truth`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ADIS16448, ContinuousPath
        >>> from motorcade.fusion import simulate_camera_poses, simulate_imu
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> rng = np.random.default_rng(0)
        >>> path = ContinuousPath.along(gimbal_crossing(), 3.0)
        >>> sensor = simulate_imu(path, 100.0, ADIS16448, rng)
        >>> measured = simulate_camera_poses(sensor.path, 20.0, 0.01, 0.01, rng)

        >>> measured.trajectory
        Trajectory(world_T_imu, 61 poses, 3.000 s)
    """
    for name, value in (("rate_hz", rate_hz), ("sigma_m", sigma_m), ("sigma_rad", sigma_rad)):
        if checked_positive(value, name) > _MOST:
            raise ValueError(f"{name}: expected at most {_MOST:g}, got {value}")
    stamps = stamps_at_rate(truth.time_ns, rate_hz, "rate_hz")
    sigma = np.repeat([sigma_rad, sigma_m], 3)
    noise = Motor.from_twist(sigma * rng.standard_normal((len(stamps), 6)))
    measured = truth.resampled(stamps).transformed_by(right=noise)
    if degradation is not None:
        measured = degradation.apply(measured, rng)
    return PoseMeasurements(measured, np.tile(np.diag(sigma**2), (len(measured), 1, 1)))
