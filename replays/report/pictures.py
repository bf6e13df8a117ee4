"""The report's plots: which quantities are drawn, and what each caption says."""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.render.plots import plot_plan_and_elevation, plot_series
from motorcade.replays.report.findings import Findings, Spans


@dataclass(frozen=True)
class Picture:
    """One plot of the page: heading, caption, and the `<svg>` element."""

    title: str
    caption: str
    svg: str


def plots(findings: Findings) -> list[Picture]:
    """Every plot that this run's data allows."""
    lost = findings.unmeasured_spans_s()
    return [_path(findings), *_errors(findings, lost), _shake(findings, lost), *_tilt(findings)]


def _path(findings: Findings) -> Picture:
    trajectories = {
        "measured": findings.camera_poses.measurements.trajectory,
        **findings.smoothed.trajectories,
    }
    caption = "Where the camera went, metres: from above, and from the side. z is up."
    truth = findings.recording.truth
    if truth is not None and findings.errors.align == "none":
        trajectories["truth"] = truth
    return Picture("Path", caption, plot_plan_and_elevation(trajectories))


def _errors(findings: Findings, lost: Spans) -> list[Picture]:
    series = findings.errors.against_truth
    if not series:
        return []
    rotation = {name: (one.time_s, one.rotation_deg) for name, one in series.items()}
    position = {name: (one.time_s, 1e3 * one.position_m) for name, one in series.items()}
    shaded = " Tinted: no pose was measured." if lost else ""
    return [
        Picture(
            "Rotation error over time",
            "Angle between estimated and true orientation, logarithmic." + shaded,
            plot_series(rotation, "rotation error", "degrees", log_scale=True, shaded_s=lost),
        ),
        Picture(
            "Position error over time",
            "Distance between estimated and true camera centre, logarithmic." + shaded,
            plot_series(position, "position error", "mm", log_scale=True, shaded_s=lost),
        ),
    ]


def _shake(findings: Findings, lost: Spans) -> Picture:
    series = {
        name: (one.time_s, one.angular_acceleration_rad_s2)
        for name, one in findings.errors.shake.items()
    }
    return Picture(
        "Jitter over time",
        "Length of the angular acceleration, logarithmic: shaking shows as height. Euler angles "
        "leap where one of them wraps or the pitch passes ±90°; unwrapping heals only the former.",
        plot_series(series, "angular acceleration", "rad/s²", log_scale=True, shaded_s=lost),
    )


def _tilt(findings: Findings) -> list[Picture]:
    found = findings.convergence
    if not len(found.time_s):
        return []
    settled = (
        f"it is below a tenth of that for good after {found.settled_s:.2f} s"
        if found.settled_s is not None
        else "it does not settle below a tenth of that here"
    )
    return [
        Picture(
            "Convergence from a wrong start",
            f"The filter once more, forwards only, started {found.initial_tilt_deg:g}° wrong in "
            f"tilt with zero biases, judged by the {found.judged_by}: {settled}.",
            plot_series(
                {"fused": (found.time_s, found.tilt_error_deg)},
                "tilt error",
                "degrees",
                log_scale=True,
            ),
        )
    ]
