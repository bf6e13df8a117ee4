"""Smoothing of trajectories: one method, run on any representation of the poses."""

from motorcade.fusion.smooth.local_polynomial import smooth
from motorcade.fusion.smooth.representations import REPRESENTATIONS, Representation
from motorcade.fusion.smooth.windows import automatic_window_s

__all__ = ["REPRESENTATIONS", "Representation", "automatic_window_s", "smooth"]
