"""Paths of the camera seen from above and from the side, metres, equal scales, z up."""

from __future__ import annotations

from collections.abc import Mapping

from motorcade.ga import Trajectory
from motorcade.render.plots.style import as_svg, house_style, line_style, new_figure


def plot_plan_and_elevation(trajectories: Mapping[str, Trajectory]) -> str:
    """Plan (x, y) and elevation (x, z) of named trajectories, as an `<svg>` element.

    Names are those of `style.COLOURS`; all trajectories must share their parent frame.
    """
    with house_style():
        figure, (plan, elevation) = new_figure(9.0, 3.6, columns=2)
        for axes, (across, up), title in (
            (plan, (0, 1), "plan"),
            (elevation, (0, 2), "elevation"),
        ):
            for name, trajectory in trajectories.items():
                position = trajectory.poses.translation_m
                axes.plot(position[:, across], position[:, up], **line_style(name))
            axes.set_aspect("equal", adjustable="datalim")
            axes.set_title(title)
            axes.set_xlabel(f"{'xyz'[across]} (m)")
            axes.set_ylabel(f"{'xyz'[up]} (m)")
        plan.legend(loc="best", fontsize=8)
        return as_svg(figure)
