"""Plots of trajectories and errors as SVG, in one house style."""

from motorcade.render.plots.allan import plot_allan
from motorcade.render.plots.coverage import plot_coverage
from motorcade.render.plots.errors import plot_series
from motorcade.render.plots.style import standing_alone
from motorcade.render.plots.trajectories import plot_plan_and_elevation

__all__ = [
    "plot_allan",
    "plot_coverage",
    "plot_plan_and_elevation",
    "plot_series",
    "standing_alone",
]
