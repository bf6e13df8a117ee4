"""The moving Gaussian: every pose becomes a mean of those around it, the near before the far."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.smoothing.checks import checked_order
from motorcade.fusion.smoothing.representations import Representation
from motorcade.fusion.smoothing.window.averages import averaged, polynomial_at_centre
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive

__all__ = ["gaussian"]

# Beyond this many standard deviations weights are lost beside the largest.
_FARTHEST = 8.0


def gaussian(
    trajectory: Trajectory,
    representation: Representation,
    *,
    sigma_s: float = 0.1,
    truncate: float = 4.0,
    order: int = 1,
) -> Trajectory:
    """Average with Gaussian weights over time, ``exp(-t² / 2 sigma_s²)``.

    On even stamps it is the usual Gaussian filter (scipy.ndimage.gaussian_filter1d) away from the
    ends. Where stamps are uneven, and at the ends, a plain mean is drawn towards the side that has
    more poses, by as much as the path moves; the line fitted with the same weights (`order` 1) is
    not, and even stamps make no difference between the two. Across a gap longer than the window
    nothing is averaged; a pose alone in its window stays.

    Args:
        trajectory: at any sampling.
        representation: what is averaged. Poses in one window must be less than half a turn from its
            centre for twists and rotation vectors to mean anything.
        sigma_s: standard deviation in seconds. Motion of frequency f is damped to
            ``exp(-½ (2π f sigma_s)²)``: to half at 0.187 / sigma_s Hz.
        truncate: standard deviations at which the window ends, on both sides and inclusively;
            at most 8.
        order: 1 line, 0 plain mean (Nadaraya and Watson's), up to 5.

    Raises:
        ValueError: sigma_s not positive, truncate outside 0 to 8, or an order outside 0 to 5.

    Source: local regression as W. S. Cleveland, JASA 74 (1979), with Gaussian weights.
    """
    sigma = checked_positive(sigma_s, "sigma_s", "seconds")
    if not 0.0 < truncate <= _FARTHEST:
        raise ValueError(f"truncate: expected above 0 and at most {_FARTHEST:g}, got {truncate}")
    reach_ns = round(truncate * sigma * 1e9)
    degree = checked_order(order)
    time_ns = trajectory.time_ns
    first = np.searchsorted(time_ns, time_ns - reach_ns, side="left")
    last = np.searchsorted(time_ns, time_ns + reach_ns, side="right")

    def weights(offset_s: FloatArray, inside: NDArray[np.bool_]) -> FloatArray:
        u = offset_s * (1.0 / sigma)
        weight = np.exp(-0.5 * u * u)
        weight *= inside
        return polynomial_at_centre(u, weight, inside, degree)

    return averaged(trajectory, representation, first, last, weights)
