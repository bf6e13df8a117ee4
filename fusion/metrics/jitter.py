"""How much a trajectory jitters: jitter, log dimensionless jerk, spectral energy.

Jitter is acceleration that the true motion does not have. With a ground truth it is the RMS of
(acceleration - true acceleration), angular and linear apart; without one, the RMS acceleration
above a stated frequency. Accelerations are second differences at the stamps as they are, even or
not: linear ones in the world, angular ones in the moving frame. The ground truth is differenced at
the same stamps, so the error of differencing cancels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.metrics.smooth_path import NotObservableError, SmoothPath, beside
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.stamps import near_steps

_EVEN_INTERVALS = 1.5
_SHORTEST_SPECTRUM = 16


@dataclass(frozen=True)
class Jitter:
    """RMS of the acceleration's length: `linear_m_s2` and `angular_rad_s2`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import jitter
        >>> from motorcade.fusion.motions import handheld
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=4.0)
        >>> found = jitter(true, true)
        >>> bool(found.linear_m_s2 < 1e-9)
        True
    """

    linear_m_s2: float
    angular_rad_s2: float


def accelerations(time_s: FloatArray, poses: Motor) -> tuple[FloatArray, FloatArray]:
    """Second differences at the inner stamps of poses ``(*, N)``, exact for constant acceleration.

    Returns:
        Linear acceleration in the world ``(*, N-2, 3)`` in m/s², and angular acceleration in the
        moving frame ``(*, N-2, 3)`` in rad/s² (steps must turn by less than π).

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import accelerations
        >>> from motorcade.ga import Motor
        >>> time_s = np.array([0.0, 0.1, 0.2, 0.4])
        >>> falling = Motor.from_translation(-0.5 * 9.81 * time_s[:, None] ** 2 * [0.0, 0.0, 1.0])
        >>> linear, angular = accelerations(time_s, falling)
        >>> linear[:, 2].round(6)
        array([-9.81, -9.81])
    """
    between = 0.5 * (time_s[2:] - time_s[:-2])[:, None]
    velocity, rate = rates(time_s, poses)
    return np.diff(velocity, axis=-2) / between, np.diff(rate, axis=-2) / between


def rates(time_s: FloatArray, poses: Motor) -> tuple[FloatArray, FloatArray]:
    """Velocity in the world, angular rate in the moving frame, ``(*, N-1, 3)``, pose to pose."""
    steps = np.diff(time_s)[:, None]
    turns = (poses[..., :-1].rotor.inverse() @ poses[..., 1:].rotor).as_rotation_vector()
    return np.diff(poses.translation_m, axis=-2) / steps, turns / steps


def jitter(estimate: Trajectory, truth: Trajectory) -> Jitter:
    """RMS of acceleration minus true acceleration, over the estimate's stamps.

    The trajectories must share their frames: align first where the worlds differ. Stamps in gaps
    of the ground truth, and differences across gaps of the estimate (more than three median
    intervals), are left out.

    Raises:
        NotObservableError: no three consecutive stamps of the estimate that the ground truth
            covers.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import jitter
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> found = jitter(noisy, true)
        >>> round(found.linear_m_s2), round(found.angular_rad_s2)
        (36, 71)
    """
    path = SmoothPath.through(truth)
    time_s = path.seconds(estimate.time_ns)
    usable = _whole_triples(time_s, path.covers(time_s))
    if not np.any(usable):
        raise NotObservableError(
            "jitter: expected three consecutive stamps of the estimate within the ground truth, "
            "got none"
        )
    first = int(np.argmax(usable))
    last = usable.size - int(np.argmax(usable[::-1])) + 2
    time_s, usable = time_s[first:last], usable[first : last - 2]
    ours = accelerations(time_s, estimate.motors[first:last])
    true = accelerations(time_s, path.poses(np.clip(time_s, *path.span_s)))
    linear, angular = (a[usable] - b[usable] for a, b in zip(ours, true, strict=True))
    return Jitter(_rms(linear), _rms(angular))


def jitter_above(trajectory: Trajectory, frequency_hz: float) -> Jitter:
    """RMS acceleration above `frequency_hz`, where no ground truth is at hand.

    Segments without gaps are brought to an even rate and the power of their periodograms
    (straight line removed, Hann window) above the frequency is summed; longer segments weigh
    more. Real motion above the frequency counts as jitter too, so choose it above the motion.

    Raises:
        ValueError: a frequency that is not positive or not below half the sampling rate.
        NotObservableError: no segment of 16 poses without a gap.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import jitter_above
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> round(jitter_above(noisy, frequency_hz=5.0).linear_m_s2)
        37
        >>> round(jitter_above(true, frequency_hz=5.0).linear_m_s2)
        0
    """
    time_s = trajectory.time_s
    interval = float(np.median(np.diff(time_s))) if time_s.size > 1 else np.inf
    if not 0.0 < frequency_hz < 0.5 / interval:
        raise ValueError(
            f"frequency_hz: expected above 0 and below half the rate ({0.5 / interval:.3f} Hz), "
            f"got {frequency_hz}"
        )
    cuts = np.flatnonzero(np.diff(time_s) > _EVEN_INTERVALS * interval) + 1
    power, weight = np.zeros(2), 0
    for segment in np.split(np.arange(time_s.size), cuts):
        if segment.size < _SHORTEST_SPECTRUM:
            continue
        times = time_s[segment]
        both = accelerations(times, trajectory.motors[segment])
        even_s = np.arange(times[1], times[-2] + 1e-3 * interval, interval)
        for i, series in enumerate(both):
            power[i] += even_s.size * _power_above(times[1:-1], series, even_s, frequency_hz)
        weight += even_s.size
    if weight == 0:
        raise NotObservableError(
            f"jitter: expected a segment of {_SHORTEST_SPECTRUM} poses without a gap, got none"
        )
    linear, angular = np.sqrt(power / weight)
    return Jitter(float(linear), float(angular))


def _whole_triples(time_s: FloatArray, covered: NDArray[np.bool_]) -> NDArray[np.bool_]:
    if time_s.size < 3:
        return np.zeros(0, dtype=np.bool_)
    steps = np.diff(time_s)
    near = near_steps(steps)
    return np.asarray(covered[:-2] & covered[1:-1] & covered[2:] & near[:-1] & near[1:])


def _power_above(
    time_s: FloatArray, series: FloatArray, even_s: FloatArray, frequency_hz: float
) -> float:
    """Mean square of ``series (N, 3)`` above the frequency, summed over its components.

    It is what `scipy.signal.periodogram` gives of what `detrend` leaves, without loading all of
    that package for it, which takes longer than everything else that an evaluation does.
    """
    even = np.stack([np.interp(even_s, time_s, column) for column in series.T], axis=-1)
    count = len(even_s)
    line = np.stack([np.ones(count), np.linspace(-1.0, 1.0, count)], axis=-1)
    level = even - line @ np.linalg.lstsq(line, even)[0]
    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
    power = np.sum(np.abs(np.fft.rfft(hann[:, None] * level, axis=0)) ** 2, axis=-1)
    # One side of the spectrum stands for both, apart from its ends where they have no twin.
    power[1 : (count + 1) // 2] *= 2.0
    frequencies = np.fft.rfftfreq(count, even_s[1] - even_s[0])
    return float(np.sum(power[frequencies >= frequency_hz]) / (count * np.sum(hann**2)))


def _rms(vectors: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=-1))))


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
    trajectories at the same stamps, or an estimate with its ground truth.

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
    velocity, rate = rates(time_s, poses)
    linear, angular = accelerations(time_s, poses)
    size_m = float(np.max(np.abs(poses.translation_m)))
    return Smoothness(_score(time_s, velocity, linear, size_m), _score(time_s, rate, angular, 1.0))


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


@dataclass(frozen=True)
class EnergyExcess:
    """Mean square acceleration above a frequency, the estimate's less the ground truth's.

    Zero for a perfect estimate, below zero where smoothing took away true motion.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import energy_excess_above
        >>> from motorcade.fusion.motions import handheld
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=4.0)
        >>> found = energy_excess_above(true, true, frequency_hz=5.0)
        >>> bool(abs(found.linear_m2_s4) < 1e-9)
        True
    """

    linear_m2_s4: float
    angular_rad2_s4: float


def energy_excess_above(
    estimate: Trajectory, truth: Trajectory, frequency_hz: float
) -> EnergyExcess:
    """Power of the acceleration above `frequency_hz`, integrated, as excess over the ground truth.

    Both are differenced at the estimate's stamps within the ground truth, and their periodograms
    (see `jitter_above`) are summed above the frequency. Unlike jitter it is blind to phase: what is
    smooth but late or wrong has no excess. The measure is that of vibration analysis, the band
    power of a one-sided spectral density (P. D. Welch, The use of fast Fourier transform for the
    estimation of power spectra, IEEE Trans. Audio Electroacoustics 15(2), 1967).

    Raises:
        ValueError: a frequency that is not positive or not below half the sampling rate.
        NotObservableError: no segment of 16 poses without a gap within the ground truth.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import energy_excess_above
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> round(energy_excess_above(noisy, true, frequency_hz=5.0).linear_m2_s4)
        1350
    """
    first, second = (
        jitter_above(path, frequency_hz) for path in beside(estimate, truth, 2, "spectral energy")
    )
    return EnergyExcess(
        first.linear_m_s2**2 - second.linear_m_s2**2,
        first.angular_rad_s2**2 - second.angular_rad_s2**2,
    )
