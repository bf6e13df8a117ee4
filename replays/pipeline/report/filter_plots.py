"""What the filter said of itself, as plots: its deviations, its innovations, how it begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics import alignment_of, associate
from motorcade.fusion.metrics.consistency import chi2_bounds
from motorcade.ga.arrays import FloatArray
from motorcade.render.plots import plot_series, plot_squares, plot_within_sigma
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.web.pages.parts import PagePlot
from motorcade.tracking.pose import SIGMA_FLOOR_PX

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


def filter_pictures(findings: Findings) -> list[PagePlot]:
    """Errors within their deviations, NIS, how a wrong start is forgotten, what a lag gains."""
    return [*_within(findings), *_nis(findings), *_tilt(findings), *_latency(findings)]


def _within(findings: Findings) -> list[PagePlot]:
    found = filter_errors(findings)
    if found is None or not len(found.time_s):
        return []
    pictures = []
    for title, part, factor, unit in (
        ("Rotation within ±σ", slice(0, 3), np.rad2deg(1.0), "°"),
        ("Position within ±σ", slice(3, 6), 1e3, "mm"),
    ):
        errors, sigma = factor * found.errors[:, part], factor * found.sigma[:, part]
        share, apart = (
            float(np.mean(np.abs(one) <= sigma)) for one in (errors, errors - errors.mean(axis=0))
        )
        caption = (
            f"Errors of the fused path in the camera's axes; tinted: one and two deviations that "
            f"the filter states. {100 * share:.0f} % lie within one; {100 * _WITHIN:.0f} % would "
            "where it is right. Errors that last, as of corners that are all found a little to one "
            "side, of a board or a calibration, it takes for noise that averages out: less their "
            f"mean over time, {100 * apart:.0f} % lie within."
        )
        svg = plot_within_sigma(found.time_s, errors, sigma, title, unit)
        pictures.append(PagePlot(title, caption, svg, ("x", "y", "z")))
    return pictures


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
    found = findings.convergence
    if not len(found.time_s):
        return []
    settled = (
        f"it is below a tenth of that for good after {found.settled_s:.2f} s"
        if found.settled_s is not None
        else "it does not settle below a tenth of that here"
    )
    caption = (
        f"The filter once more, forwards only, started {found.initial_tilt_deg:g}° wrong in tilt "
        f"with zero biases, judged by the {found.judged_by}: {settled}."
    )
    series = {"fused": (found.time_s, found.tilt_error_deg)}
    svg = plot_series(series, "tilt error", "tilt error (°)", log_scale=True)
    return [PagePlot("Convergence from a wrong start", caption, svg, ("fused",))]


def _latency(findings: Findings) -> list[PagePlot]:
    curve = findings.fused.latency
    if curve is None:
        return []
    tried = np.isfinite(curve.lag_s)
    lags, millimetres, degrees = (
        one[tried] for one in (curve.lag_s, 1e3 * curve.position_m, curve.rotation_deg)
    )
    caption = (
        "How far the path, answered so much later while it is recorded, lies from that by all of "
        f"the recording (root mean square): {millimetres[0]:.2f} mm and {degrees[0]:.3f}° at once, "
        f"{millimetres[-1]:.2f} mm and {degrees[-1]:.3f}° after {lags[-1]:g} s."
    )
    svg = plot_series({"fused": (lags, millimetres)}, "error over lag", "error (mm)", over="lag")
    return [PagePlot("What answering later gains", caption, svg, ("fused",))]
