"""The report page: one HTML file that needs nothing beside it."""

from __future__ import annotations

import base64
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import kernels
from motorcade.ga.files import off_record, read_bounded
from motorcade.replays.pages import page_environment
from motorcade.replays.readers.frames.corners import CornerFrames
from motorcade.replays.report.findings import Findings
from motorcade.replays.report.pictures import sections, sheet_jpeg
from motorcade.replays.report.summary import (
    LEFT_AS_IT_WAS,
    heading,
    shown_columns,
    shown_value,
)

MOST_NAMED = 3
VIDEO_LIMIT = 64 * 2**20
BESIDE = "overlay.mp4"
TEMPLATE = Path(__file__).with_name("template.html")
NO_VIDEO = (
    "there is no headless OpenGL on this machine. Debian and Ubuntu bring it with "
    "apt-get install libegl1 libgl1-mesa-dri; then run the same command again."
)
NO_PICTURES = "the recording holds corners of markers and no pictures to draw into."
IMU_ORIGINS = {
    "recorded": "recorded",
    "reference": "simulated along the ground truth, as for an experiment",
}


def page(findings: Findings) -> str:
    """The whole page as HTML text; a video of up to 64 MiB is inside as a data address."""
    template = page_environment(TEMPLATE.parent).get_template(TEMPLATE.name)
    figures = findings.errors.figures
    keys = shown_columns(figures)
    return template.render(
        name=findings.recording.name,
        headline=headline(findings),
        video=_video(findings),
        video_caption=_video_caption(findings),
        shape=_shape(findings),
        sheet=_sheet(findings),
        no_video=_no_video(findings),
        facts=_facts(findings),
        errors_caption=_errors_caption(findings),
        columns=[heading(key, figures, metric=findings.camera_poses.metric) for key in keys],
        rows=_rows(figures, keys),
        sections=sections(findings),
        stages=_stages(findings),
        has_truth=bool(findings.errors.against_truth),
        provenance=_provenance(),
    )


def headline(findings: Findings) -> str:
    """What was measured, and what was made of it, in a few sentences."""
    poses, fused = findings.camera_poses, findings.fused
    imu = f"; IMU {_imu(findings)}" if fused.by == "imu" else ""
    text = f"Camera poses {poses.summary}{imu}. The path was {fused.summary}."
    if fused.noise is not None:
        told = fused.noise.summary
        text += f" {told[:1].upper()}{told[1:]}."
    if poses.skipped:
        text += f" Skipped: {'; '.join(poses.skipped)}."
    damaged = findings.recording.damaged
    if damaged:
        text += f" {len(damaged)} damaged pictures were left out: {'; '.join(damaged[:MOST_NAMED])}"
        text += " and others." if len(damaged) > MOST_NAMED else "."
    return text


def _imu(findings: Findings) -> str:
    imu = findings.imu
    text = IMU_ORIGINS[imu.origin]
    if imu.clock_offset_sigma_s is not None:
        text += (
            f", its clock {1e3 * imu.clock_offset_s:+.2f} ± "
            f"{1e3 * imu.clock_offset_sigma_s:.2f} ms from the camera's, taken off"
        )
    return text


@off_record()  # it lies in the cache
def _video(findings: Findings) -> str | None:
    if findings.overlay is None:
        return None
    if _beside(findings):
        return BESIDE
    return _data_address("video/mp4", read_bounded(findings.overlay.path, VIDEO_LIMIT))


def _beside(findings: Findings) -> bool:
    """Whether the video is too large for a page, and stays a file beside it."""
    film = findings.overlay
    return film is not None and film.path.stat().st_size > VIDEO_LIMIT


@off_record()
def _sheet(findings: Findings) -> str | None:
    """Frames of the video on one sheet; None where one frame is all there is."""
    film = findings.overlay
    if film is None or film.frames < 2:
        return None
    return _data_address("image/jpeg", sheet_jpeg(film.path, film.frames))


def _shape(findings: Findings) -> float:
    """Width over height of the video."""
    camera = findings.recording.camera
    return camera.width / camera.height if camera is not None else 4.0 / 3.0


def _data_address(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def _no_video(findings: Findings) -> str:
    corners = isinstance(findings.recording.frames, CornerFrames)
    return NO_PICTURES if corners else NO_VIDEO


def _video_caption(findings: Findings) -> str:
    if findings.overlay is None:
        return ""
    film = findings.overlay
    where = f" It is too large for this page, and lies beside it as {BESIDE}."
    return (
        f"{film.frames} {film.footage} frames, the character drawn along the {film.along} path; it "
        f"or its shadow is in view in {film.frames_with_character} of them. It stands on "
        f"{film.stands_on}, in {film.lit_by}.{where if _beside(findings) else ''}"
    )


def _verdict(findings: Findings) -> dict[str, Any]:
    """The first tile: whether the result can be relied on, and what speaks against it."""
    found = findings.integrity
    if not found.doubts:
        names, unknown = (
            ", ".join(_words(check.name) for check in found.checks if check.verdict == verdict)
            for verdict in ("consistent", "unknown")
        )
        agreed = f"stages and pictures agree ({names})" if names else "nothing was checked"
        agreed += f"; cannot be told: {unknown}" if unknown else ""
        return {"value": found.verdict, "label": agreed, "wrong": False}
    reasons = "; ".join(found.doubts)
    drawn = f"The character stands along the {found.drawn_is} path."
    label = f"{reasons[:1].upper()}{reasons[1:]}. {drawn}"
    return {"value": found.verdict, "label": label, "wrong": True}


def _words(name: str) -> str:
    return name.replace("_", " ")


def _facts(findings: Findings) -> list[dict[str, Any]]:
    """The few figures that stand large at the top."""
    poses = findings.camera_poses
    measured = len(poses.measurements.trajectory)
    facts = [("frames with a pose", f"{measured} of {len(poses.frame_times_ns)}")]
    if np.any(np.isfinite(poses.reprojection_px)):
        median = float(np.nanmedian(poses.reprojection_px))
        facts.append(("median reprojection error", f"{median:.2f} px"))
    if not poses.metric:
        facts.append(("scale: lengths have no unit", "free"))
    motor = findings.errors.figures.get("motor", {})
    if motor.get("ape_rmse_m") is not None:
        facts.append(
            ("APE, motor-smoothed", f"{shown_value('ape_rmse_m', motor['ape_rmse_m'])} mm")
        )
        turn = shown_value("rotation_rmse_deg", motor["rotation_rmse_deg"])
        facts.append(("rotation error, motor-smoothed", f"{turn}°"))
    facts += _jitter_facts(findings)
    if findings.nis_per_dimension is not None:
        fact = f"{findings.nis_per_dimension:.2f}"
        facts.append(("mean NIS a dimension (1: the noise model fits)", fact))
    tiles = [{"label": label, "value": value, "wrong": False} for label, value in facts]
    worse = [
        {"label": f"{one[:1].upper()}{one[1:]}.", "value": "worse", "wrong": True}
        for one in findings.errors.stages.worse
    ]
    return [_verdict(findings), *worse, *tiles]


def _jitter_facts(findings: Findings) -> list[tuple[str, str]]:
    """How much jitter the measured poses have, and the path that is drawn along."""
    figures = findings.errors.figures
    first = next(iter(findings.smoothed.trajectories))
    made = []
    for key in ("angular_jitter_rad_s2", "linear_jitter_m_s2"):
        ends = [figures.get(name, {}).get(key) for name in ("measured", first)]
        if None in ends:
            continue
        name = heading(key, figures, metric=findings.camera_poses.metric)
        before, after = (shown_value(key, one) for one in ends)
        made.append((f"{name}, measured → smoothed", f"{before} → {after}"))
    return made


def _errors_caption(findings: Findings) -> str:
    errors = findings.errors
    if errors.unaligned:
        return f"No error can be told, only jitter: {errors.unaligned}."
    if findings.recording.truth is None:
        return "This recording has no ground truth: only jitter can be measured."
    how = {
        "none": "without alignment",
        "se3": "after rigid alignment (SE3)",
        "sim3": "after alignment with scale (Sim3)",
    }[errors.align]
    tint = "" if findings.smoothed.method is None else "The best of a column is tinted. "
    against = f"Against the recording's ground truth, {how}; root mean squares. {tint}"
    return against + _smoothing(findings)


def _stages(findings: Findings) -> str:
    """How far each stage's path is from what judges it, at the same stamps."""
    found = findings.errors.stages
    if found.judged_by == "nothing":
        return ""
    metric = found.judged_by == "ground truth" or findings.camera_poses.metric
    unit, factor = ("mm", 1e3) if metric else ("units", 1.0)
    each = ", ".join(
        f"{name} {factor * off:.3g} {unit} and {found.rotation_rmse_deg[name]:.3g}°"
        for name, off in found.position_rmse_m.items()
    )
    how = {
        "ground truth": f"At the {found.poses} stamps that all paths and the ground truth have",
        "held-out poses": f"Judged by {found.poses} measured poses that they were made without",
    }[found.judged_by]
    return f"{how}, the stages' paths are off by: {each}."


def _smoothing(findings: Findings) -> str:
    method, parameters = findings.smoothed.method, findings.smoothed.parameters
    if method is None:
        return LEFT_AS_IT_WAS
    numbers = (
        f"{name} {value:.3g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in parameters.items()
    )
    return f"Smoothed by {method}: {', '.join(numbers) or 'at its defaults'}."


def _rows(figures: dict[str, dict[str, float | None]], keys: list[str]) -> list[dict[str, Any]]:
    best = {key: _best_shown(key, [row.get(key) for row in figures.values()]) for key in keys}
    tied = {
        key for key in keys if len({shown_value(key, r.get(key)) for r in figures.values()}) < 2
    }
    rows = []
    for name, row in figures.items():
        shown = {key: shown_value(key, row.get(key)) for key in keys}
        cells = [
            {
                "text": shown[key],
                "value": row.get(key),
                "best": key not in tied and shown[key].lstrip("-") == best[key],
            }
            for key in keys
        ]
        rows.append({"name": name, "cells": cells})
    return rows


def _best_shown(key: str, values: list[float | None]) -> str:
    """The smallest size of a column as it is shown, so that equal figures share the honour."""
    return shown_value(key, min(abs(value) for value in values if value is not None))


def _provenance() -> list[tuple[str, str]]:
    return [
        ("motorcade", f"{version('motorcade')}, {kernels.backend} kernels"),
        ("Python, NumPy", f"{platform.python_version()}, {np.__version__}"),
        ("settings", "run.json beside this page holds every knob, key and time"),
    ]
