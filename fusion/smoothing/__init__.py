"""Smoothing of trajectories: every method, run on any representation of the poses."""

from __future__ import annotations

from motorcade.fusion.smoothing.auto import SmootherChoice, choose
from motorcade.fusion.smoothing.batch import RobustPath, estimate_path
from motorcade.fusion.smoothing.causal import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    DoubleExponential,
    Exponential,
    OneEuro,
    SmoothedStates,
    smoothed_states,
)
from motorcade.fusion.smoothing.methods import METHODS, method_parameters, smooth
from motorcade.fusion.smoothing.representations import REPRESENTATIONS, Representation
from motorcade.fusion.smoothing.window import automatic_window_s

__all__ = [
    "METHODS",
    "REPRESENTATIONS",
    "ConstantAccelerationFilter",
    "ConstantVelocityFilter",
    "DoubleExponential",
    "Exponential",
    "OneEuro",
    "Representation",
    "RobustPath",
    "SmoothedStates",
    "SmootherChoice",
    "automatic_window_s",
    "choose",
    "estimate_path",
    "method_parameters",
    "smooth",
    "smoothed_states",
]
