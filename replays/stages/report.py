"""Stage `report`: one self-contained page and its figures as JSON."""

from __future__ import annotations

import json

from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.recording import Recording
from motorcade.replays.report.findings import Findings
from motorcade.replays.report.page import page
from motorcade.replays.report.summary import summarise
from motorcade.replays.values.camera_poses import CameraPoses
from motorcade.replays.values.convergence import Convergence
from motorcade.replays.values.errors import PathErrors
from motorcade.replays.values.imu import UsedImu
from motorcade.replays.values.integrity import Integrity
from motorcade.replays.values.paths import FusedPath, SmoothedPaths
from motorcade.replays.values.report import ReportFiles
from motorcade.replays.values.view import OverlayVideo, PlacedCharacter


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
) -> ReportFiles:
    """Write the page, with the video inside where one could be made."""
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
    summary = summarise(findings)
    written = ReportFiles(new_file("report.html"), new_file("report.json"))
    written.page.write_text(page(findings), encoding="utf-8")
    text = json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    written.summary.write_text(text, encoding="utf-8")
    return written
