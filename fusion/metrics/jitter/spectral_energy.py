"""Spectral energy above a cut-off that the ground truth does not have, or has and was lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics.jitter.jitter import jitter_above
from motorcade.fusion.metrics.smooth_path import NotObservableError, SmoothPath
from motorcade.ga import Trajectory

__all__ = ["EnergyExcess", "energy_excess_above"]


@dataclass(frozen=True)
class EnergyExcess:
    """Mean square acceleration above a frequency, the estimate's less the truth's.

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
    """Power of the acceleration above `frequency_hz`, integrated, as excess over the truth.

    Both are differenced at the estimate's stamps within the truth, and their periodograms (see
    `jitter_above`) are summed above the frequency. Unlike jitter it is blind to phase: what is
    smooth but late or wrong has no excess. The measure is that of vibration analysis, the band
    power of a one-sided spectral density (P. D. Welch, The use of fast Fourier transform for the
    estimation of power spectra, IEEE Trans. Audio Electroacoustics 15(2), 1967).

    Raises:
        ValueError: a frequency that is not positive or not below half the sampling rate.
        NotObservableError: no stretch of 16 poses without a gap within the truth.

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
    path = SmoothPath.through(truth)
    time_s = path.seconds(estimate.time_ns)
    kept = np.flatnonzero(path.covers(time_s))
    if kept.size < 2:
        raise NotObservableError(
            f"spectral energy: expected 2 or more stamps within the truth, got {kept.size}"
        )
    ours = estimate[kept]
    true = Trajectory(ours.time_ns, path.poses(time_s[kept]), truth.parent, truth.child)
    first, second = jitter_above(ours, frequency_hz), jitter_above(true, frequency_hz)
    return EnergyExcess(
        first.linear_m_s2**2 - second.linear_m_s2**2,
        first.angular_rad_s2**2 - second.angular_rad_s2**2,
    )
