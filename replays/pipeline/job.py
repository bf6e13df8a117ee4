"""The pipeline: recording in, trajectories, video and error report out.

board_poses ─────┐
marker_poses ────┤
slam_poses ──────┼ tracked ─ camera_poses ┬─ fused ─ smoothed ─ integrity ┬─ errors ────────┬ report
simulated_poses ─┤                   imu ─┘                               └ placed ─ overlay┄┘
turning_poses ───┘
"""

from __future__ import annotations

import logging
import platform
from collections.abc import Mapping
from dataclasses import dataclass, replace
from os.path import relpath
from pathlib import Path
from typing import Any

from motorcade import __version__
from motorcade.ga.files import off_record
from motorcade.replays.engine.graph import Graph, parse_knobs
from motorcade.replays.engine.stage import first_of
from motorcade.replays.io.readers.manifest.cast import NOBODY, read_cast
from motorcade.replays.io.readers.manifest.section import FILE_KNOBS, setting_from
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.described.describing import (
    OpenedRecording,
    description_graph,
    open_described,
    parted,
    summary,
)
from motorcade.replays.pipeline.described.people import with_people
from motorcade.replays.pipeline.report.page import report
from motorcade.replays.pipeline.results import OWN_MANIFEST, require_writable, write_results
from motorcade.replays.stages.camera.board_poses import board_poses
from motorcade.replays.stages.camera.camera_poses import camera_poses
from motorcade.replays.stages.camera.marker_poses import marker_poses
from motorcade.replays.stages.camera.simulated_poses import simulated_poses
from motorcade.replays.stages.camera.slam_poses import slam_poses
from motorcade.replays.stages.camera.turning_poses import turning_poses
from motorcade.replays.stages.errors import errors
from motorcade.replays.stages.inertial.convergence import convergence
from motorcade.replays.stages.inertial.fused import fused
from motorcade.replays.stages.inertial.imu import imu
from motorcade.replays.stages.integrity import integrity
from motorcade.replays.stages.smoothed import smoothed
from motorcade.replays.stages.view.acted import check_scene
from motorcade.replays.stages.view.acting import (
    MANNEQUIN,
    character_named,
    check_cast,
    clip_named,
)
from motorcade.replays.stages.view.overlay import overlay
from motorcade.replays.stages.view.placed import SCENE_SAYS, placed
from motorcade.tracking import TrackingError
from motorcade.tracking.shots import find_shots

log = logging.getLogger("motorcade.pipeline")
stage_log = logging.getLogger("motorcade.graph")

NOTHING = FILE_KNOBS["placed.scene"]

TRACKED = first_of(
    "tracked",
    skips=TrackingError,
    board=board_poses,
    markers=marker_poses,
    slam=slam_poses,
    simulated=simulated_poses,
    turning=turning_poses,
)
# All that can run; a run computes what its last stage needs, by default the report.
STAGES = (
    TRACKED,  # where the camera was, in one of five ways
    camera_poses,  # the same, less blackouts
    imu,  # the recorded inertial stream, where there is one
    fused,  # one path between frames and through blackouts
    smoothed,  # the same without noise, in every representation
    integrity,  # whether all that agrees
    convergence,  # how the filter recovers from a wrong start
    errors,  # every path against the ground truth
    placed,  # who stands where
    overlay,  # the video
    report,  # the page and its figures
)


@dataclass(frozen=True)
class Job:
    """One recording to run: where it lies, where results go, how far, with which settings.

    `scene` is a scene file to set into it; see stage `placed`.

    >>> from pathlib import Path
    >>> from motorcade.replays import Job
    >>> job = Job(Path("V1_01_easy"), out=Path("out"), settings=("tracked.by=simulated",))
    >>> job.until
    'report'
    """

    recording: Path
    out: Path
    manifest: Path | None = None
    cache: Path | None = None
    until: str = "report"
    settings: tuple[str, ...] = ()
    scene: Path | None = None

    def all_settings(self, recording: Recording) -> tuple[str, ...]:
        """The recording's own settings and the job's; a scene says in place of the recording's."""
        own = recording.settings
        words = parted(self.settings)[1]
        if self.scene is not None:
            said = tuple(f"placed.{name}=" for name in SCENE_SAYS)
            own = tuple(one for one in own if not one.replace(" ", "").startswith(said))
            words = (*words, f"placed.scene={self.scene}")
        return tuple(
            setting_from(text, lambda file: Path(file).absolute()) for text in (*own, *words)
        )


def pipeline_graph() -> Graph:
    """The stage graph of every run.

    >>> from motorcade.replays import pipeline_graph
    >>> graph = pipeline_graph()
    >>> list(graph.stages["fused"].inputs)
    ['recording', 'camera_poses', 'imu']
    >>> sorted(graph.stages["smoothed"].knobs)
    ['method', 'order', 'parameters', 'representations', 'window_s']
    """
    return Graph(STAGES, {"recording": Recording})


def shot_job(job: Job, number: int, out: Path) -> Job:
    """The job for one shot of its recording, counted from 1."""
    if number < 1:
        raise ValueError(f"--shot: expected a number from 1 on, got {number}")
    return replace(job, out=out, settings=(*job.settings, f"described.shot={number}"))


def shot_jobs(job: Job) -> list[Job]:
    """A job for each shot of its recording, in folders of their own."""
    with off_record():
        frames = open_recording(job.recording, job.manifest).intact().frames
        shots = find_shots(frame.gray() for frame in frames).shots
    return [shot_job(job, row, job.out / f"shot-{row}") for row in range(1, len(shots) + 1)]


def require_integrity(until: str) -> None:
    """Refuse a run that stops before anything judges whether its result can be relied on.

    Raises:
        ValueError: no stage of that name, or one that does not need `integrity`.
    """
    if "integrity" not in pipeline_graph().needed(until):
        raise ValueError(
            f"--strict: expected a run up to integrity or a later stage, got one until {until}, "
            "where nothing has been checked yet"
        )


def run_job(job: Job) -> dict[str, Any]:
    """Run a job and leave its results in `job.out`; returns the report as a dictionary.

    Everything is checked before anything is computed, and earlier results stay as they are until
    the new ones are complete. Raises ValueError or OSError with one line that says what is wrong.
    """
    graph, cache = pipeline_graph(), job.cache or job.out / ".cache"
    with off_record():  # the recording's digest and settings cover all that is read of it
        recording = open_recording(job.recording, job.manifest)
    stage_log.info("%s", recording.summary)
    description_knobs = parse_knobs(parted(job.settings)[0], description_graph())
    knobs = parse_knobs(job.all_settings(recording), graph)
    if "placed" in graph.needed(job.until):
        _check_character(knobs.get("placed", {}))
    require_writable(job.out)
    with off_record():
        opened = open_described(recording, job.manifest, cache, description_knobs)
    recording = opened.recording
    settings = job.all_settings(recording)
    knobs = parse_knobs(settings, graph)
    with off_record():
        recording = with_people(recording.intact(), cache)
    opened = replace(opened, recording=recording)
    for damage in recording.damaged:
        log.warning("left out: %s", damage)
    run = graph.run(job.until, {"recording": recording}, cache, knobs)
    return write_results(run, job.out, _about(job, opened, settings), opened.manifest)


def _check_character(knobs: Mapping[str, Any]) -> None:
    """ValueError where a character or clip that is asked for is not there, before any tracking."""
    if str(knobs.get("cast", NOBODY)) != NOBODY:
        check_cast(read_cast(knobs["cast"]))
    if str(knobs.get("scene", NOTHING)) != NOTHING:
        check_scene(knobs["scene"])
    if {"character", "clip", "up", "front"} & knobs.keys():
        axes = knobs.get("up"), knobs.get("front")
        character = character_named(str(knobs.get("character", MANNEQUIN)), *axes)
        if knobs.get("clip") is not None:
            clip_named(character, knobs["clip"])


def _about(job: Job, opened: OpenedRecording, settings: tuple[str, ...]) -> dict[str, Any]:
    """What was run: enough to run it again, from wherever that is done, or once moved."""
    manifest = job.manifest if opened.manifest is None else job.out / OWN_MANIFEST
    return {
        "recording": str(job.recording.absolute()),
        "recording_from_here": relpath(job.recording, job.out),
        "manifest": None if manifest is None else str(manifest.absolute()),
        "manifest_from_here": None if manifest is None else relpath(manifest, job.out),
        "cache_from_here": relpath(job.cache or job.out / ".cache", job.out),
        "content": opened.recording.digest(),
        "until": job.until,
        "settings": list(settings),
        "settings_from_here": [
            setting_from(text, lambda file: Path(relpath(file, job.out))) for text in settings
        ],
        "motorcade": __version__,
        "python": platform.python_version(),
        **summary(opened),
    }
