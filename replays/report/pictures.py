"""The report's plots and their captions, and the video at a glance: some frames on one sheet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import cv2

from motorcade.render.plots import (
    plot_path_3d,
    plot_plan_and_elevation,
    plot_rotation_and_twist,
    plot_series,
)
from motorcade.render.plots.errors import Series
from motorcade.render.plots.style import with_own_ids
from motorcade.render.video import contact_sheet, read_frames
from motorcade.replays.pages.parts import PagePlot
from motorcade.replays.report.filtering import filter_pictures
from motorcade.replays.report.findings import Findings, Spans, as_drawn, map_unit

__all__ = ["ReportSection", "sections", "sheet_jpeg"]

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
    drawn = as_drawn(findings, {first: path, "measured": measured, **smoothed})
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


def _errors(findings: Findings, lost: Spans) -> tuple[PagePlot, ...]:
    series = findings.errors.against_truth
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
    series = {
        name: (one.time_s, one.angular_rad_s2) for name, one in findings.errors.acceleration.items()
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


MOST_FRAMES, COLUMNS, WIDTH_PX = 12, 3, 340
MOST_BYTES = 300_000
_QUALITIES = (85, 75, 65, 50, 35, 20)


def sheet_jpeg(film: Path, frames: int) -> bytes:
    """Twelve frames or fewer, even in time, with their times, as JPEG of 300 kB at most.

    Args:
        film: a video.
        frames: how many it holds.

    Raises:
        OSError: a file that cannot be read or holds no video.
    """
    chosen = list(read_frames(film, every=-(-frames // MOST_FRAMES)))
    labels = [f"{1e-9 * time_ns:.1f} s" for time_ns, _ in chosen]
    sheet = contact_sheet([picture for _, picture in chosen], COLUMNS, WIDTH_PX, labels)
    for quality in _QUALITIES:
        done, data = cv2.imencode(".jpg", sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
        if not done:
            raise OSError(f"{film}: the sheet of its frames cannot be written as JPEG")
        if data.size <= MOST_BYTES:
            break
    return bytes(data)
