"""One camera's live session: each frame tracked, drawn upon, measured and recorded.

Its figure stands where one taps, is dragged, turned and scaled, and walks to a tapped point: on the
ground z = 0 of the tracker's world, by rays of the pixels of the frame that was on show.

Not for two threads at once: whoever serves it takes frames and gestures in one thread. What is kept
is an ordinary recording, which `motorcade run` replays:

    frames/000000.png …   every frame that was tracked, without loss
    stamps.txt            their stamps, ns
    motorcade.toml        camera, board, and the scene where somebody was stood on it
    scene.json            the figure as it stood last
    imu.csv               what its IMU read, on the IMU's clock, where it has one
    live.jsonl            a line a frame (state, world_T_camera, held-out distances) or gesture

A run uses the IMU where it was sure at the end how that sits on the camera; else imu.csv waits for
`motorcade sync`. With a camera that was stated, a run's poses by the board are the live ones bit
for bit: it tracks the same images in the same order. With one that was found on the way they are
those of that camera.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from motorcade.animation import Character
from motorcade.animation.authoring.pointing import DragPlane, Ray
from motorcade.animation.behaviour import (
    Actor,
    Errand,
    Performance,
    Timeline,
    gait_between,
    perform,
)
from motorcade.animation.ik import fitted_legs
from motorcade.animation.retarget import legs_of
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.files import write_bytes
from motorcade.replays.io.readers.manifest.section import board_toml, camera_toml
from motorcade.replays.live.frames import LiveFrame, kind_of, newest, open_frames, paced
from motorcade.replays.live.inertial import ImuFile
from motorcade.replays.live.tracker import FirstMarker, LivePose, LiveTracker, Target
from motorcade.replays.pipeline.look import gltf_bytes, shown_camera
from motorcade.replays.pipeline.packing import packed, rows_of, scaled_rows
from motorcade.replays.stages.view.acting import IDLE, character_named, rigid_clip
from motorcade.replays.studio.messages import number_of, pixels_of
from motorcade.tracking import Board, Camera

RATE_HZ = 30.0
SMALLEST, LARGEST = 0.1, 10.0
"""Of the size at which it stood first."""
FARTHEST = 50.0
"""Heights of the figure, from the ground's middle: rays that almost miss the ground end there."""
LONGEST_WALK_S = 60.0
_NEAREST = 0.05
"""Heights of the figure below which a walk is none."""
_KEPT = 16


_GROUND = DragPlane(np.zeros(3), np.array([0.0, 0.0, 1.0]))


@dataclass
class LiveFigure:
    """Who stands on the ground, and what it does now. Times are seconds of the frames' clock.

    Args:
        file: "mannequin", or a character's file.
        height_m: how tall it stands at first, in the world's unit.

    Raises ValueError: a file that holds no character, or one whose legs nothing tells.
    """

    file: str
    height_m: float
    scale: float = 1.0
    heading_rad: float = 0.0
    position_m: FloatArray | None = None
    _motions: dict[int, Performance] = field(default_factory=dict)
    _walk: tuple[int, float] | None = None
    _next: int = 1

    def __post_init__(self) -> None:
        self.character: Character = character_named(self.file)
        self.legs = tuple(fitted_legs(legs_of(self.character.skeleton), self.character))
        if not self.legs:
            raise ValueError(f"{self.file}: neither bones nor names tell the character's legs")
        self.idle = rigid_clip(self.character, IDLE)

    @cached_property
    def glb(self) -> bytes:
        """Its mesh, skeleton and materials as glTF."""
        return gltf_bytes(self.character)

    def stand(self, at_m: FloatArray, eye_m: FloatArray) -> None:
        """Stand at a point of the ground, facing a point above it."""
        self._walk = None
        self.position_m = self._within(at_m)
        self.heading_rad = self._towards(self.position_m, eye_m)

    def leave(self) -> None:
        """Stand nowhere."""
        self._walk = self.position_m = None

    def drag(self, to_m: FloatArray) -> None:
        """Stand elsewhere, facing as before."""
        self._walk = None
        self.position_m = self._within(to_m)

    def turn(self, by_rad: float) -> None:
        """Turn on the spot, anticlockwise seen from above."""
        self.heading_rad = float(np.remainder(self.heading_rad + by_rad, 2.0 * np.pi))

    def resize(self, factor: float) -> None:
        """Become larger or smaller, within bounds."""
        self.scale = float(np.clip(self.scale * factor, SMALLEST, LARGEST))

    def walk(self, to_m: FloatArray, eye_m: FloatArray, time_s: float) -> None:
        """Set out to a point, feet planted, and face the camera there; from where it stands."""
        self._settle(time_s)
        if self.position_m is None:
            return
        to_m = self._within(to_m)
        way = to_m - self.position_m
        size = self.scale * self.height_m
        if float(np.linalg.norm(way)) < _NEAREST * size:
            return
        cycle, speed = gait_between(
            [rigid_clip(self.character, "walk")], self.character.skeleton, self.legs, None
        )
        scale = size / self.character.height_m
        actor = Actor("figure", self.character, self.legs, scale, self.idle, cycle, speed)
        errand = Errand(
            self.position_m,
            self.heading_rad,
            np.stack([self.position_m, to_m]),
            facing_rad=self._towards(to_m, eye_m),
        )
        timeline = Timeline(actor, errand)
        performance = perform(timeline, timeline.done_s, RATE_HZ, most_s=LONGEST_WALK_S)
        self._motions[self._next] = performance
        self._walk, self._next = (self._next, time_s), self._next + 1
        for old in list(self._motions)[:-_KEPT]:
            del self._motions[old]

    def state(self, time_s: float) -> dict[str, Any] | None:
        """Where it stands and what it does at a time, for the page; None before it was stood.

        `pose` is x y z, w x y z, scale; `at` the row of the motion's joints, a fraction between.
        """
        self._settle(time_s)
        if self.position_m is None:
            return None
        scale = self.scale * self.height_m / self.character.height_m
        if self._walk is None:
            turn = Rotor.from_rotation_vector([0.0, 0.0, self.heading_rad])
            stands = Motor.from_rotor_translation(turn, np.append(self.position_m, 0.0))
            motion, at = 0, time_s * RATE_HZ
        else:
            motion, begun_s = self._walk
            way = self._motions[motion].plane_T_character
            at = min(max(0.0, (time_s - begun_s) * RATE_HZ), len(way.coefficients) - 1.0)
            before = int(at)
            after = min(before + 1, len(way.coefficients) - 1)
            stands = way[before].interpolate(way[after], at - before)
        pose = [*rows_of(stands).tolist(), scale]
        return {"pose": pose, "motion": motion, "at": round(at, 3)}

    def joints(self, motion: int) -> dict[str, Any] | None:
        """What joints do in a motion, `RATE_HZ` rows a second; None where it is not known any more.

        Motion 0 is how it idles, which repeats.
        """
        if motion == 0:
            clip = self.idle
            count = max(1, round(float(clip.time_s[-1] - clip.time_s[0]) * RATE_HZ))
            poses = clip.at(clip.time_s[0] + np.arange(count) / RATE_HZ).rigid
        elif motion in self._motions:
            poses = self._motions[motion].poses
        else:
            return None
        joints = packed(scaled_rows(self.character.skeleton.world(poses)))
        return {"joints": joints, "loops": motion == 0}

    def _settle(self, time_s: float) -> None:
        """Stand where a walk that is over has led."""
        if self._walk is None:
            return
        motion, begun_s = self._walk
        performance = self._motions[motion]
        if time_s - begun_s < performance.time_s[-1]:
            return
        end = performance.plane_T_character[-1]
        self._walk = None
        self.position_m = end.translation_m[:2]
        self.heading_rad = float(end.rotor.as_euler()[2])

    def _within(self, point_m: FloatArray) -> FloatArray:
        reach = FARTHEST * self.height_m
        length = float(np.linalg.norm(point_m))
        return point_m if length <= reach else point_m * (reach / length)

    @staticmethod
    def _towards(from_m: FloatArray, eye_m: FloatArray) -> float:
        x, y = (eye_m[:2] - from_m).tolist()
        return float(np.arctan2(y, x))


MOST_FRAMES = 36_000
"""Twenty minutes at 30 a second; recording then ends, and the page says so."""
_WAITING = 32


class LiveRecorder:
    """Writes what a session takes in and gives; FileExistsError where the folder holds anything."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise FileExistsError(f"{folder}: expected an empty folder for the recording")
        (folder / "frames").mkdir()
        self.folder = folder
        self.count = 0
        self._size: tuple[int, ...] | None = None
        self._stamps = (folder / "stamps.txt").open("w", encoding="ascii", buffering=1)
        self._imu = ImuFile(folder)
        self._lines = (folder / "live.jsonl").open("w", encoding="utf-8", buffering=1)
        self._writer = ThreadPoolExecutor(1, "recorder")
        self._room = threading.Semaphore(_WAITING)
        self._fault: BaseException | None = None

    @property
    def status(self) -> str:
        """What is recorded, for people; also why it is not any more."""
        if self._fault is not None:
            return f"not recorded any more: {self._fault}"
        if self.count >= MOST_FRAMES:
            return f"not recorded any more: {MOST_FRAMES} frames are there"
        return f"recorded: {self.count} frames in {self.folder}"

    def took(self, frame: LiveFrame, pose: LivePose) -> None:
        """Keep a frame and its pose; waits where the disk is slower than the camera."""
        if self._fault is not None or self.count >= MOST_FRAMES:
            return
        if self._size not in (None, frame.image.shape):
            self._fault = ValueError("images of another size came")
            return
        self._size = frame.image.shape
        number, self.count = self.count, self.count + 1
        self._room.acquire()
        self._writer.submit(self._write, number, frame)
        self._imu.add(frame.imu)
        motor = pose.world_T_camera
        known = {key: getattr(pose, key) for key in ("time_ns", "state", "measured")}
        row = None if motor is None else rows_of(motor).tolist()
        off_px = pose.held_out_px.round(3).tolist()
        self.note({**known, "world_T_camera": row, "held_out_px": off_px})

    def note(self, line: Mapping[str, Any]) -> None:
        """Keep a line of what happened."""
        self._lines.write(json.dumps(line) + "\n")

    def close(self, tracker: LiveTracker, figure: LiveFigure) -> None:
        """Write what describes the recording, once all its frames are on the disk."""
        self._writer.shutdown(wait=True)
        self._stamps.close()
        self._lines.close()
        settings = []
        if figure.position_m is not None and isinstance(tracker.target, Board):
            scene = json.dumps(_scene(figure), indent=2).encode()
            write_bytes(self.folder / "scene.json", scene)
            settings.append("placed.scene=scene.json")
        text = f"settings = {json.dumps(settings)}\n\n"
        text += '[frames]\nimages = "frames/*.png"\nstamps = "stamps.txt"\nstamps_unit = "ns"\n'
        if tracker.camera is not None:
            text += "\n" + camera_toml(tracker.camera)
            if tracker.calibration is not None and tracker.calibration.calibrated is not None:
                text += f"focal_sigma = {tracker.calibration.calibrated.sigma_focal!r}\n"
        if isinstance(tracker.target, Board):
            text += "\n" + board_toml(tracker.target)
        text += self._imu.close(tracker.inertial.synchronised)
        write_bytes(self.folder / "motorcade.toml", text.encode())

    def _write(self, number: int, frame: LiveFrame) -> None:
        try:
            image = frame.image if frame.image.ndim == 2 else frame.image[..., ::-1]
            path = self.folder / "frames" / f"{number:06d}.png"
            if not cv2.imwrite(str(path), image, [cv2.IMWRITE_PNG_COMPRESSION, 1]):
                raise OSError(f"{path}: cannot be written")
            self._stamps.write(f"{frame.time_ns}\n")
        except Exception as fault:  # a disk that is full ends the recording, not the session
            self._fault = fault
        finally:
            self._room.release()


def _scene(figure: LiveFigure) -> dict[str, Any]:
    """The figure on its board, as scene files have it."""
    assert figure.position_m is not None  # asked before
    entry = {
        "name": "figure",
        "kind": "character",
        "file": figure.file,
        "parent": "board",
        "height_m": figure.scale * figure.height_m,
        "position_m": [*figure.position_m.tolist(), 0.0],
        "euler_deg": [0.0, 0.0, math.degrees(figure.heading_rad)],
    }
    anchors = {"board": {"on": "board"}}
    return {"schema": "motorcade-scene", "version": 1, "anchors": anchors, "objects": [entry]}


WINDOW_S = 5.0
_MOST = 4096


@dataclass
class LiveMeasure:
    """Counts what was tracked and drawn, on a clock of seconds that only grow.

    >>> from motorcade.replays.live.session import LiveMeasure
    >>> seconds = iter(range(100))
    >>> measure = LiveMeasure(clock=lambda: 0.25 * next(seconds))
    >>> for latency_s in (0.04, 0.05, 0.06):
    ...     measure.drawn(latency_s)
    >>> figures = measure.figures()
    >>> figures["frames_drawn_s"], figures["latency_p50_ms"], figures["registration_px"]
    (4.0, 50.0, None)
    """

    clock: Callable[[], float] = time.monotonic
    states: Counter[str] = field(default_factory=Counter)
    _drawn: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_MOST))
    _off: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_MOST))

    def tracked(self, pose: LivePose) -> None:
        """A frame's pose is known, or is known to be missing."""
        self.states[pose.state] += 1
        now = self.clock()
        self._off.extend((now, float(off)) for off in pose.held_out_px)

    def drawn(self, latency_s: float) -> None:
        """A frame was drawn with its pose, so long after it was taken."""
        self._drawn.append((self.clock(), latency_s))

    def figures(self) -> dict[str, Any]:
        """Figures of the last seconds; None for what there is none of.

        `registration_px` is the median distance of corners from where a pose that they had no
        part in has them; `latency_…_ms` from capture to drawn.
        """
        now = self.clock()
        for kept in (self._drawn, self._off):
            while kept and now - kept[0][0] > WINDOW_S:
                kept.popleft()
        latency = np.array([latency_s for _, latency_s in self._drawn])
        off = np.array([off_px for _, off_px in self._off])
        span_s = self._drawn[-1][0] - self._drawn[0][0] if len(self._drawn) > 1 else 0.0
        return {
            "frames_drawn_s": round((len(latency) - 1) / span_s, 1) if span_s > 0.0 else None,
            "latency_p50_ms": _percentile(1e3 * latency, 50.0),
            "latency_p95_ms": _percentile(1e3 * latency, 95.0),
            "registration_px": _percentile(off, 50.0),
            "registration_p95_px": _percentile(off, 95.0),
        }


def _percentile(values: np.ndarray[Any, np.dtype[np.float64]], percent: float) -> float | None:
    return round(float(np.percentile(values, percent)), 3) if len(values) else None


_POSES_KEPT = 64
"""Frames back that a gesture may mean: what a finger touched is what was on show."""
_GESTURES = ("stand", "walk", "drag", "turn", "resize")


@dataclass
class LiveSession:
    """What becomes of one camera's frames: poses, a figure on the ground, a recording."""

    tracker: LiveTracker
    figure: LiveFigure
    recorder: LiveRecorder | None = None
    measure: LiveMeasure = field(default_factory=LiveMeasure)
    _poses: OrderedDict[int, LivePose] = field(default_factory=OrderedDict)
    _time_s: float = 0.0
    _begun_ns: int | None = None
    _map_number: int = 0

    def take(self, frame: LiveFrame, number: int = 0) -> LivePose:
        """Track a frame; `number` is what gestures call it by. Raises as `LiveTracker.update`."""
        pose = self.tracker.update(frame)
        if self._begun_ns is None:
            self._begun_ns = frame.time_ns
        self._time_s = 1e-9 * (frame.time_ns - self._begun_ns)
        if pose.map_number != self._map_number:  # where it stood is not known any more
            self._map_number = pose.map_number
            self.figure.leave()
        self.measure.tracked(pose)
        self._poses[number] = pose
        while len(self._poses) > _POSES_KEPT:
            self._poses.popitem(last=False)
        if self.recorder is not None:
            self.recorder.took(frame, pose)
        return pose

    def shown(self, pose: LivePose) -> dict[str, Any]:
        """A pose, and what is drawn with it, for the page."""
        motor = pose.world_T_camera
        return {
            "state": pose.state,
            "why": pose.why,
            "pose": None if motor is None else rows_of(motor).tolist(),
            "camera": None if pose.camera is None else shown_camera(pose.camera),
            "figure": self.figure.state(self._time_s),
        }

    def told(self) -> dict[str, Any]:
        """Figures of the last seconds, and what there is to say of camera and recording."""
        recorded = "" if self.recorder is None else self.recorder.status
        known = filter(None, (self.tracker.camera_status, self.tracker.inertial.status))
        return {**self.measure.figures(), "camera_status": "; ".join(known), "recorded": recorded}

    def gesture(self, message: Mapping[str, Any]) -> None:
        """Do what a finger meant: stand, walk, drag (to a pixel), turn (rad), resize (a factor).

        Raises ValueError: another word, numbers that are none, or a frame that is not on show.
        """
        act = message.get("do")
        if act not in _GESTURES:
            raise ValueError(f"do: expected one of {', '.join(_GESTURES)}")
        if act in ("turn", "resize"):
            self._by_amount(act, number_of(message, "by"))
        else:
            self._by_pixel(act, message)
        if self.recorder is not None:
            kept = {key: message[key] for key in ("do", "by", "pixels", "frame") if key in message}
            self.recorder.note({"at_s": self._time_s, "gesture": kept})

    def close(self) -> None:
        """End the threads and the recording."""
        self.tracker.close()
        if self.recorder is not None:
            self.recorder.close(self.tracker, self.figure)

    def _by_amount(self, act: str, by: float) -> None:
        if act == "turn":
            self.figure.turn(math.remainder(by, 2.0 * math.pi))
        elif 0.1 <= by <= 10.0:
            self.figure.resize(by)
        else:
            raise ValueError("by: expected a factor from 0.1 to 10")

    def _by_pixel(self, act: str, message: Mapping[str, Any]) -> None:
        number = message.get("frame")
        pose = self._poses.get(number) if type(number) is int else None
        if pose is None or pose.camera is None or self.tracker.in_world(pose) is None:
            raise ValueError("frame: expected one that is on show and has a pose")
        pixels = pixels_of(message, 1)
        if len(pixels) != 1:
            raise ValueError("pixels: expected one")
        if act in ("stand", "walk") and self.tracker.choose_ground(pose, pixels[0]):
            act = "stand"  # nobody walks from one plane to another
        motor = self.tracker.in_world(pose)
        assert motor is not None  # as before
        eye: FloatArray = motor.translation_m
        ray = Ray(eye, motor.rotor.apply(pose.camera.bearings(pixels[0])))
        point = _GROUND.met_by(ray)[:2]
        if act == "stand":
            self.figure.stand(point, eye)
        elif act == "drag":
            self.figure.drag(point)
        else:
            self.figure.walk(point, eye, self._time_s)


_MARKER_HEIGHTS, _BOARD_SHARE, _PLANE_HEIGHT = 1.5, 0.5, 0.25


@dataclass(frozen=True, eq=False)
class LivePlan:
    """What is to be tracked and shown live.

    Args:
        source: as `open_frames` takes it; None for the camera of the browser that opens the page.
        manifest: that describes a recording played as the source.
        target: what is tracked; None for the board of the recording that is the source.
        camera: None for the recording's, or one that is found from the board.
        character: "mannequin", or a file.
        height_m: of the figure, in the world's unit; None for half the board's shorter side.
        record: a folder to record into; None without.
    """

    source: str | None = None
    manifest: Path | None = None
    target: Target | None = None
    camera: Camera | None = None
    character: str = "mannequin"
    height_m: float | None = None
    record: Path | None = None

    def open(self) -> tuple[LiveSession, Iterator[LiveFrame] | None]:
        """The session, and the source's frames where it is not a browser.

        Raises ValueError: no board, marker or SLAM said, or SLAM without a camera; OSError: a
        folder to record into that holds something.
        """
        recording = None
        if self.source is not None and kind_of(self.source) == "recording":
            from motorcade.replays.io.readers.opening import open_recording

            recording = open_recording(self.source, self.manifest)
        target, camera = self.target, self.camera
        if recording is not None:
            target = recording.board if target is None else target
            camera = recording.camera if camera is None else camera
        if target is None:
            raise ValueError(
                "live: expected what to track: --board NAME, --markers FAMILY --size-m S, or --slam"
            )
        tracker = LiveTracker(target, camera)
        height_m = self.height_m or height_on(target)
        figure = LiveFigure(self.character, height_m)
        recorder = None if self.record is None else LiveRecorder(self.record)
        frames = None
        if recording is not None:
            frames = paced(recording)
        elif self.source is not None:
            frames = open_frames(self.source)
        return LiveSession(tracker, figure, recorder), frames


def height_on(target: Target) -> float:
    """How tall a figure stands on a target, in its unit."""
    if isinstance(target, FirstMarker):
        return _MARKER_HEIGHTS * target.side_m
    if isinstance(target, Board):
        height, side = _BOARD_SHARE * min(target.size_m), max(target.size_m)
        return _MARKER_HEIGHTS * side if len(target.points_m) == 4 else height
    return _PLANE_HEIGHT


def track_without_page(session: LiveSession, frames: Iterator[LiveFrame]) -> dict[str, Any]:
    """Track a source to its end, and give the page's figures; "drawn" is when a pose is known."""
    began_s, count = time.monotonic(), 0
    for frame in newest(frames):
        session.take(frame, count)
        session.measure.drawn(time.monotonic() - frame.captured_s)
        count += 1
    seconds = round(time.monotonic() - began_s, 3)
    states = dict(session.measure.states)
    return {"frames": count, "seconds": seconds, "states": states, **session.told()}
