"""Plots of trajectories, errors and times, in one house style."""

from motorcade.render.plots.calibrations import plot_allan, plot_coverage
from motorcade.render.plots.errors import (
    Band,
    ErrorsAlong,
    plot_bands,
    plot_errors_along,
    plot_series,
    plot_squares,
    plot_within_sigma,
)
from motorcade.render.plots.style import standing_alone
from motorcade.render.plots.trajectories import (
    plot_path_3d,
    plot_paths,
    plot_plan_and_elevation,
    plot_rotation_and_twist,
)

__all__ = [
    "Band",
    "ErrorsAlong",
    "plot_allan",
    "plot_bands",
    "plot_coverage",
    "plot_errors_along",
    "plot_path_3d",
    "plot_paths",
    "plot_plan_and_elevation",
    "plot_rotation_and_twist",
    "plot_series",
    "plot_squares",
    "plot_within_sigma",
    "standing_alone",
]
