"""The pipeline: recording in, trajectories, video and error report out.

recording ─┬─ camera_poses ─┬─ fused ── smoothed ─┬─ errors ──────────┬─ report
           └─ imu ──────────┘                     └─ placed ─ overlay ┄┘
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from motorcade.ga import Trajectory
from motorcade.replays.atomic import copy_file, write_bytes
from motorcade.replays.graph import Graph, Run
from motorcade.replays.knobs import parse_knobs
from motorcade.replays.recording import Recording, open_recording
from motorcade.replays.stages.camera_poses import camera_poses
from motorcade.replays.stages.convergence import convergence
from motorcade.replays.stages.errors import errors
from motorcade.replays.stages.fused import fused
from motorcade.replays.stages.imu import imu
from motorcade.replays.stages.overlay import overlay
from motorcade.replays.stages.placed import placed
from motorcade.replays.stages.report import report
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.trajectory_files import write_trajectory

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
    graph.needed(job.until)
    require_writable(job.out)
    recording.check()
    run = graph.run(job.until, {"recording": recording}, job.cache or job.out / ".cache", knobs)
    return export(run, job.out)


def run_jobs(
    jobs: Sequence[Job], executor: str
) -> Iterator[tuple[Job, dict[str, Any] | BaseException]]:
    """Run several jobs; yields each with its report or with the error that ended it.

    `executor` is "local" (one after another) or "processes" (one a core). One job's failure
    never ends the others.
    """
    if executor == "local":
        for job in jobs:
            try:
                yield job, run_job(job)
            except (ValueError, OSError, RuntimeError) as error:
                yield job, error
        return
    # A fresh interpreter each: OpenGL contexts and threads do not survive a fork.
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        yield from _gather(jobs, pool)


def _gather(
    jobs: Sequence[Job], pool: Executor
) -> Iterator[tuple[Job, dict[str, Any] | BaseException]]:
    running: dict[Future[dict[str, Any]], Job] = {pool.submit(run_job, job): job for job in jobs}
    for future in as_completed(running):
        error = future.exception()
        yield running[future], future.result() if error is None else error


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


def export(run: Run, out: Path) -> dict[str, Any]:
    """Copy what a run computed into `out`, each file at once or not at all."""
    for name, trajectory in trajectories(run).items():
        write_trajectory(trajectory, out / "trajectories" / f"{name}.tum")
    write_bytes(out / "run.json", (json.dumps(account(run), indent=2) + "\n").encode())
    film = run.outputs.get("overlay")
    if film is not None:
        copy_file(film.path, out / "overlay.mp4")
    pages = run.outputs.get("report")
    if pages is None:
        return account(run)
    copy_file(pages.page, out / "report.html")
    copy_file(pages.summary, out / "report.json")
    summary: dict[str, Any] = json.loads(pages.summary.read_text(encoding="utf-8"))
    return summary


def account(run: Run) -> dict[str, Any]:
    """How every stage came to its output: key, knobs, seconds, and what could not run here."""
    stages = {record.stage: asdict(record) for record in run.records}
    return {"stages": stages, "unavailable": dict(run.unavailable)}


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
