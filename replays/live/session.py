"""One camera's live session: each frame tracked, drawn upon, measured and recorded.

Not for two threads at once: whoever serves it takes frames and gestures in one thread.
"""

from __future__ import annotations

import math
import time
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.replays.live.figure import LiveFigure, on_ground
from motorcade.replays.live.frames import LiveFrame
from motorcade.replays.live.record import LiveRecorder
from motorcade.replays.live.tracker import LivePose, LiveTracker
from motorcade.replays.pipeline.look.document import shown_camera
from motorcade.replays.pipeline.look.packing import rows_of
from motorcade.replays.studio.visitors import number_of, pixels_of

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

    def take(self, frame: LiveFrame, number: int = 0) -> LivePose:
        """Track a frame; `number` is what gestures call it by. Raises as `LiveTracker.update`."""
        pose = self.tracker.update(frame)
        if self._begun_ns is None:
            self._begun_ns = frame.time_ns
        self._time_s = 1e-9 * (frame.time_ns - self._begun_ns)
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
        known = (self.tracker.camera_status, self.tracker.inertial.status)
        status = "; ".join(text for text in known if text)
        return {**self.measure.figures(), "camera_status": status, "recorded": recorded}

    def gesture(self, message: Mapping[str, Any]) -> None:
        """Do what a finger meant: stand, walk, drag (to a pixel), turn (rad), resize (a factor).

        Raises:
            ValueError: another word, numbers that are none, or a frame that is not on show.
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
        if pose is None or pose.world_T_camera is None or pose.camera is None:
            raise ValueError("frame: expected one that is on show and has a pose")
        pixels = pixels_of(message, 1)
        if len(pixels) != 1:
            raise ValueError("pixels: expected one")
        point = on_ground(pixels[0], pose.camera, pose.world_T_camera)
        if point is None:
            raise ValueError("pixels: expected one of the ground")
        eye: FloatArray = np.asarray(pose.world_T_camera.translation_m)
        if act == "stand":
            self.figure.stand(point, eye)
        elif act == "drag":
            self.figure.drag(point)
        else:
            self.figure.walk(point, eye, self._time_s)
