"""Smoothing of trajectories: every method, run on any representation of the poses.

Poses are ``world_T_camera`` at integer nanoseconds, evenly spaced or not; results have the same
stamps and frames. Parameters are physical: metres, radians, seconds, hertz. Deviations and
densities are those of one axis. Rotation errors and rates stand in the moving frame.

`smooth` runs a method of `METHODS` on a whole path, by default the one that `choose` picks, and
with ``full=True`` tells what is known of the result, a `SmoothingResult`; filters such as
`OneEuro` take poses one after another, and `LiveSmoother` does so with nothing to tune.
`Representation` says what is averaged.
"""

from __future__ import annotations

from motorcade.fusion.smoothing.auto import choose, smoothed_automatically
from motorcade.fusion.smoothing.causal import (
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    OneEuro,
)
from motorcade.fusion.smoothing.curve import PathCurve
from motorcade.fusion.smoothing.live import LiveSmoother
from motorcade.fusion.smoothing.methods import METHODS, method_parameters, smooth
from motorcade.fusion.smoothing.representations import (
    REPRESENTATION_NAMES,
    REPRESENTATIONS,
    Representation,
)
from motorcade.fusion.smoothing.results import SmoothingResult
from motorcade.fusion.smoothing.window import automatic_window_s

__all__ = [
    "METHODS",
    "REPRESENTATIONS",
    "REPRESENTATION_NAMES",
    "ConstantAccelerationFilter",
    "ConstantVelocityFilter",
    "LiveSmoother",
    "OneEuro",
    "PathCurve",
    "Representation",
    "SmoothingResult",
    "automatic_window_s",
    "choose",
    "method_parameters",
    "smooth",
    "smoothed_automatically",
]
