"""Runs for other viewers: everything that a run placed in its world, as glTF or for Rerun.

A run's folder says what was run (`run.json`); its stages come out of its cache, or are computed
again where that is gone.
"""

from __future__ import annotations

import json
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Character, Clip, Placement
from motorcade.animation.formats import CameraPath, write_gltf
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import FileError, read_bounded
from motorcade.replays.characters.performers import performers
from motorcade.replays.engine.graph import GraphRun
from motorcade.replays.engine.knobs import parse_knobs
from motorcade.replays.pipeline import pipeline_graph
from motorcade.replays.readers.opening import open_recording
from motorcade.replays.recording import Recording
from motorcade.replays.results import trajectories
from motorcade.replays.stages.camera.as_found import as_found
from motorcade.replays.stages.camera.offered import camera_of
from motorcade.tracking.cameras.camera import Camera

log = logging.getLogger("motorcade.export")

MAX_LOG_BYTES = 1 << 24
POINTS_SHOWN = 200_000


@dataclass(frozen=True, eq=False)
class Shown:
    """What of a run can be looked at.

    Attributes:
        recording: its frames and camera.
        camera: without distortion.
        paths: `world_T_camera` by name; `path` is the one that the character is drawn along.
        path: see `paths`.
        character: who stands there.
        clip: what it does.
        placement: where it stands at first.
        ground_motion: what moves it along from there, None where nothing does.
        points_m: (N, 3) mapped points, world; N may be 0.
    """

    recording: Recording
    camera: Camera
    paths: dict[str, Trajectory]
    path: Trajectory
    character: Character
    clip: Clip
    placement: Placement
    ground_motion: Trajectory | None
    points_m: FloatArray

    @property
    def world_T_character(self) -> Trajectory:
        """Where the character stands over the path's time."""
        stand = self.placement.world_T_character
        if self.ground_motion is None:
            ends = self.path.time_ns[[0, -1]]
            return Trajectory(ends, Motor.stack([stand, stand]), "world", "character")
        return self.ground_motion.transformed_by(right=stand, child="character")


def open_run(folder: Path) -> Shown:
    """Read a run back.

    Args:
        folder: that `motorcade run --out` or `motorcade demo --out` wrote.

    Raises:
        ValueError: a folder that holds no run, one whose recording has changed since, or a
            recording without a camera.
        OSError: its recording is gone.
    """
    recording, run = read_run(folder, "placed")
    placed, found = run.outputs["placed"], run.outputs["camera_poses"]
    recording = as_found(recording, found.camera, found.depth_camera)
    shown = performers(placed)
    if len(shown) > 1:
        first = placed.parts[0].name
        log.warning("of %d characters the first is exported: '%s'", len(shown), first)
    return Shown(
        recording,
        camera_of(recording).undistorted(),
        trajectories(run),
        run.outputs["integrity"].drawn,
        shown[0].character,
        shown[0].clip,
        shown[0].placement,
        placed.ground_motion,
        np.asarray(found.points, dtype=np.float64),
    )


def read_run(folder: Path, stage: str) -> tuple[Recording, GraphRun]:
    """The recording of a run, and the outputs of all that a stage needs and of itself.

    They come out of the run's cache; what that lost is computed again.

    Raises:
        ValueError: a folder that holds no run, one whose recording has changed since, or a
            recording without a camera.
        OSError: its recording is gone.
    """
    origin = _read_origin(folder)
    recording = open_recording(origin.recording, origin.manifest).intact()
    if recording.digest() != origin.content:
        raise ValueError(f"{folder}: its recording has changed since; run it again")
    if recording.camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    graph = pipeline_graph()
    knobs = parse_knobs(origin.settings, graph)
    return recording, graph.run(stage, {"recording": recording}, folder / ".cache", knobs)


@dataclass(frozen=True)
class _Origin:
    """What a folder's `run.json` says was run."""

    recording: Path
    manifest: Path | None
    content: str
    settings: list[str]


def _read_origin(folder: Path) -> _Origin:
    file = folder / "run.json"
    if not file.exists():
        raise ValueError(
            f"{folder}: expected a folder that `motorcade run` wrote; run.json is not there"
        )
    try:
        told = json.loads(read_bounded(file, MAX_LOG_BYTES))
        manifest, settings = told["manifest"], list(map(str, told["settings"]))
        place = None if manifest is None else Path(manifest)
        return _Origin(Path(told["recording"]), place, str(told["content"]), settings)
    except FileError:
        raise
    except (ValueError, KeyError, TypeError, RecursionError) as fault:
        raise ValueError(
            f"{file}: expected what `motorcade run` wrote of a recording, got another file: "
            f"{type(fault).__name__} {fault}"
        ) from fault


def write_run_gltf(shown: Shown, path: Path) -> None:
    """Camera path, character and map as one `.glb`; time zero is the path's first stamp.

    glTF knows neither principal points nor uneven pixels: the camera has the vertical field of
    view of the recording's, centred.

    Raises:
        ValueError: another suffix.
        OSError: the file cannot be written.
    """
    camera = shown.camera
    field_rad = 2.0 * float(np.arctan(0.5 * camera.height / camera.fy))
    stands = shown.world_T_character
    grown = Similarity.from_motor_scale(stands.motors, np.float64(shown.placement.scale))
    points = _thinned(shown.points_m)
    write_gltf(
        path,
        shown.character,
        [shown.clip],
        world_T_character=Trajectory(stands.time_ns, grown),
        camera=CameraPath(shown.path, field_rad, camera.width / camera.height),
        points_m=points if len(points) else None,
    )


def write_rrd(shown: Shown, path: Path) -> None:
    """The run as a recording of Rerun: paths, frames with their camera, character, map.

    Raises:
        RuntimeError: the package `rerun-sdk` is missing; the extra `viewer` brings it.
        ValueError: another suffix than `.rrd`.
        OSError: the file cannot be written.
    """
    if path.suffix != ".rrd":
        raise ValueError(f"write_rrd(path): expected a name that ends in .rrd, got '{path.name}'")
    try:
        import rerun as rr
    except ModuleNotFoundError as missing:
        raise RuntimeError(
            "writing .rrd needs the Python package rerun-sdk, which is not installed; "
            'pip install "motorcade[viewer]" brings it'
        ) from missing
    stream = rr.RecordingStream("motorcade")
    stream.save(str(path))
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for name, one in shown.paths.items():
        places = one.poses.translation_m.astype(np.float32)
        stream.log(f"world/paths/{name}", rr.LineStrips3D([places]), static=True)
    if len(shown.points_m):
        cloud = _thinned(shown.points_m).astype(np.float32)
        stream.log("world/map", rr.Points3D(cloud), static=True)
    lens = shown.camera
    pinhole = rr.Pinhole(image_from_camera=lens.matrix, width=lens.width, height=lens.height)
    stream.log("world/camera", pinhole, static=True)
    _log_frames(rr, stream, shown)
    stream.disconnect()


def _log_frames(rr: Any, stream: Any, shown: Shown) -> None:
    """Every frame within the path: picture, pose, and the character as it stands then."""
    from motorcade.animation import skin

    camera = shown.recording.camera
    if camera is None:
        raise ValueError(f"{shown.recording.name}: expected a camera, got none")
    first_ns, last_ns = int(shown.path.time_ns[0]), int(shown.path.time_ns[-1])
    colors, stands = shown.character.colors, shown.world_T_character
    span_ns = int(stands.time_ns[0]), int(stands.time_ns[-1])
    for frame in shown.recording.frames:
        if not first_ns <= frame.time_ns <= last_ns:
            continue
        stream.set_time("time", timestamp=np.datetime64(int(frame.time_ns), "ns"))
        pose: Motor = shown.path.motors_at(np.int64(frame.time_ns))
        stream.log(
            "world/camera",
            rr.Transform3D(translation=pose.translation_m, mat3x3=pose.rotor.as_matrix()),
        )
        picture = camera.undistort_image(frame.image())
        stream.log("world/camera/picture", rr.Image(picture).compress(jpeg_quality=85))
        stand = stands.motors_at(np.clip(np.int64(frame.time_ns), *span_ns))
        vertices, normals = skin(shown.character, shown.clip.at((frame.time_ns - first_ns) * 1e-9))
        stream.log(
            "world/character",
            rr.Mesh3D(
                vertex_positions=stand.apply(shown.placement.scale * vertices).astype(np.float32),
                vertex_normals=stand.rotor.apply(normals),
                triangle_indices=shown.character.triangles,
                vertex_colors=None if colors is None else np.rint(255 * colors).astype(np.uint8),
            ),
        )


def _thinned(points_m: FloatArray) -> FloatArray:
    """At most `POINTS_SHOWN` of the points, evenly taken."""
    step = -(-len(points_m) // POINTS_SHOWN) or 1
    return points_m[::step]
