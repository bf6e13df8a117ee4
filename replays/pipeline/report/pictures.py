"""The report's plots and captions: paths, errors, what SLAM knew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from motorcade.render.plots import (
    plot_path_3d,
    plot_plan_and_elevation,
    plot_rotation_and_twist,
    plot_series,
)
from motorcade.render.plots.errors import Series
from motorcade.render.plots.style import with_own_ids
from motorcade.replays.pipeline.report.filter_plots import filter_pictures
from motorcade.replays.pipeline.report.findings import (
    Findings,
    Spans,
    as_drawn,
    map_unit,
    told_paths,
)
from motorcade.replays.web.pages.parts import PagePlot

_MOST_EVENTS = 8
_AXES = ("x", "y", "z")
_LENGTHS = {"m": "Metres", "units": "Units of the map, of unknown length"}


@dataclass(frozen=True)
class ReportSection:
    """Plots under one heading; none of them is empty."""

    title: str
    note: str
    pictures: tuple[PagePlot, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Lines that all plots share, for one legend; none where they differ."""
        legends = {one.names for one in self.pictures}
        return legends.pop() if len(legends) == 1 else ()


def sections(findings: Findings) -> list[ReportSection]:
    """Every plot that this run's data allows."""
    lost = findings.unmeasured_spans_s()
    shaded = " Tinted: no pose was measured." if lost else ""
    found = [
        ReportSection("Path", "Where the camera went and how it turned.", _path(findings)),
        ReportSection(
            "Errors over time",
            "Logarithmic; lines that coincide lie within each other." + shaded,
            (*_errors(findings, lost), _jitter(findings, lost)),
        ),
        ReportSection(
            "Visual SLAM",
            "Whether it knew where it was. Tinted: no pose was measured.",
            _slam(findings, lost),
        ),
        ReportSection(
            "The filter",
            "Whether it was as sure of itself as it should have been.",
            tuple(filter_pictures(findings)),
        ),
    ]
    marked = [
        replace(one, pictures=tuple(_marked(one.title, k, p) for k, p in enumerate(one.pictures)))
        for one in found
    ]
    return [one for one in marked if one.pictures]


def _marked(title: str, number: int, picture: PagePlot) -> PagePlot:
    """The picture with ids that are its own on the page."""
    mark = f"{title.split()[-1].lower()}-{number}"
    return replace(picture, svg=with_own_ids(picture.svg, mark))


def _path(findings: Findings) -> tuple[PagePlot, ...]:
    measured = findings.camera_poses.measurements.trajectory
    smoothed = findings.smoothed.trajectories
    first, path = next(iter(smoothed.items()))
    others = {name: one for name, one in smoothed.items() if name in told_paths(findings)}
    drawn = as_drawn(findings, {first: path, "measured": measured, **others})
    shown = drawn.paths
    few = {name: shown[name] for name in (first, "measured", "truth") if name in shown}
    pictures = [
        PagePlot(
            "In space",
            "The path with cameras along it, which open where they look; its shadow below. "
            + drawn.note,
            plot_path_3d(few, drawn.unit),
            tuple(few),
        ),
        PagePlot(
            "From above and from the side",
            _LENGTHS[drawn.unit] + ", equal scales.",
            plot_plan_and_elevation(shown, drawn.unit),
            tuple(shown),
        ),
    ]
    if len(path) > 1:
        svg = plot_rotation_and_twist(path, int(measured.time_ns[0]), map_unit(findings))
        caption = (
            f"Rotation since the first pose as a rotation vector, and the twist in the camera's "
            f"axes: turning and speed. Smoothed as {first}."
        )
        pictures.append(PagePlot("Rotation and twist", caption, svg, _AXES))
    return tuple(pictures)


def _slam(findings: Findings, lost: Spans) -> tuple[PagePlot, ...]:
    history = findings.camera_poses.slam_history
    if history is None:
        return ()
    time_s = 1e-9 * (history.time_ns - findings.camera_poses.measurements.trajectory.time_ns[0])
    states = (f"{count} {state}" for state, count in history.frames_in_state.items() if count)
    happened = [one for one in history.events if one.kind != "map begun" or one.map_number != 0]
    first = "; ".join(
        f"{one.kind} at {1e-9 * (one.time_ns - history.time_ns[0]):.2f} s"
        for one in happened[:_MOST_EVENTS]
    )
    more = " and more" if len(happened) > _MOST_EVENTS else ""
    told = f" {first[:1].upper()}{first[1:]}{more}." if happened else ""
    corners = plot_series(
        {"measured": (time_s, history.inliers.astype(np.float64))},
        "corners that the pose explains",
        "corners",
        shaded_s=lost,
    )
    keyframes = plot_series(
        {"measured": (time_s, history.keyframes.astype(np.float64))},
        "keyframes in all maps",
        "keyframes",
        shaded_s=lost,
    )
    caption = f"Frames: {', '.join(states)}.{told}{_inertial(findings)}"
    return (
        PagePlot("Corners that the pose explains", caption, corners, ("measured",)),
        PagePlot("Keyframes", "In all maps together.", keyframes, ("measured",)),
    )


def _inertial(findings: Findings) -> str:
    """What the IMU inside told, as further sentences of a caption."""
    told = findings.camera_poses.inertial
    if told is None:
        return ""
    states = ", ".join(f"{count} {state}" for state, count in told.frames_in_state.items())
    across, down, ahead = told.gravity_direction
    return (
        f" With the IMU: {states}. The map has been in metres since {told.metric_from_s:.2f} s, "
        f"when its unit was {told.metres_a_unit:.4g} m ± {100 * told.scale_sigma:.2g} %. Gravity "
        f"is along ({across:.3f}, {down:.3f}, {ahead:.3f}) in the axes of the map's first camera, "
        f"± {np.rad2deg(told.tilt_sigma_rad):.2g}°."
    )


def _errors(findings: Findings, lost: Spans) -> tuple[PagePlot, ...]:
    told = told_paths(findings)
    series = {name: one for name, one in findings.errors.against_truth.items() if name in told}
    if not series:
        return ()
    rotation = {name: (one.time_s, one.rotation_deg) for name, one in series.items()}
    position = {name: (one.time_s, 1e3 * one.position_m) for name, one in series.items()}
    return tuple(
        PagePlot(
            title,
            caption,
            _over_time(values, f"{title.lower()} ({unit})", lost),
            tuple(values),
        )
        for title, caption, values, unit in (
            (
                "Rotation error",
                "Angle between estimated and true orientation.",
                rotation,
                "°",
            ),
            (
                "Position error",
                "Distance from the true camera centre.",
                position,
                "mm",
            ),
        )
    )


def _jitter(findings: Findings, lost: Spans) -> PagePlot:
    told = told_paths(findings)
    series = {
        name: (one.time_s, one.angular_rad_s2)
        for name, one in findings.errors.acceleration.items()
        if name in told
    }
    return PagePlot(
        "Jitter",
        "Length of the angular acceleration: jitter shows as height. Euler angles leap where one "
        "of them wraps or the pitch passes ±90°; unwrapping heals only the former.",
        _over_time(series, "angular acceleration (rad/s²)", lost),
        tuple(series),
    )


def _over_time(series: Mapping[str, Series], quantity: str, lost: Spans) -> str:
    return plot_series(series, quantity, quantity, log_scale=True, shaded_s=lost, nested=True)
