"""A run's desk: what `motorcade author` opens, its images, its first scene, and its film.

A run's scene is taken as it is. A character or a cast becomes objects on the run's own ground,
without what a scene has no words for: who turned to somebody, or made room for another. The film
is drawn by the page's own command line, in a process that ends with the server.
"""

from __future__ import annotations

import logging
import re
import shlex
import subprocess
import sys
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from os.path import relpath
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from motorcade.animation.authoring import Scene, read_scene, scene_of, scene_text
from motorcade.animation.authoring.fields import anchor_json
from motorcade.ga import Motor
from motorcade.replays.io.readers.manifest.cast import (
    MANNEQUIN,
    NOBODY,
    Cast,
    CastMember,
    file_of,
    read_cast,
)
from motorcade.replays.io.recording import FrameSequence
from motorcade.replays.pipeline.look import shown_camera
from motorcade.replays.pipeline.packing import packed, rows_of
from motorcade.replays.stages.values.view import PlacedCharacter, PlayedPart
from motorcade.replays.stages.view.acted import cast_as
from motorcade.replays.stages.view.acting import IDLE, character_named
from motorcade.replays.studio.filmed import Filmed, PlayedScene, open_filmed, spoken
from motorcade.replays.studio.messages import Answer
from motorcade.replays.studio.props import GROUND, Props, files_beside
from motorcade.replays.studio.session import EditingSession, SceneView
from motorcade.replays.studio.write_ahead import SceneHistory, WriteAheadLog

LONGEST_S = 3600.0
FILM_NAME = "overlay.mp4"
_START = (
    "import os, sys; os.nice(5); from motorcade.replays.cli import main; "
    "sys.exit(main(sys.argv[1:]))"
)
_SHARE = re.compile(r"drawing: .* (\d+) %")
_LONGEST_LINE = 300
_drawn_now = threading.Lock()
"""Held while a film is being drawn."""


@dataclass
class FilmDrawing:
    """The film of one scene. May be asked by several threads.

    Args:
        words: of the command line that draws it, the program's name first.
        folder: that it leaves the film in.
    """

    words: Sequence[str]
    folder: Path
    _process: subprocess.Popen[str] | None = None
    _said: str = ""
    _share: float | None = None
    _failed: str | None = None
    _scene: Scene | None = None
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def film(self) -> Path | None:
        """The film that was drawn last, in this session or before; None without."""
        path = self.folder / FILM_NAME
        return path if path.is_file() and not path.is_symlink() else None

    def start(self, scene: Scene) -> None:
        """Begin to draw a scene, whose file is written.

        Raises ValueError: a film is being drawn already, or there is nobody in the scene; OSError:
        no process can be started.
        """
        if all(scene.part(name).kind == "group" for name in scene.parents):
            raise ValueError("Nobody is in the scene yet.")
        if not _drawn_now.acquire(blocking=False):
            raise ValueError("A film is being drawn already.")
        try:
            process = subprocess.Popen(
                [sys.executable, "-c", _START, *self.words[1:]],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
            )
        except BaseException:
            _drawn_now.release()
            raise
        with self._lock:
            self._process, self._scene = process, scene
            self._said, self._share, self._failed = "opening the recording", None, None
        threading.Thread(target=self._follow, args=(process,), daemon=True).start()

    def stop(self, *, wait: bool = False) -> None:
        """End what is being drawn, if anything is; at once, where one waits for it."""
        with self._lock:
            process = self._process
        if process is not None and wait:
            process.kill()
            process.wait()
        elif process is not None:
            process.terminate()

    def state(self, scene: Scene) -> dict[str, Any]:
        """How far it is, for the page; and whether the film shows the scene as it is now."""
        film = self.film
        with self._lock:
            return {
                "drawing": self._process is not None,
                "said": self._said,
                "share": self._share,
                "failed": self._failed,
                "film": None if film is None else str(film.stat().st_mtime_ns),
                "stale": self._scene is not None and self._scene is not scene,
            }

    def _follow(self, process: subprocess.Popen[str]) -> None:
        """Take down what the process says, until it ends."""
        late = threading.Timer(LONGEST_S, process.kill)
        late.daemon = True
        late.start()
        last = ""
        try:
            assert process.stderr is not None  # it was asked for
            while line := process.stderr.readline(_LONGEST_LINE):
                last = line.strip() or last
                share = _SHARE.search(last)
                with self._lock:
                    self._said = last
                    self._share = 0.01 * int(share.group(1)) if share else self._share
            process.stderr.close()
            code = process.wait()
            late.cancel()
            with self._lock:
                self._process = None
                if code < 0:
                    self._failed = "It was stopped."
                elif code:
                    self._failed = last.removeprefix("motorcade: ") or "It could not be drawn."
        finally:
            _drawn_now.release()


SCENE_NAME = "scene.json"


@dataclass(frozen=True, eq=False)
class RunDesk:
    """A run on whose footage a scene is edited."""

    filmed: Filmed
    session: EditingSession

    @cached_property
    def drawing(self) -> FilmDrawing:
        """The film of the scene."""
        words = [*shlex.split(self.film_command()), "--until", "overlay"]
        return FilmDrawing(words, self._film_folder)

    @property
    def _film_folder(self) -> Path:
        scene = self.session.history.write_log.scene.absolute()
        return scene.with_name(f"{scene.stem}-film")

    @property
    def frames(self) -> int:
        """How many images there are."""
        return self.filmed.frames

    @cached_property
    def _footage(self) -> Footage:
        return Footage(self.filmed.recording.frames)

    def about(self) -> dict[str, Any]:
        """What there is, for the page."""
        filmed, scene = self.filmed, self.session.history.scene
        poses = rows_of(filmed.world_T_camera)
        poses[~filmed.has_pose] = np.nan
        first = filmed.ground(filmed.first)
        anchors = dict(scene.anchors) | {
            name: stand
            for name, stand in filmed.stands.items()
            if stand not in scene.anchors.values()
        }
        far = np.linalg.norm(
            filmed.world_T_camera.translation_m - first.world_T_plane.translation_m, axis=-1
        )
        size = max(float(far.max()), filmed.height_m)
        return {
            "name": filmed.recording.name,
            "frames": filmed.frames,
            "camera": shown_camera(filmed.camera),
            "grey": filmed.grey,
            "time_s": packed(filmed.time_s, "f64"),
            "world_T_camera": packed(poses, "f64"),
            "up": filmed.up.tolist(),
            "depth_m": [0.002 * size, 60.0 * size],
            "height_m": filmed.height_m,
            "anchors": {name: spoken(one) for name, one in anchors.items()},
            "wardrobe": self.session.props.listed(),
            "film": self.film_command(),
        }

    def film_command(self) -> str:
        """What draws the scene into the footage, to be typed where the server runs."""
        scene, out = self.session.history.write_log.scene.absolute(), self._film_folder
        return shlex.join([*self.filmed.words, "--scene", str(scene), "--out", str(out)])

    def film_state(self) -> dict[str, Any]:
        """How far the film is that is being drawn."""
        return self.drawing.state(self.session.history.scene)

    def film(self) -> Path | None:
        """The film that was drawn last."""
        return self.drawing.film

    def frame(self, index: int) -> bytes:
        """An image as JPEG."""
        return self._footage.jpeg(index)

    def figure(self, number: int) -> bytes | None:
        """A shape as `.glb`."""
        return self.session.played.glb(number)

    def motion(self, number: int) -> dict[str, Any] | None:
        """What joints do, for the page."""
        return self.session.played.motion(number)

    def joined(self, visitor: int) -> Mapping[str, Any]:
        """What a browser is told when it comes."""
        return self.session.joined(visitor)

    def answer(self, visitor: int, message: Mapping[str, Any]) -> Answer:
        """Do what a browser asks for."""
        if message.get("do") in ("film", "stop film"):
            return self._film(message)
        return self.session.answer(visitor, message)

    def _film(self, message: Mapping[str, Any]) -> Answer:
        """Begin to draw the film, or end it."""
        number, history = message.get("n"), self.session.history
        reply: dict[str, Any] = {"n": number if type(number) is int else None, "ok": True}
        try:
            if message["do"] == "film":
                history.saved()
                self.drawing.start(history.scene)
            else:
                self.drawing.stop()
        except (ValueError, OSError) as fault:
            return Answer({**reply, "ok": False, "error": " ".join(str(fault).split())})
        return Answer({**reply, "film": self.film_state()})

    def left(self, visitor: int) -> Mapping[str, Any] | None:
        """A browser is gone."""
        return self.session.left(visitor)

    def close(self) -> None:
        """Write the scene as it is, and let others edit it; raises `OSError` where it cannot be."""
        self.drawing.stop(wait=True)
        self.session.history.close()


def open_desk(run: Path, scene: Path | None = None) -> RunDesk:
    """Open a run for its scene to be edited, where it was left.

    Args:
        run: a folder that `motorcade run` wrote.
        scene: the scene's file; `scene.json` in the run's folder unless told.

    Raises ValueError: a folder that holds no run, a scene that cannot be read; OSError: its
    recording is gone, another process edits the scene, or nothing can be written beside it.
    """
    filmed = open_filmed(run)
    file = run / SCENE_NAME if scene is None else scene
    scene_begun = first_scene(filmed, file.absolute().parent)
    write_log = WriteAheadLog(file, scene_text(scene_begun).encode())
    return desk_of(filmed, write_log)


def desk_of(filmed: Filmed, write_log: WriteAheadLog) -> RunDesk:
    """The desk of a session; the write-ahead log is closed where it cannot be shown.

    Raises ValueError: a line of the session, or a file of the scene, that cannot be read.
    """
    with ExitStack() as refused:
        refused.callback(write_log.close)
        folder = write_log.scene.absolute().parent
        history, props = SceneHistory(write_log), Props(folder, files_beside(folder))
        played = PlayedScene(filmed, folder)
        session = EditingSession(filmed, history, played, props, SceneView(filmed, played, props))
        session.joined(0)  # a scene that cannot be shown is refused here, and not to each browser
        refused.pop_all()
    return RunDesk(filmed, session)


QUALITY = 82
WIDEST_PX = 1600
"""Wider images are made smaller: no screen beside a hand shows more."""
KEPT_BYTES = 192 << 20


class Footage:
    """Images by number. May be asked by several threads."""

    def __init__(self, frames: FrameSequence) -> None:
        self._frames = frames
        self._kept: OrderedDict[int, bytes] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def jpeg(self, index: int) -> bytes:
        """An image, colour or grey as it was taken.

        Raises IndexError: there is no such image; RecordingError: it cannot be read.
        """
        if not 0 <= index < len(self._frames):
            raise IndexError(f"Footage.jpeg: expected 0 to {len(self._frames) - 1}, got {index}")
        with self._lock:  # decoders go from one image to the next
            if index in self._kept:
                self._kept.move_to_end(index)
                return self._kept[index]
            image = self._frames[index].image()
        wide = image.shape[1]
        if wide > WIDEST_PX:
            share = WIDEST_PX / wide
            image = cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
        if image.ndim == 3:
            image = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
        written, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        if not written:
            raise OSError(f"frame {index}: cannot be written as JPEG")
        jpeg = data.tobytes()
        with self._lock:
            self._bytes += len(jpeg) - len(self._kept.pop(index, b""))
            self._kept[index] = jpeg
            while self._bytes > KEPT_BYTES and len(self._kept) > 1:
                self._bytes -= len(self._kept.popitem(last=False)[1])
        return jpeg


log = logging.getLogger("motorcade.studio")


@dataclass(frozen=True)
class Offer:
    """A run on the start page; `open` reads it, which may take seconds."""

    name: str
    open: Callable[[], RunDesk]


MOST_RUNS = 1000
RUN_LOG = "run.json"


def offered(path: Path, run: Path | None = None) -> list[Offer]:
    """The runs whose scenes can be edited.

    Args:
        path: a run's folder, a folder of runs, or a scene's file.
        run: of a scene that lies elsewhere.

    Raises ValueError: none of these.
    """
    if path.is_dir():
        if run is not None:
            raise ValueError(f"--run: expected with a scene's file, got the folder {path}")
        if (path / RUN_LOG).is_file():
            return [Offer(path.absolute().name, partial(open_desk, path))]
        runs = sorted(one.parent for one in path.glob(f"*/{RUN_LOG}"))
        if not runs:
            raise ValueError(f"{path}: expected what `motorcade run` wrote, or a folder of such")
        if len(runs) > MOST_RUNS:
            log.warning("%s: the first %d of %d runs are listed", path, MOST_RUNS, len(runs))
        return [Offer(run.absolute().name, partial(open_desk, run)) for run in runs[:MOST_RUNS]]
    folder = path.absolute().parent if run is None else run
    if not (folder / RUN_LOG).is_file():
        raise ValueError(
            f"{path}: expected a run's folder, or a scene in one; {folder} holds no run. A scene "
            "is edited on footage: `motorcade run RECORDING --out RUN` makes a run, and "
            f"`motorcade author {path} --run RUN` opens the scene on it"
        )
    return [Offer(folder.absolute().name, partial(open_desk, folder, path))]


def ready(offer: Offer, say: Callable[[str], None]) -> Offer:
    """An offer that was opened, so that what keeps it from being edited is told before the link.

    `say` takes a line on what is under way.

    Raises ValueError: a run or a scene that cannot be read; OSError: its recording is gone, or
    another process edits the scene.
    """
    say(f"{offer.name}: opening the run")
    since = time.monotonic()
    desk = offer.open()
    say(f"{offer.name}: {desk.frames} images, {time.monotonic() - since:.1f} s")
    return replace(offer, open=lambda: desk)


def first_scene(filmed: Filmed, folder: Path) -> Scene:
    """Those of a run as objects of a scene, or none beside its ground where it put nobody there.

    Args:
        filmed: the run.
        folder: of the scene's file, which names others from there.

    Raises ValueError: a file of the run that cannot be read any more.
    """
    placed, knobs = filmed.placed, filmed.knobs
    if placed is not None and str(knobs.get("scene", NOBODY)) != NOBODY:
        return _named_from(Path(knobs["scene"]), folder)
    ground, objects = {GROUND: anchor_json(filmed.first)}, []
    for entry in [] if placed is None else _entries(filmed, placed):
        file = entry["file"]
        own = file if file == MANNEQUIN else relpath(file, folder.absolute())
        try:
            scene = scene_of({"anchors": ground, "objects": [{**entry, "file": own}]}, "run")
            cast_as(scene, entry["name"], folder)
        except (ValueError, OSError) as fault:
            log.warning("%s is not in the first scene: %s", entry["name"], fault)
            continue
        objects.append({**entry, "file": own})
    return scene_of({"anchors": ground, "objects": objects}, "run")


def _named_from(path: Path, folder: Path) -> Scene:
    """A scene with its files named from another folder."""
    scene, old = read_scene(path), path.absolute().parent
    parts = {
        name: part
        if part.file in ("", MANNEQUIN)
        else replace(part, file=relpath(file_of(part, old), folder.absolute()))
        for name, part in scene.parts.items()
    }
    return replace(scene, parts=parts)


def _entries(filmed: Filmed, placed: PlacedCharacter) -> list[dict[str, Any]]:
    """Entries of a scene file, their files by whole names."""
    if str(filmed.knobs.get("cast", NOBODY)) != NOBODY:
        cast: Cast = read_cast(Path(filmed.knobs["cast"]))
        parts = {part.name: part for part in placed.parts}
        known = [member for member in cast.members if member.name in parts]
        plane = filmed.ground(filmed.first).world_T_plane
        return [_of_cast(member, parts[member.name], plane) for member in known]
    entry = _standing(placed.character, placed.plane_T_character, filmed.height_m)
    if placed.clip != IDLE and not len(placed.path_m):
        entry["clip"] = placed.clip
    if len(placed.path_m):
        entry["walk"] = {"path_m": placed.path_m.tolist(), "gaits": [placed.clip]}
    if placed.up or placed.front or placed.hide:
        log.warning("the first scene has no words for placed.up, front and hide: %s", entry["file"])
        return []
    return [{"name": "character", **entry}]


def _standing(character: str, plane_T_character: Motor, height_m: float) -> dict[str, Any]:
    heading_rad = float(plane_T_character.rotor.as_euler()[2])
    return {
        "kind": "character",
        "file": character if character == MANNEQUIN else str(Path(character).absolute()),
        "parent": GROUND,
        "height_m": height_m,
        "position_m": plane_T_character.translation_m.tolist(),
        "euler_deg": [0.0, 0.0, float(np.degrees(heading_rad))],
    }


def _of_cast(member: CastMember, part: PlayedPart, plane: Motor) -> dict[str, Any]:
    """One of a cast: walks as it walked, and layers at the times of its acts."""
    own = character_named(part.character, part.up, part.front).height_m
    plane_T_character: Motor = plane.inverse() @ part.placement.world_T_character
    entry = _standing(member.file, plane_T_character, part.placement.scale * own)
    entry |= {"name": member.name, "clip": member.idle}
    x, y = member.path_m[0].tolist()
    entry["position_m"] = [x, y, 0.0]
    if len(member.path_m) > 1:
        starts_s = [state.start_s for state in part.states if state.state == "walk"]
        entry["walk"] = {
            "path_m": member.path_m.tolist(),
            "start_s": min(starts_s, default=member.waits_s),
            "gaits": list(member.gaits),
            **({} if member.speed_m_s is None else {"speed_m_s": member.speed_m_s}),
        }
    entry["layers"] = _layers(member, part)
    return entry


def _layers(member: CastMember, part: PlayedPart) -> list[Mapping[str, Any]]:
    """What it did at its goal, and what it did meanwhile, at the times at which it did."""
    layers: list[Mapping[str, Any]] = []
    for state in part.states:
        span = {"start_s": state.start_s, "end_s": state.end_s}
        if not state.end_s > state.start_s:
            continue
        if state.state == "act":
            layers.append({"clip": state.clip, "joints": "whole", **span})
        layers += [
            {
                "clip": layer.clip,
                "joints": layer.joints,
                "weight": layer.weight,
                "additive": layer.additive,
                **span,
            }
            for layer in member.layers
            if layer.during == state.state
        ]
    return layers
