"""How a path turns and moves over time: its rotation, and its twist in the moving frame."""

from __future__ import annotations

import numpy as np

from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render.plots.style import (
    AXIS_COLOURS,
    WIDTH_IN,
    as_svg,
    house_style,
    new_figure,
    thinned,
)

__all__ = ["plot_rotation_and_twist", "rotation_vectors_rad", "twists"]


def rotation_vectors_rad(path: Trajectory) -> FloatArray:
    """Rotation vectors ``(N, 3)`` of a path from its first pose on.

    A turn of θ about an axis is also one of θ - 2π: at each stamp the one nearest to that before
    is taken, so that turns of more than π go on. Near whole turns the axis is not determined, and
    the vector leaps.
    """
    rotor = path.motors.rotor
    found = (rotor[:1].inverse() @ rotor).as_rotation_vector()
    angle = np.linalg.norm(found, axis=-1, keepdims=True)
    axes = found / np.where(angle > 0.0, angle, 1.0)
    for k in range(1, len(found)):
        along = float(axes[k] @ (found[k - 1] - found[k]))
        found[k] += 2.0 * np.pi * np.round(along / (2.0 * np.pi)) * axes[k]
    return np.asarray(found)


def twists(path: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Middles of steps in seconds ``(N-1,)``, and twists between poses ``(N-1, 6)``.

    Rotation (rad/s) first, then translation (m/s), in the moving frame: the motor from each pose to
    the next, its logarithm over the time between.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.render.plots.motion import twists
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
