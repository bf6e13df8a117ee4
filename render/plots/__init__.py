"""Plots of trajectories and errors as SVG, in one house style."""

from motorcade.render.plots.coverage import plot_coverage
from motorcade.render.plots.errors import plot_series
from motorcade.render.plots.trajectories import plot_plan_and_elevation

__all__ = ["plot_coverage", "plot_plan_and_elevation", "plot_series"]
