"""`report.json` and its short form for a terminal; keys carry units.

The same recording, knobs and code give the same bytes: what a machine or an hour adds, such as how
long a stage took, stands in the run log instead.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from motorcade.replays.pipeline.report.film import FilmView
from motorcade.replays.pipeline.report.findings import Findings

COLUMNS = {
    "ape_rmse_m": ("APE", "mm", 1e3),
    "rotation_rmse_deg": ("rotation", "deg", 1.0),
    "rotation_constant_deg": ("constant part", "deg", 1.0),
    "rotation_rest_rmse_deg": ("rest", "deg", 1.0),
    "rpe_trans_rmse_m": ("RPE", "mm", 1e3),
    "rpe_rot_rmse_deg": ("RPE rot.", "deg", 1.0),
    "angular_jitter_rad_s2": ("ang. jitter", "rad/s²", 1.0),
    "linear_jitter_m_s2": ("lin. jitter", "m/s²", 1.0),
    "lag_ms": ("lag", "ms", 1.0),
    "registration_rmse_px": ("registration", "px", 1.0),
}
"""Figures shown side by side: key, heading, shown unit, factor into it."""


LEFT_AS_IT_WAS = (
    "The fused path was left as it is: any more smoothing would take away motion, not noise, so "
    "the representations do not differ here (smoothed.method or smoothed.parameters ask for it)."
)


def summarise(findings: Findings, film: FilmView | None) -> dict[str, Any]:
    """The report's figures as a JSON-ready tree."""
    start, drawn = findings.convergence, findings.overlay
    tree = {
        "recording": findings.recording.name,
        "camera_poses": _camera_poses(findings),
        "imu": {
            "origin": findings.imu.origin,
            "samples": _samples(findings),
            "clock_offset_s": findings.imu.clock_offset_s,
            "clock_offset_sigma_s": findings.imu.clock_offset_sigma_s,
        },
        "fused": _fused(findings),
        "smoothed": {"method": findings.smoothed.method, **findings.smoothed.parameters},
        "integrity": findings.integrity.as_dict(),
        "align": findings.errors.align,
        "unaligned": findings.errors.unaligned or None,
        "errors": findings.errors.figures,
        "stage_comparison": findings.errors.stages.as_dict(),
        "convergence": {
            "initial_tilt_deg": start.initial_tilt_deg,
            "settled_s": start.settled_s,
            "judged_by": start.judged_by,
        },
        "unmeasured_spans": [
            {"start_s": span[0], "end_s": span[1], "fused_worst_m": findings.worst_m("fused", span)}
            for span in findings.unmeasured_spans_s()
        ],
        "overlay": (drawn and film)
        and {
            "frames": film.frames,
            "frames_with_character": drawn.frames_with_character,
            "frames_in_view": film.in_view,
            "figure_height_px": film.height_px,
            "figure_height_share": film.height_share,
            "stands_on": film.stands_on,
            "in_words": film.sentence,
            "figures": [figure.as_dict() for figure in drawn.checks],
        },
        "doubts": list(findings.doubts),
        "choices": [place.name for place in findings.placed.choices],
        "cast": _cast(findings),
    }
    cleaned: dict[str, Any] = without_nan(tree)
    return cleaned


def _cast(findings: Findings) -> dict[str, Any] | None:
    """Who does what and when, how far feet slide and bodies are apart; None without a cast."""
    placed = findings.placed
    if not placed.parts:
        return None
    return {
        "least_distance_m": placed.apart_m,
        "characters": [
            {
                "name": part.name,
                "note": part.note,
                "worst_foot_slide_m": part.worst_slide_m,
                "states": [
                    {
                        "state": state.state,
                        "clip": state.clip,
                        "start_s": state.start_s,
                        "end_s": state.end_s,
                    }
                    for state in part.states
                ],
            }
            for part in placed.parts
        ],
    }


def _camera_poses(findings: Findings) -> dict[str, Any]:
    poses = findings.camera_poses
    return {
        "origin": poses.origin,
        "summary": poses.summary,
        "skipped": list(poses.skipped),
        "scale": "metric" if poses.metric else "free",
        "metres_a_unit": poses.metres_a_unit,
        "scale_sigma": poses.scale_sigma,
        "frames": len(poses.frame_times_ns),
        "measured": len(poses.measurements.trajectory),
        "reprojection_median_px": float(np.median(poses.reprojection_px)),
        "damaged_images": list(findings.recording.damaged),
        "slam": None if poses.slam_history is None else poses.slam_history.as_dict(),
        "inertial": None if poses.inertial is None else poses.inertial.as_dict(),
    }


def _fused(findings: Findings) -> dict[str, Any]:
    fused = findings.fused
    return {
        "by": fused.by,
        "summary": fused.summary,
        "nis_per_dimension": findings.nis_per_dimension,
        "left_out": int(np.count_nonzero(~fused.accepted)),
        "noise": None if fused.noise is None else fused.noise.as_dict(),
        "latency": _latency(findings),
    }


def _latency(findings: Findings) -> list[dict[str, float]] | None:
    """By lag, how far the path is from that by all of the recording; None where not asked for."""
    curve = findings.fused.latency
    if curve is None:
        return None
    rows = zip(
        curve.lag_s.tolist(), curve.position_m.tolist(), curve.rotation_deg.tolist(), strict=True
    )
    return [
        {"lag_s": lag_s, "position_rmse_m": metres, "rotation_rmse_deg": degrees}
        for lag_s, metres, degrees in rows
        if np.isfinite(lag_s)
    ]


def _samples(findings: Findings) -> int:
    imu = findings.imu
    return 0 if imu.origin == "none" else len(imu.stream(findings.recording))


def shown_columns(figures: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Keys of `COLUMNS` that at least one path has a figure for."""
    return [key for key in COLUMNS if any(row.get(key) is not None for row in figures.values())]


def heading(key: str, figures: Mapping[str, Mapping[str, Any]], *, metric: bool) -> str:
    """Name and unit of a column; lengths have one where the path or a ground truth does."""
    name, unit, _ = COLUMNS[key]
    if not metric and all(row.get("ape_rmse_m") is None for row in figures.values()):
        unit = unit.replace("m/s²", "units/s²")
    return f"{name} ({unit})"


def shown_value(key: str, value: float | None) -> str:
    """A figure in its shown unit with three significant digits, or a dash."""
    if value is None or not math.isfinite(value):
        return "–"
    scaled = value * COLUMNS[key][2]
    digits = 2 if scaled == 0 else max(0, 2 - math.floor(math.log10(abs(scaled))))
    return f"{scaled:.{min(digits, 4)}f}"


def as_table(summary: Mapping[str, Any]) -> str:
    """The errors of a report as aligned text; below, what was not smoothed or aligned."""
    figures = summary["errors"]
    keys = shown_columns(figures)
    metric = summary.get("camera_poses", {}).get("scale") != "free"
    head = ["", *(heading(key, figures, metric=metric) for key in keys)]
    rows = [
        [name, *(shown_value(key, row.get(key)) for key in keys)] for name, row in figures.items()
    ]
    widths = [max(len(line[i]) for line in [head, *rows]) for i in range(len(head))]
    lines = []
    for line in [head, *rows]:
        cells = [line[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(line[1:], widths[1:], strict=True)]
        lines.append("  ".join(cells))
    if summary.get("smoothed") == {"method": None}:
        lines.append(LEFT_AS_IT_WAS)
    if summary.get("unaligned"):
        lines.append(f"No error can be told: {summary['unaligned']}.")
    return "\n".join(lines)


def without_nan(value: Any) -> Any:
    """The same tree with None for numbers that JSON does not know."""
    if isinstance(value, dict):
        return {key: without_nan(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [without_nan(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
