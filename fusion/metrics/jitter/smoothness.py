"""How smooth a movement is in itself: log dimensionless jerk, of translation and of rotation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics.jitter.jitter import accelerations
from motorcade.fusion.metrics.smooth_path import NotObservableError
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

__all__ = ["Smoothness", "log_dimensionless_jerk"]

# Changes from pose to pose below this part of the values may be rounding.
_ROUNDING = 64.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Smoothness:
    """Log dimensionless jerk, nearer to zero is smoother; None where a
    speed, or its change, is no more than rounding.

    Examples:
        >>> from motorcade.fusion.metrics import log_dimensionless_jerk
        >>> from motorcade.fusion.motions import stop_and_go
        >>> round(log_dimensionless_jerk(stop_and_go().sampled(100.0, 1.2)).linear, 2)  # one move
        -5.47
    """

    linear: float | None
    angular: float | None


def log_dimensionless_jerk(trajectory: Trajectory) -> Smoothness:
    """``-ln(T³ / v_peak² ∫ |d²v/dt²|² dt)``, of the velocity and of the angular rate.

    Velocity is that of the origin in the world, angular rate that of the moving frame in its own
    axes; both and their derivatives are differences at the stamps as they are, even or not. Of a
    minimum-jerk movement it is -ln 204.8 = -5.32. Noise makes it fall as the rate rises: compare
    trajectories at the same stamps, or an estimate with its truth.

    Source: Balasubramanian, Melendez-Calderon, Burdet, A robust and sensitive metric for
    quantifying movement smoothness, IEEE TBME 59(8), 2012; for vectors, Balasubramanian,
    Melendez-Calderon, Roby-Brami, Burdet, On the analysis of movement smoothness, J.
    NeuroEngineering and Rehabilitation 12:112, 2015 (LDLJ-V).

    Raises:
        NotObservableError: fewer than five poses.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import log_dimensionless_jerk
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> [round(log_dimensionless_jerk(path).linear, 1) for path in (true, noisy)]
        [-11.9, -19.4]
    """
    if len(trajectory) < 5:
        raise NotObservableError(
            f"log dimensionless jerk: expected 5 or more poses, got {len(trajectory)}"
        )
    time_s, poses = trajectory.time_s, trajectory.motors
    steps = np.diff(time_s)[:, None]
    velocity = np.diff(poses.translation_m, axis=0) / steps
    rate = _turns(poses) / steps
    linear, angular = accelerations(time_s, poses)
    size_m = float(np.max(np.abs(poses.translation_m)))
    return Smoothness(_score(time_s, velocity, linear, size_m), _score(time_s, rate, angular, 1.0))


def _turns(poses: Motor) -> FloatArray:
    return (poses[:-1].rotor.inverse() @ poses[1:].rotor).as_rotation_vector()


def _score(
    time_s: FloatArray, velocity: FloatArray, acceleration: FloatArray, size: float
) -> float | None:
    steps = np.diff(time_s)
    peak = float(np.max(np.linalg.norm(velocity, axis=-1)))
    inner = steps[1:-1]
    # Second differences belong to the means of their three stamps: exact for constant jerk.
    jerk = np.diff(acceleration, axis=0) / ((time_s[3:] - time_s[:-3]) / 3.0)[:, None]
    rounding = _ROUNDING * size / float(np.min(steps))
    least = rounding / float(np.min(steps)) ** 2
    if peak <= rounding or float(np.max(np.linalg.norm(jerk, axis=-1))) <= least:
        return None
    duration_s = float(time_s[-1] - time_s[0])
    # The first and last steps have no jerk of their own; the mean over the others stands for them.
    mean_square = float(np.sum(np.sum(jerk**2, axis=-1) * inner) / np.sum(inner))
    return -float(np.log(duration_s**4 / peak**2 * mean_square))
