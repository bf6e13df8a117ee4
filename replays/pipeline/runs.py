"""Runs read back for other viewers: as glTF, for Rerun, or as a page of the browser.

A run's folder says what was run (`run.json`); its stages come out of its cache, or are computed
again where that is gone.

The page lies beside copies of the films.
"""

from __future__ import annotations

import json
import logging
import shlex
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cached_property, partial
from os.path import normpath
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Clip
from motorcade.animation.clip import MorphTrack
from motorcade.animation.formats import CameraPath, CharacterOnPath, write_cast_gltf
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import FileError, read_bounded
from motorcade.ga.progress import track
from motorcade.ga.stamps import GAP_STEPS, inside_gaps
from motorcade.ga.unfinished import unfinished
from motorcade.render import Performer
from motorcade.render.scene import ImageArray
from motorcade.render.video import read_frames
from motorcade.replays.engine.graph import GraphRun, parse_knobs
from motorcade.replays.io.files import copy_file, write_bytes
from motorcade.replays.io.readers.frames.views import ZoomedFrames
from motorcade.replays.io.readers.manifest.section import setting_from
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.described.people import with_people
from motorcade.replays.pipeline.job import pipeline_graph
from motorcade.replays.pipeline.look import LookedAt, look_of
from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.pipeline.report.summary import headline
from motorcade.replays.pipeline.results import trajectories
from motorcade.replays.stages.camera.offered import as_found, camera_of
from motorcade.replays.stages.view.acting import performers
from motorcade.replays.web.film import film_size, write_film
from motorcade.replays.web.page import InnerFilm, inner_film, view_page
from motorcade.tracking.cameras.camera import Camera

_LOG = logging.getLogger("motorcade.export")

MAX_LOG_BYTES = 1 << 24
POINTS_SHOWN = 200_000
_MESH_NS = 100_000_000
"""A figure's shape is a thousand times a pose: so far apart they are written for Rerun."""


@dataclass(frozen=True, eq=False)
class Shown:
    """What of a run can be looked at.

    Attributes:
        recording: its frames and camera.
        camera: without distortion.
        paths: `world_T_camera` by name; `path` is the one that the character is drawn along.
        path: see `paths`.
        cast: who stands there and what they do, by name.
        points_m: (N, 3) mapped points, world; N may be 0.
        max_gap_s: frames between poses that are farther apart are left out; None leaves out none.
    """

    recording: Recording
    camera: Camera
    paths: dict[str, Trajectory]
    path: Trajectory
    cast: dict[str, Performer]
    points_m: FloatArray
    max_gap_s: float | None = None

    @cached_property
    def frames_posed(self) -> IntArray:
        """Rows of the frames with poses: within the path, and in no gap of it that is too long.

        Raises:
            ValueError: no frame is left, or a gap that is not above 0.
        """
        stamps, known_ns = self.recording.frames.time_ns, self.path.time_ns
        inside = (stamps >= known_ns[0]) & (stamps <= known_ns[-1])
        usual_s = 1e-9 * float(np.median(np.diff(known_ns))) if len(known_ns) > 1 else 1.0
        longest_s = GAP_STEPS * usual_s if self.max_gap_s is None else self.max_gap_s
        invented = inside & inside_gaps(stamps, known_ns, longest_s)
        if np.any(invented):
            ends = "max_gap_s (--max-gap-s) leaves them out"
            _LOG.warning(
                "%d of %d frames lie in gaps of the path of more than %.3g s; %s",
                np.count_nonzero(invented),
                len(stamps),
                longest_s,
                ends if self.max_gap_s is None else "they are left out",
            )
        rows = np.flatnonzero(inside if self.max_gap_s is None else inside & ~invented)
        if not len(rows):
            raise ValueError(f"max_gap_s: expected frames with poses, got none at {longest_s:g} s")
        return rows

    def world_T_character(self, name: str) -> Trajectory:
        """Where a character stands over the path's time, and how large it is."""
        who, ends = self.cast[name], self.path.time_ns[[0, -1]]
        moved = [one.time_ns for one in (who.motion, who.ground_motion) if one is not None]
        stamps = np.unique(np.concatenate([ends, *moved]))
        stamps = stamps[(ends[0] <= stamps) & (stamps <= ends[1])]
        return Trajectory(stamps, who.world_T_character(stamps), "world", "character")

    def clip(self, name: str) -> Clip:
        """What a character does, from the path's first stamp on; clips begin at the first frame."""
        passed_ns = self.path.time_ns[0] - self.recording.frames.time_ns[0]
        return _from(self.cast[name].clip, 1e-9 * float(passed_ns))


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
    placed, camera_poses = run.outputs["placed"], run.outputs["camera_poses"]
    recording = as_found(recording, camera_poses.camera, camera_poses.depth_camera)
    shown = performers(placed)
    names = [part.name for part in placed.parts] or ["character"]
    return Shown(
        recording,
        camera_of(recording).undistorted(),
        trajectories(run),
        run.outputs["integrity"].drawn,
        dict(zip(names, shown, strict=True)),
        np.asarray(camera_poses.points, dtype=np.float64),
    )


def read_run(folder: Path, stage: str) -> tuple[Recording, GraphRun]:
    """The recording of a run, and the outputs of all that a stage needs and of itself.

    They come out of the run's cache; what that lost is computed again.

    Raises:
        ValueError: a folder that holds no run, one whose recording has changed since, or a
            recording without a camera.
        OSError: its recording is gone.
    """
    origin = read_origin(folder)
    recording = open_recording(origin.recording, origin.manifest).intact()
    recording = with_people(recording, origin.cache)
    if recording.digest() != origin.content:
        again = shlex.join([*origin.words(recording), "--out", str(folder)])
        raise ValueError(f"{folder}: its recording has changed since; run it again: {again}")
    if recording.camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    run = pipeline_graph().run(stage, {"recording": recording}, origin.cache, origin.knobs)
    return recording, run


@dataclass(frozen=True)
class RunOrigin:
    """What a folder's `run.json` says was run.

    Attributes:
        recording, manifest: files, the latter None where none was given.
        content: digest of the recording.
        settings: knobs as `stage.knob=value`, the manifest's before those of the command line.
        cache: folder of the stages' outputs.
    """

    recording: Path
    manifest: Path | None
    content: str
    settings: tuple[str, ...]
    cache: Path

    @property
    def knobs(self) -> dict[str, dict[str, Any]]:
        """The settings by stage; those left out have their stage's defaults."""
        return parse_knobs(self.settings, pipeline_graph())

    def words(self, recording: Recording) -> list[str]:
        """Of a command line that does it again, but for where to and who stands in it."""
        manifest = [] if self.manifest is None else ["--manifest", str(self.manifest)]
        own = [text for text in self.settings if text not in recording.settings]
        kept = [text for text in own if not text.startswith("placed.")]
        settings = [word for text in kept for word in ("--set", text)]
        return ["motorcade", "run", str(self.recording), *manifest, *settings]


def read_origin(folder: Path) -> RunOrigin:
    """What was run into a folder.

    Raises:
        ValueError: a folder that holds no run, or another file in the place of its `run.json`.
        OSError: it cannot be read.
    """
    file = folder / "run.json"
    if not file.exists():
        raise ValueError(
            f"{folder}: expected a folder that `motorcade run RECORDING --out {folder}` wrote; "
            "run.json is not there"
        )
    try:
        document = json.loads(read_bounded(file, MAX_LOG_BYTES))
        recording, manifest = (_stated(folder, document, key) for key in ("recording", "manifest"))
        if recording is None:
            raise ValueError("recording: expected a path, got none")
        cache = folder / normpath(str(document.get("cache_from_here", ".cache")))
        content, settings = str(document["content"]), _settings(folder, document)
        return RunOrigin(recording, manifest, content, settings, cache)
    except FileError:
        raise
    except (ValueError, KeyError, TypeError, RecursionError) as fault:
        raise ValueError(
            f"{file}: expected what `motorcade run` wrote of a recording, got another file: "
            f"{type(fault).__name__} {fault}"
        ) from fault


def _stated(folder: Path, document: dict[str, Any], name: str) -> Path | None:
    """Where a file that a run log names lies now; None where it names none."""
    if document[name] is None:
        return None
    return _lies(folder, document[name], document.get(f"{name}_from_here"))


def _settings(folder: Path, document: dict[str, Any]) -> tuple[str, ...]:
    """The settings of a run log, those that name files with where these lie now."""
    settings = tuple(map(str, document["settings"]))
    relative = tuple(map(str, document.get("settings_from_here", settings)))
    return tuple(
        setting_from(text, partial(_lies, folder, moved=from_here.partition("=")[2].strip()))
        for text, from_here in zip(settings, relative, strict=True)
    )


def _lies(folder: Path, stated: str, moved: str | None) -> Path:
    """Where a file of a run lies: where it lay, or where it was moved together with the run."""
    there = Path(stated)
    return there if there.exists() or moved is None else Path(normpath(folder.absolute() / moved))


def write_run_gltf(shown: Shown, path: Path) -> None:
    """Camera path, characters, props and map as one `.glb`; time zero is the path's first stamp.

    glTF has no word for what is seen for a while: all are there all the time.
    glTF knows neither principal points nor uneven pixels: the camera has the vertical field of
    view of the recording's, centred.

    Raises:
        ValueError: another suffix.
        OSError: the file cannot be written.
    """
    camera = shown.camera
    field_rad = 2.0 * float(np.arctan(0.5 * camera.height / camera.fy))
    points = thinned(shown.points_m)
    cast = [
        CharacterOnPath(name, performer.character, shown.clip(name), shown.world_T_character(name))
        for name, performer in shown.cast.items()
    ]
    lens = CameraPath(shown.path, field_rad, camera.width / camera.height)
    write_cast_gltf(path, cast, camera=lens, points_m=points if len(points) else None)


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
    for name, trajectory in shown.paths.items():
        places = trajectory.poses.translation_m.astype(np.float32)
        stream.log(f"world/paths/{name}", rr.LineStrips3D([places]), static=True)
    if len(shown.points_m):
        cloud = thinned(shown.points_m).astype(np.float32)
        stream.log("world/map", rr.Points3D(cloud), static=True)
    lens = shown.camera
    pinhole = rr.Pinhole(image_from_camera=lens.matrix, width=lens.width, height=lens.height)
    stream.log("world/camera", pinhole, static=True)
    _log_frames(rr, stream, shown)
    stream.disconnect()


def _log_frames(rr: Any, stream: Any, shown: Shown) -> None:
    """Every frame with a pose: image, pose, and the characters as they stand then.

    Images are one H.264 film without the lens's distortion, which frames refer to. What of a
    character does not change is logged once, and its shape ten times a second.
    """
    shown_ns = shown.recording.frames.time_ns[shown.frames_posed]
    _log_film(rr, stream, shown, shown.frames_posed)
    for name, performer in shown.cast.items():
        colors = np.rint(255 * performer.character.colors).astype(np.uint8)
        still = {"triangle_indices": performer.character.triangles, "vertex_colors": colors}
        stream.log(f"world/{name}", rr.Mesh3D.from_fields(**still), static=True)
    last_ns = -_MESH_NS
    for time_ns in map(int, shown_ns):
        stream.set_time("time", timestamp=np.datetime64(time_ns, "ns"))
        pose: Motor = shown.path.motors_at(np.int64(time_ns))
        stream.log(
            "world/camera",
            rr.Transform3D(translation=pose.translation_m, mat3x3=pose.rotor.as_matrix()),
        )
        video = rr.VideoFrameReference(nanoseconds=time_ns - int(shown_ns[0]))
        stream.log("world/camera/image", video)
        if time_ns - last_ns >= _MESH_NS:
            last_ns = time_ns
            _log_characters(rr, stream, shown, time_ns)


def _log_film(rr: Any, stream: Any, shown: Shown, rows: IntArray) -> None:
    """The frames' images as one film, whose first frame is at 0."""
    from motorcade.render.video import write_video

    camera, frames = shown.recording.camera, shown.recording.frames
    if camera is None:
        raise ValueError(f"{shown.recording.name}: expected a camera, got none")
    images = (camera.undistort_image(frames[int(row)].image()) for row in rows)
    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder) / "images.mp4"
        write_video(film, images, frames.time_ns[rows] - frames.time_ns[rows[0]])
        stream.log("world/camera/image", rr.AssetVideo(path=film), static=True)


def _log_characters(rr: Any, stream: Any, shown: Shown, time_ns: int) -> None:
    """The shape of every character at a time; nothing of those that are not there."""
    from motorcade.animation import skin

    time_s = (time_ns - int(shown.recording.frames.time_ns[0])) * 1e-9
    for name, performer in shown.cast.items():
        stand = performer.world_T_character(time_ns)
        places, normals = np.zeros((0, 3)), np.zeros((0, 3))
        if performer.seen(time_s):
            shaped = performer.character.shaped(performer.clip.morph_weights(time_s))
            vertices, turned = skin(shaped, performer.clip.at(time_s))
            places, normals = stand.apply(vertices), stand.rotor.apply(turned)
        moved = {
            "vertex_positions": places.astype(np.float32),
            "vertex_normals": normals.astype(np.float32),
        }
        stream.log(f"world/{name}", rr.Mesh3D.from_fields(**moved))


def _from(clip: Clip, passed_s: float) -> Clip:
    """A clip from a moment on, with that as its zero."""
    first = float(clip.time_s[0])
    if passed_s == 0.0 or len(clip.time_s) == 1:
        return clip
    left = clip.time_s - first - passed_s
    if clip.looped:  # all of it, begun elsewhere
        times = np.unique(np.concatenate([np.mod(left, clip.duration_s), [0.0, clip.duration_s]]))
    else:
        times = np.unique(np.concatenate([[0.0], left[left > 0.0]]))
    at = times + first + passed_s
    weights = clip.morph_weights(at)
    track = None if weights is None else MorphTrack(times, weights)
    return Clip(clip.name, times, clip.at(at), clip.looped, morphs=track)


def thinned(points_m: FloatArray) -> FloatArray:
    """At most `POINTS_SHOWN` of the points, evenly taken."""
    step = -(-len(points_m) // POINTS_SHOWN) or 1
    return points_m[::step]


INSIDE_BYTES = 24 * 2**20
"""Films of a page that are larger than this together lie beside it."""
SMALL_PX = 256
"""The longer side of the copy that is then still inside it."""


def open_look(folder: Path) -> LookedAt:
    """Read a run back for a page; stages that its cache lost are computed again.

    Raises:
        ValueError: a folder that holds no run, one whose recording has changed since, or a
            recording without a camera.
        OSError: its recording is gone.
    """
    recording, run = read_run(folder, "report")
    outputs = run.outputs
    named: dict[str, Any] = {one.name: outputs.get(one.name) for one in fields(Findings)}
    findings = Findings(**named | {"recording": recording})
    markers = outputs.get("marker_poses")
    marker_map = None if markers is None else markers.marker_map
    return LookedAt(findings, marker_map, headline(findings))


def write_view(folders: list[Path], out: Path) -> list[Path]:
    """Write the page of a run, or of two beside each other.

    Films that are long lie beside the page, named after it; whatever it asks for is there.

    Args:
        folders: one or two that `motorcade run` wrote.
        out: the page's name, which ends in `.html`.

    Returns:
        the page and the films beside it.

    Raises:
        ValueError: another ending or count, or what `open_look` refuses.
        OSError: a file cannot be read or written.
    """
    if out.suffix != ".html" or not 1 <= len(folders) <= 2:
        raise ValueError(
            f"write_view: expected one or two runs and a name that ends in .html, got "
            f"{len(folders)} and '{out.name}'"
        )
    runs = [open_look(folder) for folder in folders]
    names = [run.recording.name for run in runs]
    if len(set(names)) < len(names):  # told apart by where they lie
        names = [f"{name}, {one.resolve().name}" for name, one in zip(names, folders, strict=True)]
    out.parent.mkdir(parents=True, exist_ok=True)
    with unfinished(out.parent) as place:
        films = [_films(run, number, place) for number, run in enumerate(runs, 1)]
        beside = sum(path.stat().st_size for one in films for path in one.values()) > INSIDE_BYTES
        inner: list[InnerFilm] = []
        written: list[Path] = []
        looks: list[dict[str, Any]] = []
        for run, shown_as, clips in zip(runs, names, films, strict=True):
            named: list[dict[str, Any]] = []
            for name, path in clips.items() if beside else ():
                kept = out.with_name(f"{out.stem}-{path.name}")
                copy_file(path, kept)
                written.append(kept)
                named.append({"name": name, "src": kept.name})
            for name, path in (_small(run, clips) if beside else clips).items():
                inner.append(inner_film(path.stem, path))
                named.append({"name": name, "src": f"#{path.stem}"} | _size_of(run, name))
            looks.append(look_of(run, named) | {"name": shown_as})
        write_bytes(out, view_page(looks, inner).encode())
    return [out, *written]


def _small(run: LookedAt, clips: dict[str, Path]) -> dict[str, Path]:
    """A small copy of the footage for inside the page: browsers let no film that lies beside it
    into their graphics, where the camera's sign has its image. None where that is too large too.
    """
    if not clips:
        return {}
    path = clips["footage"].with_name(clips["footage"].name.replace("footage", "small"))
    stamps, (width, height) = run.recording.frames.time_ns, _size_of(run, "small")["size"]
    images = (image for _, image in read_frames(clips["footage"]))
    tracked = track(images, "small images copied", len(stamps))
    write_film(path, tracked, stamps, (width, height))
    return {"small": path} if path.stat().st_size <= INSIDE_BYTES else {}


def _size_of(run: LookedAt, name: str) -> dict[str, Any]:
    """Pixels of the small copy; others are as large as the footage."""
    camera = run.recording.camera
    assert camera is not None  # `look_of` refuses that before
    return {"size": film_size(camera.width, camera.height, SMALL_PX)} if name == "small" else {}


def _films(run: LookedAt, number: int, place: Path) -> dict[str, Path]:
    """Copies of a run's footage, and of its film where it has one, that can be sought quickly."""
    if not run.has_images:
        return {}
    stamps = run.recording.frames.time_ns
    films = {"footage": _footage(run)}
    zooms = isinstance(run.recording.frames, ZoomedFrames)  # the film has another focal length
    if run.findings.overlay is not None and not zooms:
        films["overlay"] = _overlay(run)
    paths = {}
    for name, images in films.items():
        paths[name] = place / f"{name}-{number}.mp4"
        copied = track(images, f"images of the {name} copied", len(stamps))
        write_film(paths[name], copied, stamps)
    return paths


def _footage(run: LookedAt) -> Iterator[ImageArray]:
    for frame in run.recording.frames:
        yield frame.image()


def _overlay(run: LookedAt) -> Iterator[ImageArray]:
    """The run's film, less the column or row that H.264 had to add."""
    film, camera = run.findings.overlay, run.recording.camera
    assert film is not None  # asked for by `_films` alone
    assert camera is not None  # `look_of` refuses that before
    for _, image in read_frames(film.path):
        yield image[: camera.height, : camera.width]
