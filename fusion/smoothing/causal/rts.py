"""The Rauch-Tung-Striebel smoother: a Kalman filter forward, its estimates corrected backward.

H. E. Rauch, F. Tung, C. T. Striebel, Maximum likelihood estimates of linear dynamic systems,
AIAA J. 3 (1965). Every pose is told by all others, so there is no lag. The model, its noise and
where it breaks down are those of the filters in `motorcade.fusion.smoothing.causal.kalman`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.smoothing.causal.kalman import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    KalmanFilter,
)
from motorcade.fusion.smoothing.causal.stream import coefficients_of, trajectory_of
from motorcade.fusion.smoothing.causal.whole_path import FilterMethod
from motorcade.fusion.smoothing.native import _scans
from motorcade.ga import Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

__all__ = [
    "SmoothedStates",
    "rts_constant_acceleration",
    "rts_constant_velocity",
    "smoothed_states",
]


@dataclass(frozen=True, eq=False)
class SmoothedStates:
    """What the smoother knows of every pose.

    Fields:
        trajectory: the smoothed poses.
        rates: ``(N, order, d)`` velocity, and acceleration where it is estimated, in the
            representation's vectors: of motors the body twist (rad/s, m/s) and its derivative.
        deviations: ``(N, blocks, order + 1)`` standard deviations of pose, velocity and
            acceleration, an axis: of rotation (rad), translation (m) and, of similarities, scale.
        log_likelihood: of the innovations, see `KalmanFilter.log_likelihood`.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import ConstantVelocityFilter, smoothed_states
        >>> found = smoothed_states(screw().sampled(30.0, 2.0), ConstantVelocityFilter())
        >>> found.rates[30, 0].round(2)  # rad/s, then m/s
        array([ 0.  , -1.  ,  0.  ,  0.  , -0.08,  0.7 ])
    """

    trajectory: Trajectory
    rates: FloatArray
    deviations: FloatArray
    log_likelihood: float


def smoothed_states(trajectory: Trajectory, model: KalmanFilter) -> SmoothedStates:
    """Smooth a trajectory by a filter's model and noise; the filter's own stream goes on untouched.

    Memory is below 1 KiB a pose; time is linear.

    Raises:
        ValueError: noise for another number of poses, or a result beyond float64.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion.smoothing import ConstantVelocityFilter, smoothed_states
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> found = smoothed_states(noisy, ConstantVelocityFilter(noise_m=0.01, noise_rad=0.02))
        >>> found.rates.shape  # body twists
        (121, 1, 6)
        >>> position_m = found.deviations[60, 1, 0]
        >>> print(f"the middle position is known to {1e3 * position_m:.1f} mm an axis")
        the middle position is known to 5.3 mm an axis
    """
    scale = isinstance(trajectory.poses, Similarity)
    given, count = coefficients_of(trajectory), len(trajectory)
    ends, _, _ = _scans.layout(model.representation, scale)
    out, rates = np.empty_like(given), np.empty((count, model.order, ends[-1]))
    deviations = np.empty((count, len(ends), model.order + 1))
    log_likelihood = _scans.rts(
        model.representation,
        scale,
        model.order,
        given,
        trajectory.time_ns,
        model.noise_of(trajectory),
        model.densities,
        out,
        (rates, deviations),
    )
    for array in (rates, deviations):
        array.setflags(write=False)
    return SmoothedStates(trajectory_of(trajectory, out), rates, deviations, log_likelihood)


def _smoothed(trajectory: Trajectory, model: KalmanFilter) -> Trajectory:
    """The poses alone, in half the time."""
    given = coefficients_of(trajectory)
    out = np.empty_like(given)
    _scans.rts(
        model.representation,
        isinstance(trajectory.poses, Similarity),
        model.order,
        given,
        trajectory.time_ns,
        model.noise_of(trajectory),
        model.densities,
        out,
    )
    return trajectory_of(trajectory, out)


rts_constant_velocity = FilterMethod(ConstantVelocityFilter, _smoothed)
"""Smoother of a velocity that white acceleration changes; see `ConstantVelocityFilter`."""


rts_constant_acceleration = FilterMethod(ConstantAccelerationFilter, _smoothed)
"""Smoother of an acceleration that white jerk changes; see `ConstantAccelerationFilter`."""
