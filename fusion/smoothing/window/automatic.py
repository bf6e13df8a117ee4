"""How wide a window may be before it takes away motion instead of noise.

White noise gives up a known share of its variance to a window of a given width, so how far
smoothing moves a path tells how large the noise would have to be. Two things betray motion: that
size grows as the window widens, or it exceeds the uncertainty that the path itself claims.
"""

from __future__ import annotations

import numpy as np

from motorcade.fusion.smoothing.representations import REPRESENTATIONS
from motorcade.fusion.smoothing.window.local_polynomial import local_polynomial, white_noise_removed
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray

__all__ = ["automatic_window_s"]

_FEWEST, _MOST = 2, 10
# White noise of a few hundred poses estimates its own variance to better than this factor.
_GROWTH = 1.5


def automatic_window_s(
    trajectory: Trajectory, covariance: FloatArray, order: int = 2
) -> float | None:
    """The widest window, up to 21 poses, that removes noise alone; None if none does.

    Args:
        trajectory: N poses; the window is counted in their median interval.
        covariance: ``(N, 6, 6)`` of the right perturbation, rotation (rad) then translation (m).
        order: of the local polynomials, see `local_polynomial`.

    Raises:
        ValueError: covariances that do not fit the trajectory, or as `local_polynomial`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion.smoothing import automatic_window_s
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> covariance = np.diag([0.02**2] * 3 + [0.01**2] * 3)  # rotation first
        >>> window_s = automatic_window_s(noisy, np.tile(covariance, (len(noisy), 1, 1)))
        >>> print(f"{window_s:.2f} s")
        0.70 s
    """
    if covariance.shape != (len(trajectory), 6, 6):
        raise ValueError(f"covariance: expected {(len(trajectory), 6, 6)}, got {covariance.shape}")
    if len(trajectory) < 2 * _MOST + 1:
        return None
    interval_s = float(np.median(np.diff(trajectory.time_s)))
    widest, narrowest_size = None, None
    for neighbours in range(_FEWEST, _MOST + 1):
        share = white_noise_removed(neighbours, order)
        if share < 1e-6:
            continue  # so few poses are met exactly
        window_s = (2 * neighbours + 1) * interval_s
        size = _mean_square_change(trajectory, covariance, window_s, order) / share
        narrowest_size = size if narrowest_size is None else narrowest_size
        if size > _GROWTH * min(1.0, narrowest_size):
            break
        widest = window_s
    return widest


def _mean_square_change(
    trajectory: Trajectory, covariance: FloatArray, window_s: float, order: int
) -> float:
    """Mean square of how far smoothing moves the poses, in their own standard deviations."""
    motors = REPRESENTATIONS["motor"]
    smoothed = local_polynomial(trajectory, motors, window_s=window_s, order=order)
    change = trajectory.motors.local(smoothed.motors)
    weighed = np.linalg.solve(covariance, change[..., None])[..., 0]
    return float(np.mean(change * weighed))
