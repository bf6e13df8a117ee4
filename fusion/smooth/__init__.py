"""Smoothing of trajectories: every method, run on any representation of the poses."""

from __future__ import annotations

from motorcade.fusion.smooth.auto import Choice, choose
from motorcade.fusion.smooth.batch import RobustPath, estimate_path
from motorcade.fusion.smooth.causal import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    DoubleExponential,
    Exponential,
    OneEuro,
    SmoothedStates,
    smoothed_states,
)
from motorcade.fusion.smooth.representations import REPRESENTATIONS, Representation
from motorcade.fusion.smooth.smooth import METHODS, method_parameters, smooth
from motorcade.fusion.smooth.window import automatic_window_s

__all__ = [
    "METHODS",
    "REPRESENTATIONS",
    "Choice",
    "ConstantAccelerationFilter",
    "ConstantVelocityFilter",
    "DoubleExponential",
    "Exponential",
    "OneEuro",
    "Representation",
    "RobustPath",
    "SmoothedStates",
    "automatic_window_s",
    "choose",
    "estimate_path",
    "method_parameters",
    "smooth",
    "smoothed_states",
]
