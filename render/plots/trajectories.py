"""Paths of the camera in space, z up: from above, from the side, in three dimensions; and turns.

Any named trajectories in one figure, as a file: path, axes, angles and speed over time.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render.plots.style import (
    AXIS_COLOURS,
    GRID,
    HUES,
    PRINTED,
    WIDTH_IN,
    as_svg,
    house_style,
    line_style,
    new_figure,
    numbered_style,
    plane_axes,
    thinned,
)

# Corners of a camera's image and its centre, in the camera's axes, for a size of 1.
_PYRAMID = np.array(
    [[-0.6, -0.45, 1.0], [0.6, -0.45, 1.0], [0.6, 0.45, 1.0], [-0.6, 0.45, 1.0], [0.0, 0.0, 0.0]]
)
_EDGES = (0, 1, 2, 3, 0, 4, 1, 2, 4, 3)
_CAMERAS = 9


def plot_plan_and_elevation(trajectories: Mapping[str, Trajectory], unit: str = "m") -> str:
    """Plan (x, y) and elevation (z over the longer of x and y) of named trajectories: an `<svg>`.

    Names are those of `style.COLOURS`; all trajectories must share their parent frame. Scales are
    equal; lengths are in `unit`; the legend is left to the page.
    """
    paths = {name: one.poses.translation_m for name, one in trajectories.items()}
    along = int(np.argmax(np.ptp(np.concatenate(list(paths.values())), axis=0)[:2]))
    with house_style():
        figure, panels = new_figure(WIDTH_IN, 2.9, columns=2)
        for axes, across, up, title in zip(
            panels, (0, along), (1, 2), ("from above", "from the side"), strict=True
        ):
            for name, path in paths.items():
                axes.plot(path[:, across], path[:, up], **line_style(name))
            axes.set_aspect("equal", adjustable="datalim")
            axes.set_title(title)
            axes.set_xlabel(f"{'xyz'[across]} ({unit})")
            axes.set_ylabel(f"{'xyz'[up]} ({unit})")
            axes.locator_params(nbins=4)
        return as_svg(figure, "paths from above and from the side")


def plot_path_3d(trajectories: Mapping[str, Trajectory], unit: str = "m") -> str:
    """Named trajectories in three dimensions, with cameras along the first, as an `<svg>` element.

    Names are those of `style.COLOURS`; all trajectories must share their parent frame. Scales are
    equal, z is up, without perspective. Cameras are pyramids that open where they look, at even
    steps in time. Beneath each path lies its shadow on the lowest plane. All of it lies within the
    axes, whose lengths are in `unit`; the legend is left to the page.
    """
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d import Axes3D

    paths = {name: one.poses.translation_m for name, one in trajectories.items()}
    with house_style():
        figure = Figure(figsize=(WIDTH_IN, 3.5))
        figure.set_layout_engine("none")
        axes = figure.add_axes((0.02, 0.02, 0.94, 0.98), projection="3d", proj_type="ortho")
        assert isinstance(axes, Axes3D)
        name, first = next(iter(trajectories.items()))
        low, high = _cube(np.concatenate(list(paths.values())))
        cameras = _pyramids(first, 0.09 * float(np.max(high - low)))
        low, high = np.minimum(low, cameras.min((0, 1))), np.maximum(high, cameras.max((0, 1)))
        for corners in cameras:
            axes.plot(*corners.T, color=line_style(name)["color"], linewidth=0.8, clip_on=False)
        for name, path in paths.items():
            axes.plot(*path.T, **line_style(name), clip_on=False)
            shadow = {"linewidth": 0.8, "alpha": 0.25, "zorder": 1.0, "label": None}
            axes.plot(path[:, 0], path[:, 1], low[2], **(line_style(name) | shadow), clip_on=False)
        _furnish(axes, low, high, unit)
        _fit(axes, high - low)
        return as_svg(figure, "paths in three dimensions")


def _cube(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ends of axes about the points, with a margin, none below a third of the longest."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    reach = 0.5 * np.ptp(points, axis=0)
    reach = np.maximum(1.15 * reach, max(float(reach.max()) / 3.0, 1e-6))
    return middle - reach, middle + reach


def _pyramids(path: Trajectory, size_m: float) -> FloatArray:
    """Outlines ``(C, 10, 3)`` of cameras at even steps in time."""
    rows = np.unique(np.linspace(0, len(path) - 1, _CAMERAS).round().astype(int))
    corners: FloatArray = path.poses[rows].rigid.reshape(-1, 1).apply(size_m * _PYRAMID)
    return corners[:, _EDGES]


def _furnish(axes: Any, low: FloatArray, high: FloatArray, unit: str) -> None:
    """Equal scales, quiet walls, and a view from above and aside."""
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.view_init(elev=24.0, azim=-58.0)
    for name, axis, size in zip(
        "xyz", (axes.xaxis, axes.yaxis, axes.zaxis), high - low, strict=True
    ):
        axis.set_pane_color((0.0, 0.0, 0.0, 0.0))
        axis.line.set_color(GRID)
        axis._axinfo["grid"].update(color=GRID, linewidth=0.6)
        axis.set_label_text(f"{name} ({unit})")
        axis.set_major_locator(_few(4 if size > 0.4 * float(np.max(high - low)) else 2))
    axes.tick_params(labelsize=9, pad=0)


def _fit(axes: Any, size: FloatArray) -> None:
    """As large as the figure holds, with ticks and labels; thrice, for these keep their own size.

    What the image takes is then set into the middle of the figure.
    """
    page, zoom = np.array(axes.figure.bbox.size), 1.0
    axes.set_box_aspect(size, zoom=zoom)
    for _ in range(3):
        low, high = _taken(axes)
        zoom *= 0.97 * float(np.min(page / (high - low)))
        axes.set_box_aspect(size, zoom=zoom)
    low, high = _taken(axes)
    place = axes.get_position()
    across, up = 0.5 - 0.5 * (low + high) / page
    axes.set_position((place.x0 + across, place.y0 + up, place.width, place.height))


def _taken(axes: Any) -> tuple[FloatArray, FloatArray]:
    """Corners of what lines, ticks and labels take on the page; not of the axes' empty ground."""
    axes.figure.draw_without_rendering()
    drawn = [*axes.lines, axes.xaxis, axes.yaxis, axes.zaxis]
    boxes = np.array([one.get_tightbbox().extents for one in drawn])
    return boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)


def _few(most: int) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(most)


def rotation_vectors_rad(path: Trajectory) -> FloatArray:
    """Rotation vectors ``(N, 3)`` of a path from its first pose on.

    A turn of θ about an axis is also one of θ - 2π: at each stamp the one nearest to that before
    is taken, so that turns of more than π go on. Near whole turns the axis is not determined, and
    the vector leaps.
    """
    rotor = path.motors.rotor
    vectors = (rotor[:1].inverse() @ rotor).as_rotation_vector()
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    axes = vectors / np.where(angle > 0.0, angle, 1.0)
    for k in range(1, len(vectors)):
        along = float(axes[k] @ (vectors[k - 1] - vectors[k]))
        vectors[k] += 2.0 * np.pi * np.round(along / (2.0 * np.pi)) * axes[k]
    return np.asarray(vectors)


def twists(path: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Middles of steps in seconds ``(N-1,)``, and twists between poses ``(N-1, 6)``.

    Rotation (rad/s) first, then translation (m/s), in the moving frame: the motor from each pose to
    the next, its logarithm over the time between.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.render.plots.trajectories import twists
    >>> stamps = np.array([0, 500_000_000])
    >>> world_T_camera = Motor.from_translation([[0, 0, 0], [1.0, 0, 0]])
    >>> path = Trajectory(stamps, world_T_camera, "world", "camera")
    >>> twists(path)[1] + 0.0  # rad/s, then m/s
    array([[0., 0., 0., 2., 0., 0.]])
    """
    poses, time_s = path.motors, path.time_s
    steps = (poses[:-1].inverse() @ poses[1:]).as_twist()
    step_s = np.diff(time_s)
    return time_s[:-1] + 0.5 * step_s, steps / step_s[:, None]


def plot_rotation_and_twist(path: Trajectory, start_ns: int | None = None, unit: str = "m") -> str:
    """Rotation since the first pose, turning and speed of a path of 2 poses or more: an `<svg>`.

    Lines are x, y and z in `style.AXIS_COLOURS`; the legend is left to the page. Seconds count from
    `start_ns`, by default from the first pose; lengths are in `unit`.
    """
    since_s = 0.0 if start_ns is None else 1e-9 * (int(path.time_ns[0]) - start_ns)
    middles_s, twist = twists(path)
    rows = (
        (path.time_s, np.rad2deg(rotation_vectors_rad(path)), "turned (°)"),
        (middles_s, np.rad2deg(twist[:, :3]), "turning (°/s)"),
        (middles_s, twist[:, 3:], f"speed ({unit}/s)"),
    )
    with house_style():
        figure, panels = new_figure(WIDTH_IN, 4.4, rows=3)
        for axes, (time_s, values, unit) in zip(panels, rows, strict=True):
            for column, colour in enumerate(AXIS_COLOURS):
                axes.plot(*thinned(since_s + time_s, values[:, column]), color=colour)
            axes.set_ylabel(unit)
            axes.margins(x=0.01)
        panels[-1].set_xlabel("time (s)")
        figure.align_ylabels(panels)
        return as_svg(figure, "rotation and twist over time")


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
        >>> from motorcade.render.plots.trajectories import plot_paths
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
