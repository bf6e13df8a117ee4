"""Stage `report`: one self-contained page and its figures as JSON."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.recording import Recording
from motorcade.replays.report.findings import Findings
from motorcade.replays.report.page import page
from motorcade.replays.report.summary import summarise
from motorcade.replays.stages.camera.camera_poses import CameraPoses
from motorcade.replays.stages.errors import Errors
from motorcade.replays.stages.inertial.convergence import Convergence
from motorcade.replays.stages.inertial.fused import FusedPath
from motorcade.replays.stages.inertial.imu import Imu
from motorcade.replays.stages.smoothed import Smoothed
from motorcade.replays.stages.view.overlay import Overlay
from motorcade.replays.stages.view.placed import Placed


@dataclass(frozen=True)
class Report:
    """The page and the figures, as files."""

    page: Path
    summary: Path


def report(
    recording: Recording,
    camera_poses: CameraPoses,
    imu: Imu,
    fused: FusedPath,
    smoothed: Smoothed,
    convergence: Convergence,
    errors: Errors,
    placed: Placed,
    overlay: Overlay | None,
) -> Report:
    """Write the page, with the video inside where one could be made."""
    findings = Findings(
        recording=recording,
        camera_poses=camera_poses,
        imu=imu,
        fused=fused,
        smoothed=smoothed,
        convergence=convergence,
        errors=errors,
        placed=placed,
        overlay=overlay,
    )
    summary = summarise(findings)
    written = Report(new_file("report.html"), new_file("report.json"))
    written.page.write_text(page(findings), encoding="utf-8")
    text = json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    written.summary.write_text(text, encoding="utf-8")
    return written
