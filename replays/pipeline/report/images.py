"""The report's plots and captions: paths, errors, what SLAM knew, what the filter said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from motorcade.fusion.metrics import alignment_of, associate
from motorcade.fusion.metrics.consistency import chi2_bounds
from motorcade.ga.arrays import FloatArray
from motorcade.render.plots import (
    plot_path_3d,
    plot_plan_and_elevation,
    plot_rotation_and_twist,
    plot_series,
    plot_squares,
    plot_within_sigma,
)
from motorcade.render.plots.errors import Series
from motorcade.render.plots.style import with_own_ids
from motorcade.replays.pipeline.report.findings import (
    Findings,
    Spans,
    as_drawn,
    map_unit,
    told_paths,
)
from motorcade.replays.web.pages import PagePlot
from motorcade.tracking.pose import SIGMA_FLOOR_PX

_MOST_EVENTS = 8
_AXES = ("x", "y", "z")
_LENGTHS = {"m": "Metres", "units": "Units of the map, of unknown length"}


@dataclass(frozen=True)
class ReportSection:
    """Plots under one heading; none of them is empty."""

    title: str
    note: str
    images: tuple[PagePlot, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Lines that all plots share, for one legend; none where they differ."""
        legends = {one.names for one in self.images}
        return legends.pop() if len(legends) == 1 else ()


def sections(findings: Findings) -> list[ReportSection]:
    """Every plot that this run's data allows."""
    lost = findings.unmeasured_spans_s()
    shaded = " Tinted: no pose was measured." if lost else ""
    all_sections = [
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
            tuple(filter_images(findings)),
        ),
    ]
    marked = [
        replace(
            section,
            images=tuple(_marked(section.title, k, p) for k, p in enumerate(section.images)),
        )
        for section in all_sections
    ]
    return [one for one in marked if one.images]


def _marked(title: str, number: int, image: PagePlot) -> PagePlot:
    """The image with ids that are its own on the page."""
    mark = f"{title.split()[-1].lower()}-{number}"
    return replace(image, svg=with_own_ids(image.svg, mark))


def _path(findings: Findings) -> tuple[PagePlot, ...]:
    measured = findings.camera_poses.measurements.trajectory
    smoothed = findings.smoothed.trajectories
    first, path = next(iter(smoothed.items()))
    others = {name: one for name, one in smoothed.items() if name in told_paths(findings)}
    drawn = as_drawn(findings, {first: path, "measured": measured, **others})
    shown = drawn.paths
    few = {name: shown[name] for name in (first, "measured", "truth") if name in shown}
    images = [
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
        images.append(PagePlot("Rotation and twist", caption, svg, _AXES))
    return tuple(images)


def _slam(findings: Findings, lost: Spans) -> tuple[PagePlot, ...]:
    history = findings.camera_poses.slam_history
    if history is None:
        return ()
    time_s = 1e-9 * (history.time_ns - findings.camera_poses.measurements.trajectory.time_ns[0])
    states = (f"{count} {state}" for state, count in history.frames_in_state.items() if count)
    happened = [one for one in history.events if one.kind != "map begun" or one.map_number != 0]
    first = "; ".join(
        f"{event.kind} at {1e-9 * (event.time_ns - history.time_ns[0]):.2f} s"
        for event in happened[:_MOST_EVENTS]
    )
    more = " and more" if len(happened) > _MOST_EVENTS else ""
    text = f" {first[:1].upper()}{first[1:]}{more}." if happened else ""
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
    caption = f"Frames: {', '.join(states)}.{text}{_inertial(findings)}"
    return (
        PagePlot("Corners that the pose explains", caption, corners, ("measured",)),
        PagePlot("Keyframes", "In all maps together.", keyframes, ("measured",)),
    )


def _inertial(findings: Findings) -> str:
    """What the IMU inside told, as further sentences of a caption."""
    inertial = findings.camera_poses.inertial
    if inertial is None:
        return ""
    states = ", ".join(f"{count} {state}" for state, count in inertial.frames_in_state.items())
    across, down, ahead = inertial.gravity_direction
    return (
        f" With the IMU: {states}. The map has been in metres since "
        f"{inertial.metric_from_s:.2f} s, "
        f"when its unit was {inertial.metres_a_unit:.4g} m ± {100 * inertial.scale_sigma:.2g} %. "
        "Gravity "
        f"is along ({across:.3f}, {down:.3f}, {ahead:.3f}) in the axes of the map's first camera, "
        f"± {np.rad2deg(inertial.tilt_sigma_rad):.2g}°."
    )


def _errors(findings: Findings, lost: Spans) -> tuple[PagePlot, ...]:
    labels = told_paths(findings)
    series = {name: one for name, one in findings.errors.against_truth.items() if name in labels}
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
    labels = told_paths(findings)
    series = {
        name: (acceleration.time_s, acceleration.angular_rad_s2)
        for name, acceleration in findings.errors.acceleration.items()
        if name in labels
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


_FREEDOM = 6
# A one-sigma band holds this share of Gaussian errors.
_WITHIN = 0.683


@dataclass(frozen=True, eq=False)
class FilterErrors:
    """Errors of the fused path and their stated deviations, in the camera's axes.

    Fields:
        time_s: seconds after the first measured pose ``(P,)``.
        errors, sigma: ``(P, 6)``, rotation (rad) first, then translation (m).
    """

    time_s: FloatArray
    errors: FloatArray
    sigma: FloatArray


def filter_errors(findings: Findings) -> FilterErrors | None:
    """Logarithms from the aligned fused path to the ground truth; None without either.

    Alignment takes away some of the error that the deviations count.
    """
    truth, path = findings.recording.truth, findings.fused.trajectory
    if truth is None or findings.fused.by == "nothing":
        return None
    pairs = associate(path, truth)
    fit = alignment_of(pairs, findings.errors.align)
    stamps = pairs.time_ns
    inside = (stamps >= truth.time_ns[0]) & (stamps <= truth.time_ns[-1])
    rows, stamps = pairs.estimate_index[inside], stamps[inside]
    # Between the ground truth's stamps: motion within a few milliseconds would pass for error.
    wrong = fit.apply(path.motors[rows]).inverse() @ truth.motors_at(stamps)
    variances = np.diagonal(findings.fused.covariance[rows], axis1=-2, axis2=-1)
    start_ns = int(findings.camera_poses.measurements.trajectory.time_ns[0])
    return FilterErrors((stamps - start_ns) * 1e-9, wrong.as_twist(), np.sqrt(variances))


def filter_images(findings: Findings) -> list[PagePlot]:
    """Errors within their deviations, NIS, how a wrong start is forgotten, what a lag gains."""
    return [*_within(findings), *_nis(findings), *_tilt(findings), *_latency(findings)]


def _within(findings: Findings) -> list[PagePlot]:
    within = filter_errors(findings)
    if within is None or not len(within.time_s):
        return []
    images = []
    for title, part, factor, unit in (
        ("Rotation within ±σ", slice(0, 3), np.rad2deg(1.0), "°"),
        ("Position within ±σ", slice(3, 6), 1e3, "mm"),
    ):
        errors, sigma = factor * within.errors[:, part], factor * within.sigma[:, part]
        share, apart = (
            float(np.mean(np.abs(error) <= sigma))
            for error in (errors, errors - errors.mean(axis=0))
        )
        caption = (
            f"Errors of the fused path in the camera's axes; tinted: one and two deviations that "
            f"the filter states. {100 * share:.0f} % lie within one; {100 * _WITHIN:.0f} % would "
            "where it is right. Errors that last, as of corners that are all found a little to one "
            "side, of a board or a calibration, it takes for noise that averages out: less their "
            f"mean over time, {100 * apart:.0f} % lie within."
        )
        svg = plot_within_sigma(within.time_s, errors, sigma, title, unit)
        images.append(PagePlot(title, caption, svg, ("x", "y", "z")))
    return images


def _nis(findings: Findings) -> list[PagePlot]:
    fused = findings.fused
    known = np.isfinite(fused.nis) & (fused.nis > 0.0)
    if not np.any(known):
        return []
    start_ns = int(findings.camera_poses.measurements.trajectory.time_ns[0])
    time_s = (fused.trajectory.time_ns[known] - start_ns) * 1e-9
    low, high = chi2_bounds(_FREEDOM, 1)
    nis = fused.nis[known]
    share = float(np.mean((nis >= low) & (nis <= high)))
    left_out = int(np.count_nonzero(~fused.accepted))
    caption = (
        f"Innovations squared, normalised by what the filter expects: {_FREEDOM} on average "
        f"(dashed), 95 % within the tint ({low:.2f} to {high:.2f}) where it is right; here "
        f"{100 * share:.0f} %. Below: it is less sure of itself than it could be. "
        f"{left_out} were left out."
    ) + _floor(findings)
    svg = plot_squares(
        {"fused": (time_s, nis)}, _FREEDOM, (low, high), "NIS of the poses", "NIS", dots=True
    )
    return [PagePlot("NIS of the measured poses", caption, svg, ("fused",))]


def _floor(findings: Findings) -> str:
    """That corners fit better than poses by a board ever take them to; empty where they do not."""
    poses = findings.camera_poses
    if poses.origin != "board":
        return ""
    fit_px = float(np.nanmedian(poses.reprojection_px)) / np.sqrt(2.0)
    if not fit_px < SIGMA_FLOOR_PX:
        return ""
    return (
        f" Corners fit to {fit_px:.2f} px a coordinate here, and none is believed below "
        f"{SIGMA_FLOOR_PX:g} px, for what lasts is not seen in a fit: NIS lies low for that."
    )


def _tilt(findings: Findings) -> list[PagePlot]:
    convergence = findings.convergence
    if not len(convergence.time_s):
        return []
    settled = (
        f"it is below a tenth of that for good after {convergence.settled_s:.2f} s"
        if convergence.settled_s is not None
        else "it does not settle below a tenth of that here"
    )
    caption = (
        "The filter once more, forwards only, started "
        f"{convergence.initial_tilt_deg:g}° wrong in tilt "
        f"with zero biases, judged by the {convergence.judged_by}: {settled}."
    )
    series = {"fused": (convergence.time_s, convergence.tilt_error_deg)}
    svg = plot_series(series, "tilt error", "tilt error (°)", log_scale=True)
    return [PagePlot("Convergence from a wrong start", caption, svg, ("fused",))]


def _latency(findings: Findings) -> list[PagePlot]:
    curve = findings.fused.latency
    if curve is None:
        return []
    tried = np.isfinite(curve.lag_s)
    lags, millimetres, degrees = (
        series[tried] for series in (curve.lag_s, 1e3 * curve.position_m, curve.rotation_deg)
    )
    caption = (
        "How far the path, answered so much later while it is recorded, lies from that by all of "
        f"the recording (root mean square): {millimetres[0]:.2f} mm and {degrees[0]:.3f}° at once, "
        f"{millimetres[-1]:.2f} mm and {degrees[-1]:.3f}° after {lags[-1]:g} s."
    )
    svg = plot_series({"fused": (lags, millimetres)}, "error over lag", "error (mm)", over="lag")
    return [PagePlot("What answering later gains", caption, svg, ("fused",))]
