"""The pipeline: recording in, trajectories, video and error report out.

recording ─┬─ camera_poses ─┬─ fused ── smoothed ─┬─ errors ──────────┬─ report
           └─ imu ──────────┘                     └─ placed ─ overlay ┄┘
"""

from __future__ import annotations

import json
import logging
import platform
import re
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from motorcade import __version__
from motorcade.ga import Trajectory
from motorcade.replays.characters.acting import MANNEQUIN, character_named, clip_named
from motorcade.replays.engine.graph import Graph, Run
from motorcade.replays.engine.knobs import parse_knobs
from motorcade.replays.files.atomic import copy_file, sweep_unfinished, write_bytes
from motorcade.replays.files.trajectories import write_trajectory
from motorcade.replays.recording import Recording, open_recording
from motorcade.replays.report.summary import without_nan
from motorcade.replays.stages.camera.camera_poses import camera_poses
from motorcade.replays.stages.errors import errors
from motorcade.replays.stages.inertial.convergence import convergence
from motorcade.replays.stages.inertial.fused import fused
from motorcade.replays.stages.inertial.imu import imu
from motorcade.replays.stages.report import report
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.stages.view.overlay import overlay
from motorcade.replays.stages.view.placed import placed

log = logging.getLogger("motorcade.pipeline")

OUR_TRAJECTORY = re.compile(r"(camera_poses|fused|smoothed)_[a-z_]+\.tum")
STAGES = (camera_poses, imu, fused, smoothed, convergence, errors, placed, overlay, report)


@dataclass(frozen=True)
class Job:
    """One recording to run: where it lies, where results go, how far, with which settings."""

    recording: Path
    out: Path
    manifest: Path | None = None
    cache: Path | None = None
    until: str = "report"
    settings: tuple[str, ...] = ()


def pipeline() -> Graph:
    """The stage graph of every run."""
    return Graph(STAGES, {"recording": Recording})


def run_job(job: Job) -> dict[str, Any]:
    """Run a job and leave its results in `job.out`; returns the report as a dictionary.

    Everything is checked before anything is computed, and earlier results stay as they are until
    the new ones are complete. Raises ValueError or OSError with one line that says what is wrong.
    """
    graph = pipeline()
    recording = open_recording(job.recording, job.manifest)
    knobs = parse_knobs((*recording.settings, *job.settings), graph)
    acting = knobs.get("placed", {})
    if "placed" in graph.needed(job.until) and {"character", "clip"} & acting.keys():
        _check_acting(acting)
    require_writable(job.out)
    recording = recording.intact()
    for told in recording.damaged:
        log.warning("left out: %s", told)
    run = graph.run(job.until, {"recording": recording}, job.cache or job.out / ".cache", knobs)
    return export(run, job.out, about(job, recording))


def _check_acting(knobs: Mapping[str, Any]) -> None:
    """ValueError where a character or clip that is asked for is not there, before any tracking."""
    character = character_named(str(knobs.get("character", MANNEQUIN)))
    if knobs.get("clip") is not None:
        clip_named(character, knobs["clip"])


def require_writable(folder: Path) -> None:
    """Make `folder` where it is missing; OSError naming it where nothing can be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(
            f"{folder}: results cannot be written there ({error.strerror}); choose another --out"
        ) from error


def about(job: Job, recording: Recording) -> dict[str, Any]:
    """What was run: enough to run it again."""
    return {
        "recording": str(job.recording),
        "manifest": None if job.manifest is None else str(job.manifest),
        "content": recording.digest(),
        "until": job.until,
        "settings": [*recording.settings, *job.settings],
        "motorcade": __version__,
        "python": platform.python_version(),
    }


def export(run: Run, out: Path, about_it: dict[str, Any]) -> dict[str, Any]:
    """Copy what a run computed into `out`, each file at once or not at all.

    Files of an earlier run that this one did not make are removed, so that what lies in `out`
    belongs together. Returns the report, or the account of a run that stopped before it.
    """
    account = about_it | {
        "stages": {record.stage: asdict(record) for record in run.records},
        "unavailable": dict(run.unavailable),
    }
    if "errors" in run.outputs:
        judged = run.outputs["errors"]
        account |= {"align": judged.align, "errors": without_nan(judged.figures)}
    film, pages = run.outputs.get("overlay"), run.outputs.get("report")
    poses = run.outputs.get("camera_poses")
    summary = account if pages is None else json.loads(pages.summary.read_text(encoding="utf-8"))
    written = set()
    for folder in (out, out / "trajectories"):
        if folder.is_dir():
            sweep_unfinished(folder)
    for name, trajectory in trajectories(run).items():
        written.add(out / "trajectories" / f"{name}.tum")
        write_trajectory(trajectory, out / "trajectories" / f"{name}.tum")
    sources = {"overlay.mp4": film and film.path}
    sources |= {"marker_map.json": poses and poses.marker_map}
    sources |= {"slam_map.npz": poses and poses.slam_map}
    sources |= {"report.html": pages and pages.page, "report.json": pages and pages.summary}
    for name, source in sources.items():
        if source is not None:
            written.add(out / name)
            copy_file(source, out / name)
    write_bytes(out / "run.json", (json.dumps(account, indent=2) + "\n").encode())
    for path in [out / name for name in sources] + sorted((out / "trajectories").glob("*.tum")):
        if path not in written and (path.name in sources or OUR_TRAJECTORY.fullmatch(path.name)):
            path.unlink(missing_ok=True)
    return dict(summary)


def trajectories(run: Run) -> dict[str, Trajectory]:
    """`<stage>_<representation>` of every trajectory that a run computed."""
    named = {}
    if "camera_poses" in run.outputs:
        named["camera_poses_motor"] = run.outputs["camera_poses"].measurements.trajectory
    if "fused" in run.outputs:
        named["fused_motor"] = run.outputs["fused"].trajectory
    if "smoothed" in run.outputs:
        for representation, trajectory in run.outputs["smoothed"].trajectories.items():
            named[f"smoothed_{representation}"] = trajectory
    return named
