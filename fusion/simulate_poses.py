"""Camera poses simulated from a truth: noisy, at a camera's rate, with blackouts.

They stand in for a tracker where a recording has a truth but no images to track.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.tracking.measurements import PoseMeasurements

__all__ = ["simulate_camera_poses"]


def simulate_camera_poses(
    truth: Trajectory,
    rate_hz: float,
    sigma_m: float,
    sigma_rad: float,
    rng: np.random.Generator,
    blackouts_s: Sequence[tuple[float, float]] = (),
) -> PoseMeasurements:
    """Measure `truth` at `rate_hz` with independent Gaussian errors in the camera's axes.

    Args:
        truth: ``world_T_camera``; between its stamps it follows the screw.
        rate_hz: measurements a second, from the first stamp of the truth to its last.
        sigma_m: deviation of the position an axis, above zero.
        sigma_rad: deviation of the rotation an axis; both also make the measurements' covariance.
        rng: source of the errors. Noise is drawn for blacked-out stamps too, so the other
            measurements do not depend on the blackouts.
        blackouts_s: spans (start, end) in seconds after the first stamp, start included and end
            not, in which nothing is measured.

    Raises:
        ValueError: a rate or deviation that is not positive, a span that ends before it starts, or
            blackouts that leave nothing.
    """
    for name, value in (("rate_hz", rate_hz), ("sigma_m", sigma_m), ("sigma_rad", sigma_rad)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name}: expected a number above 0, got {value}")
    count = int(np.floor(truth.duration_s * rate_hz + 1e-6)) + 1
    offsets = np.round(np.arange(count) * (1e9 / rate_hz)).astype(np.int64)
    offsets = np.minimum(offsets, truth.time_ns[-1] - truth.time_ns[0])
    sigma = np.repeat([sigma_rad, sigma_m], 3)
    noise = Motor.from_twist(sigma * rng.standard_normal((count, 6)))
    measured = truth.resampled(truth.time_ns[0] + offsets).transformed_by(right=noise)
    seen = np.ones(count, dtype=np.bool_)
    for start_s, end_s in blackouts_s:
        if not start_s < end_s:
            raise ValueError(f"blackouts_s: expected start < end, got ({start_s}, {end_s})")
        seen &= (offsets * 1e-9 < start_s) | (offsets * 1e-9 >= end_s)
    if not np.any(seen):
        raise ValueError(f"blackouts_s: expected some of {count} stamps to stay, got none")
    return PoseMeasurements(measured[seen], np.tile(np.diag(sigma**2), (int(seen.sum()), 1, 1)))
