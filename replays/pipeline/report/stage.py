"""Stage `report`: one self-contained page and its figures as JSON."""

from __future__ import annotations

import json

from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.look.document import LookedAt
from motorcade.replays.pipeline.report.before_after import steps_between, stills
from motorcade.replays.pipeline.report.film import film_of
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.pipeline.report.page import page
from motorcade.replays.pipeline.report.standing import standing_sheet
from motorcade.replays.pipeline.report.summary import summarise
from motorcade.replays.pipeline.report.viewer import Kept, embedded
from motorcade.replays.pipeline.report.words import headline
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.convergence import Convergence
from motorcade.replays.stages.values.errors import PathErrors
from motorcade.replays.stages.values.imu import UsedImu
from motorcade.replays.stages.values.integrity import Integrity
from motorcade.replays.stages.values.marker_poses import MarkerPoses
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths
from motorcade.replays.stages.values.report import ReportFiles
from motorcade.replays.stages.values.view import OverlayVideo, PlacedCharacter


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
