"""A live session by what a command line says of it: source, target, camera, figure, recording."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.live.figure import LiveFigure
from motorcade.replays.live.frames import LiveFrame, kind_of, newest, open_frames, paced
from motorcade.replays.live.record import LiveRecorder
from motorcade.replays.live.session import LiveSession
from motorcade.replays.live.tracker import FirstMarker, LiveTracker, Target
from motorcade.tracking import Board, Camera

if TYPE_CHECKING:
    from motorcade.replays.io.recording import Recording

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

        Raises:
            ValueError: no board, marker or SLAM said, or SLAM without a camera.
            OSError: a folder to record into that holds something.
        """
        recording = self._recording()
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

    def _recording(self) -> Recording | None:
        if self.source is None or kind_of(self.source) != "recording":
            return None
        from motorcade.replays.io.readers.opening import open_recording

        return open_recording(self.source, self.manifest)


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
