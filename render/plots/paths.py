"""Any named trajectories in one figure, as a file: path, axes, angles and speed over time."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render.plots.style import (
    HUES,
    PRINTED,
    house_style,
    numbered_style,
    plane_axes,
    thinned,
)

_POINTS = 5000


def plot_paths(
    trajectories: Mapping[str, Trajectory],
    reference: Trajectory | None = None,
    plane: str = "",
    form: str = "svg",
) -> bytes:
    """Draw trajectories of rigid poses, which should share their parent frame.

    Beside the path in a plane stand x, y and z, the turns about the fixed axes x, y and z (roll,
    pitch and yaw, without leaps), and the speed, over the seconds since the first stamp of all.

    Args:
        trajectories: by the names that the legend tells.
        reference: drawn in grey behind them.
        plane: two axes of the parent frame, "xy", "xz" or "yz"; where it is empty, those in which
            the first line goes farthest.
        form: "svg", "pdf" or "png".

    Returns:
        The content of a file.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.render.plots.paths import plot_paths
        >>> path = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=1.0)
        >>> plot_paths({"handheld": path})[:5]
        b'<?xml'
    """
    from matplotlib.figure import Figure

    lines = list(_lines(trajectories, reference))
    sides = plane_axes(plane, lines[0][0].motors.translation_m)
    start_ns = min(int(path.time_ns[0]) for path, _ in lines)
    with house_style(*PRINTED):
        figure = Figure(figsize=(12.0, 6.4))
        grid = figure.add_gridspec(3, 3, width_ratios=(1.5, 1.0, 1.0))
        above = figure.add_subplot(grid[:2, 0])
        speed = figure.add_subplot(grid[2, 0])
        panels = [figure.add_subplot(grid[row, column]) for column in (1, 2) for row in range(3)]
        for axes in (*panels[1:3], *panels[3:], speed):
            axes.sharex(panels[0])
        for path, style in lines:
            _draw_path(above, path, sides, style)
            _draw_over_time(panels, speed, path, start_ns, style)
        _label(above, sides, [*panels, speed])
        if len(lines) <= 12:
            above.legend(loc="best", fontsize=8.0)
        content = io.BytesIO()
        figure.savefig(content, format=form, dpi=150, metadata=_NO_DATES.get(form))
    return content.getvalue()


_NO_DATES: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
}


def _lines(
    trajectories: Mapping[str, Trajectory], reference: Trajectory | None
) -> Iterator[tuple[Trajectory, dict[str, Any]]]:
    """Path and style of each line, the reference first and so at the back."""
    if reference is not None:
        yield reference, {"label": "reference", "color": HUES["grey"][0], "linewidth": 1.8}
    for number, (name, path) in enumerate(trajectories.items()):
        yield path, numbered_style(name, number)


def _draw_path(axes: Any, path: Trajectory, sides: tuple[int, int], style: dict[str, Any]) -> None:
    """The path, with a dot where it begins."""
    place = path.motors.translation_m
    place = place[:: max(1, len(place) // _POINTS)]
    across, up = sides
    axes.plot(place[:, across], place[:, up], **style)
    axes.plot(place[0, across], place[0, up], "o", markersize=4.0, color=style["color"])


def _draw_over_time(
    panels: list[Any], speed: Any, path: Trajectory, start_ns: int, style: dict[str, Any]
) -> None:
    """Positions in the first three panels, angles in the others."""
    time_s = np.asarray((path.time_ns - start_ns) * 1e-9, np.float64)
    rotor = path.motors.rotor
    angles = np.rad2deg(np.unwrap(rotor.as_euler("zyx")[:, ::-1], axis=0))
    values = np.concatenate([path.motors.translation_m, angles], axis=1)
    for axes, column in zip(panels, values.T, strict=True):
        axes.plot(*thinned(time_s, column), **style)
    if len(path) > 1:
        speed.plot(*thinned(*_speeds(path, time_s)), **style)


def _speeds(path: Trajectory, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Middles of the steps in seconds and the speed there in m/s."""
    far = np.linalg.norm(np.diff(path.motors.translation_m, axis=0), axis=1)
    step_s = np.diff(path.time_ns) * 1e-9
    return time_s[:-1] + 0.5 * step_s, far / step_s


def _label(above: Any, sides: tuple[int, int], panels: list[Any]) -> None:
    above.set_aspect("equal", adjustable="datalim")
    above.set_xlabel(f"{'xyz'[sides[0]]} (m)")
    above.set_ylabel(f"{'xyz'[sides[1]]} (m)")
    names = ("x (m)", "y (m)", "z (m)", "roll (°)", "pitch (°)", "yaw (°)", "speed (m/s)")
    for axes, name in zip(panels, names, strict=True):
        axes.set_ylabel(name)
        axes.margins(x=0.01)
    for axes in (panels[2], panels[5], panels[6]):
        axes.set_xlabel("time (s)")
