"""Stage `report`: its figures as JSON, and one HTML page; what is large lies beside it."""

from __future__ import annotations

import base64
import json
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import kernels
from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.look.document import LookedAt
from motorcade.replays.pipeline.report.before_after import Stills, steadiness, steps_between, stills
from motorcade.replays.pipeline.report.film import FilmView, film_of, standing_sheet
from motorcade.replays.pipeline.report.findings import Findings, told_paths
from motorcade.replays.pipeline.report.pictures import sections
from motorcade.replays.pipeline.report.summary import (
    LEFT_AS_IT_WAS,
    heading,
    shown_columns,
    shown_value,
    summarise,
)
from motorcade.replays.pipeline.report.viewer import Kept, Viewer, embedded
from motorcade.replays.pipeline.report.words import (
    errors_caption,
    headline,
    lead,
    next_steps,
    parameters,
    stages_caption,
    tiles,
    to_mend,
)
from motorcade.replays.stages.values.camera_poses import CameraPoses, MarkerPoses
from motorcade.replays.stages.values.errors import Integrity, PathErrors, ReportFiles
from motorcade.replays.stages.values.inertial import Convergence, UsedImu
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths
from motorcade.replays.stages.values.view import OverlayVideo, PlacedCharacter
from motorcade.replays.web.pages import page_environment


def report(
    recording: Recording,
    camera_poses: CameraPoses,
    imu: UsedImu,
    fused: FusedPath,
    smoothed: SmoothedPaths,
    integrity: Integrity,
    convergence: Convergence,
    errors: PathErrors,
    placed: PlacedCharacter,
    overlay: OverlayVideo | None,
    marker_poses: MarkerPoses | None = None,
) -> ReportFiles:
    """Write the page, with the viewer inside, and the films where they are small."""
    findings = Findings(
        recording=recording,
        camera_poses=camera_poses,
        imu=imu,
        fused=fused,
        smoothed=smoothed,
        integrity=integrity,
        convergence=convergence,
        errors=errors,
        placed=placed,
        overlay=overlay,
    )
    film = film_of(findings)
    summary = summarise(findings, film)
    marker_map = None if marker_poses is None else marker_poses.marker_map
    run = LookedAt(findings, marker_map, headline(findings))
    frames = 0 if overlay is None else overlay.frames
    kept = Kept(max(1, steps_between(frames)))
    viewer = embedded(run, kept)
    shown = stills(overlay, kept.pictures, run.recording.camera) if overlay and frames > 1 else None
    standing = standing_sheet(findings, kept.pictures)
    written = ReportFiles(
        new_file("report.html"), new_file("report.json"), viewer.footage, viewer.file
    )
    written.page.write_text(page(findings, viewer, shown, film, standing), encoding="utf-8")
    text = json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    written.summary.write_text(text, encoding="utf-8")
    return written


TEMPLATE = Path(__file__).with_name("template.html")
NO_VIDEO = (
    "this machine has no headless OpenGL. Debian and Ubuntu bring it with "
    "apt-get install libegl1 libgl1-mesa-dri; then run the same command again"
)
NO_PICTURES = "the recording holds corners of markers and no pictures to draw into"


def page(
    findings: Findings,
    viewer: Viewer,
    stills: Stills | None,
    film: FilmView | None,
    standing: bytes = b"",
) -> str:
    """The whole page as HTML text, with what `viewer` has inside and the stills of the film.

    `standing` is the sheet of what there is to stand on, where pictures were kept.
    """
    template = page_environment(TEMPLATE.parent).get_template(TEMPLATE.name)
    told = told_paths(findings)
    figures = {name: findings.errors.figures[name] for name in told}
    keys = shown_columns(figures)
    return template.render(
        name=findings.recording.name,
        lead=lead(findings),
        headline=headline(findings),
        viewer=viewer,
        shape=_shape(findings),
        film_caption=_film_caption(findings),
        tiles=tiles(findings, film),
        mend=to_mend(findings, _why_no_film(findings)),
        steps=next_steps(findings),
        stills=None if stills is None else _stills(stills),
        standing={
            "sheet": standing and _data_address("image/jpeg", standing),
            "places": findings.placed.choices,
        },
        steadiness=steadiness(findings),
        labels=told,
        errors_caption=errors_caption(findings) + _smoothing(findings),
        columns=[heading(key, figures, metric=findings.camera_poses.metric) for key in keys],
        rows=_rows(figures, keys),
        sections=sections(findings),
        stages=stages_caption(findings),
        has_truth=bool(findings.errors.against_truth),
        provenance=_provenance(),
    )


def _stills(stills: Stills) -> dict[str, str]:
    """Addresses of those that there are."""
    found = {"sheet": stills.sheet, "before": stills.before, "after": stills.after}
    return {name: _data_address("image/jpeg", data) if data else "" for name, data in found.items()}


def _shape(findings: Findings) -> float:
    """Width over height of the film."""
    camera = findings.camera_poses.camera or findings.recording.camera
    return camera.width / camera.height if camera is not None else 4.0 / 3.0


def _data_address(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def _why_no_film(findings: Findings) -> str:
    if findings.overlay is not None:
        return ""
    corners = isinstance(findings.recording.frames, CornerFrames)
    return NO_PICTURES if corners else NO_VIDEO


def _film_caption(findings: Findings) -> str:
    film = findings.overlay
    if film is None:
        return ""
    footage = {"original": "the pictures as filmed", "undistorted": "straightened pictures"}
    return (
        f"Drawn into {footage.get(film.footage, f'{film.footage} pictures')} along the "
        f"{film.along} path, standing on {film.stands_on}, in {film.lit_by}."
    )


def _smoothing(findings: Findings) -> str:
    method = findings.smoothed.method
    if findings.recording.truth is None and method is None:
        return ""
    if method is None:
        return LEFT_AS_IT_WAS
    return f" Smoothed by {method}: {parameters(findings.smoothed.parameters)}."


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
