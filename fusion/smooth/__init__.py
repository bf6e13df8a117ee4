"""Smoothing of trajectories: one method, run on any representation of the poses."""

from motorcade.fusion.smooth.local_polynomial import smooth
from motorcade.fusion.smooth.representations import REPRESENTATIONS, Representation

__all__ = ["REPRESENTATIONS", "Representation", "smooth"]
