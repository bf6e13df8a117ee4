"""Smoothers that average over a window of time around every pose: no lag, no memory, no model."""

from __future__ import annotations

from motorcade.fusion.smoothing.window.automatic import automatic_window_s
from motorcade.fusion.smoothing.window.gaussian import gaussian
from motorcade.fusion.smoothing.window.local_polynomial import (
    local_polynomial,
    savitzky_golay,
    white_noise_removed,
)

__all__ = [
    "automatic_window_s",
    "gaussian",
    "local_polynomial",
    "savitzky_golay",
    "white_noise_removed",
]
