"""The 1€ filter: a low-pass that opens with the speed, still at rest and quick in motion."""

from __future__ import annotations

from math import isfinite

from motorcade.fusion.smoothing.causal.stream import CausalFilter
from motorcade.fusion.smoothing.causal.whole_path import FilterMethod
from motorcade.fusion.smoothing.native import _scans
from motorcade.ga.arrays import checked_positive

__all__ = ["OneEuro", "one_euro"]


class OneEuro(CausalFilter):
    """A first-order low-pass of cut-off ``min_cutoff_hz + beta · speed``, for each block.

    G. Casiez, N. Roussel, D. Vogel, 1€ filter: a simple speed-based low-pass filter for noisy input
    in interactive systems, CHI 2012, with its shares ``1 / (1 + 1 / (2π f dt))`` and its speed: the
    low-passed difference between the pose that comes and the filtered one before, over dt.
    Rotation, translation and scale each have a cut-off of their own, from the length of their part
    of the speed where the paper takes each coordinate for itself: axes would show otherwise.
    Where the speed hardly changes the cut-off hardly does, and nothing is gained on the exponential
    filter: behind someone who walks at an even pace it lags as far at equal jitter, where stops and
    turns come it lags a quarter to a half as far (`make bench SUITE=lag`).
    Choosing another world does not change the result on motors; choosing another origin in the
    body does, since it moves at another speed.

    Args:
        min_cutoff_hz: cut-off at rest.
        beta_per_rad: cut-off that is gained for a rotation of 1 rad/s, in Hz.
        beta_per_m: the same for a translation of 1 m/s.
        beta_scale: the same for a growth of 1 a second, of the scale's logarithm where the
            representation is "similarity"; rigid poses have none.
        derivative_cutoff_hz: cut-off of the speed's low-pass. This and `min_cutoff_hz` must lie
            below half the sampling rate, which only a whole trajectory tells: `smooth` refuses
            them, `update` does not.
        representation: a name of `REPRESENTATIONS`.

    Raises:
        ValueError: a cut-off that is not positive, a beta that is negative, or an unknown
            representation.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import OneEuro
        >>> world_T_camera = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> live = OneEuro(min_cutoff_hz=1.0)
        >>> for pose, time_ns in zip(world_T_camera.motors, world_T_camera.time_ns, strict=True):
        ...     smoothed = live.update(pose, int(time_ns))
        >>> behind = smoothed.inverse() @ world_T_camera.motors[-1]
        >>> print(f"{100.0 * abs(behind.translation_m).max():.1f} cm behind")
        1.0 cm behind
    """

    _cutoffs_hz = ("min_cutoff_hz", "derivative_cutoff_hz")

    def __init__(
        self,
        min_cutoff_hz: float = 0.5,
        beta_per_rad: float = 10.0,
        beta_per_m: float = 10.0,
        beta_scale: float = 10.0,
        derivative_cutoff_hz: float = 2.0,
        representation: str = "motor",
    ) -> None:
        self.min_cutoff_hz = checked_positive(min_cutoff_hz, "min_cutoff_hz", "Hz")
        self.beta_per_rad = _checked_beta(beta_per_rad, "beta_per_rad")
        self.beta_per_m = _checked_beta(beta_per_m, "beta_per_m")
        self.beta_scale = _checked_beta(beta_scale, "beta_scale")
        self.derivative_cutoff_hz = checked_positive(
            derivative_cutoff_hz, "derivative_cutoff_hz", "Hz"
        )
        super().__init__(representation)

    def _scan(self, scale: bool) -> _scans.Scan:
        slopes = (self.beta_per_rad, self.beta_per_m, self.beta_scale)
        return _scans.one_euro(
            self.representation, scale, self.min_cutoff_hz, slopes, self.derivative_cutoff_hz
        )


def _checked_beta(value: float, name: str) -> float:
    if not (isfinite(value) and value >= 0.0):
        raise ValueError(f"{name}: expected a number of at least 0, got {value}")
    return float(value)


one_euro = FilterMethod(OneEuro)
"""`OneEuro` over a whole trajectory."""
