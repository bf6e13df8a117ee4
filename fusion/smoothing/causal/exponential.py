"""The exponential filter: a first-order low-pass, exact in time."""

from __future__ import annotations

from motorcade.fusion.smoothing.causal.stream import CausalFilter
from motorcade.fusion.smoothing.causal.whole_path import FilterMethod
from motorcade.fusion.smoothing.native import _scans
from motorcade.ga.arrays import checked_positive

__all__ = ["Exponential", "exponential"]


class Exponential(CausalFilter):
    """Move towards each pose by the share ``1 - exp(-2π cutoff_hz dt)`` of the way.

    A steady motion is followed with a lag of about ``1 / (2π cutoff_hz)`` seconds. On motors and
    similarities neither the choice of world nor of body changes the result.

    Args:
        cutoff_hz: frequency that is damped to 0.71. It must lie below half the sampling rate,
            which only a whole trajectory tells: `smooth` refuses it, `update` does not.
        representation: a name of `REPRESENTATIONS`.

    Raises:
        ValueError: a cut-off that is not positive, or an unknown representation.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import Exponential
        >>> world_T_camera = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> live = Exponential(cutoff_hz=2.0)
        >>> for pose, time_ns in zip(world_T_camera.motors, world_T_camera.time_ns, strict=True):
        ...     smoothed = live.update(pose, int(time_ns))
        >>> behind = smoothed.inverse() @ world_T_camera.motors[-1]
        >>> print(f"{100.0 * abs(behind.translation_m).max():.1f} cm behind")
        4.5 cm behind
    """

    _cutoffs_hz = ("cutoff_hz",)

    def __init__(self, cutoff_hz: float = 4.0, representation: str = "motor") -> None:
        self.cutoff_hz = checked_positive(cutoff_hz, "cutoff_hz", "Hz")
        super().__init__(representation)

    def _scan(self, scale: bool) -> _scans.Scan:
        return _scans.exponential(self.representation, scale, self.cutoff_hz)


exponential = FilterMethod(Exponential)
"""`Exponential` over a whole trajectory."""
