"""Double exponential smoothing: a level and its trend, each with a cut-off of its own."""

from __future__ import annotations

from motorcade.fusion.smoothing.causal.stream import CausalFilter
from motorcade.fusion.smoothing.causal.whole_path import FilterMethod
from motorcade.fusion.smoothing.native import _scans
from motorcade.ga.arrays import checked_positive

__all__ = ["DoubleExponential", "double_exponential"]


class DoubleExponential(CausalFilter):
    """Extrapolate the level along the trend, correct it, and let the trend follow the level.

    C. C. Holt's linear method (1957; Int. J. of Forecasting 20, 2004) by time instead of index:
    the level takes the share ``1 - exp(-2π cutoff_hz dt)`` of the innovation, the trend the share
    ``1 - exp(-2π trend_cutoff_hz dt)`` of what the level has just done. A steady motion is followed
    without lag; after a sudden stop the level overshoots by about the speed over
    ``2π trend_cutoff_hz``, and after a gap the trend has run on through it.

    Args:
        cutoff_hz: of the level. Like the other it must lie below half the sampling rate, which only
            a whole trajectory tells: `smooth` refuses it, `update` does not.
        trend_cutoff_hz: of the trend; lower than the level's, or the filter rings.
        representation: a name of `REPRESENTATIONS`.

    Raises:
        ValueError: a cut-off that is not positive, or an unknown representation.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import DoubleExponential
        >>> world_T_camera = screw().sampled(rate_hz=30.0, duration_s=2.0)
        >>> live = DoubleExponential(cutoff_hz=2.0)
        >>> for pose, time_ns in zip(world_T_camera.motors, world_T_camera.time_ns, strict=True):
        ...     smoothed = live.update(pose, int(time_ns))
        >>> behind = smoothed.inverse() @ world_T_camera.motors[-1]
        >>> print(f"{100.0 * abs(behind.translation_m).max():.1f} cm behind")
        0.0 cm behind
    """

    _cutoffs_hz = ("cutoff_hz", "trend_cutoff_hz")

    def __init__(
        self, cutoff_hz: float = 4.0, trend_cutoff_hz: float = 1.0, representation: str = "motor"
    ) -> None:
        self.cutoff_hz = checked_positive(cutoff_hz, "cutoff_hz", "Hz")
        self.trend_cutoff_hz = checked_positive(trend_cutoff_hz, "trend_cutoff_hz", "Hz")
        super().__init__(representation)

    def _scan(self, scale: bool) -> _scans.Scan:
        return _scans.double_exponential(
            self.representation, scale, self.cutoff_hz, self.trend_cutoff_hz
        )


double_exponential = FilterMethod(DoubleExponential)
"""`DoubleExponential` over a whole trajectory."""
