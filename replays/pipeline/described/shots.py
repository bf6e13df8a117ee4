"""Which frames of a recording are run: one of its shots, found before anything is calibrated."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import replace
from shlex import quote
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.progress import track
from motorcade.replays.io.readers.frames.files import PictureFrames
from motorcade.replays.io.readers.frames.span import frames_between
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.recording import FrameSequence, Recording
from motorcade.replays.pipeline.described.values import (
    SampledPictures,
    sample_rows,
    sampled_pictures,
)
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.shots import CameraMotion, ClipShot, Shots, find_shots

log = logging.getLogger("motorcade.graph")


_SQUARE = 0.005
"""What rounding leaves of a pixel's width over its height."""


class ChosenShot:
    """The shot that is run.

    Args:
        recording: all of it.
        number: of the shot, from 1; 0 for the longest.
        lenient: whether pictures with nothing to see are taken as a shot.

    Attributes:
        recording: its frames alone.
        shot, shots: what it is, and beside which others.
        sample: pictures spread over it.

    Raises:
        ValueError: a number that no shot has, nothing to see, or a part of frames without parts.
    """

    def __init__(self, recording: Recording, number: int, *, lenient: bool = False) -> None:
        frames, name = recording.frames, recording.name
        kept: dict[int, GrayImage] = {}
        self.shots = find_shots(_read(frames, kept))
        count = len(self.shots.shots)
        if not count and lenient:
            alone = ClipShot(0, len(frames) - 1, CameraMotion("unknown"))
            self.shots, count = Shots((alone,), (), len(frames)), 1
        if not count:
            between = ", ".join(
                f"{each.first}-{each.last} {each.kind}" for each in self.shots.breaks[:4]
            )
            raise ValueError(
                f"{name}: expected pictures with something to see, got {len(frames)} that are "
                f"black, plain or too few to follow one another: {between}"
            )
        if number > count:
            raise ValueError(f"--shot: {name} has {count} shots, got {number}")
        self.row = number - 1 if number else self.shots.longest
        self.shot: ClipShot = self.shots.shots[self.row]
        log.info("%s: %s", name, self.said)
        self.whole = len(self.shot) == len(frames)
        if not self.whole and isinstance(frames, VideoFrames | PictureFrames):
            stamps = frames.time_ns[[self.shot.first, self.shot.last]]
            part = frames_between(frames, int(stamps[0]), int(stamps[1]))
            recording, kept = replace(recording, frames=part), {}
        self.recording = recording
        self.sample: SampledPictures = sampled_pictures(recording.frames, kept)

    @property
    def said(self) -> str:
        """The shots, and which is run, in one line."""
        text = self.shots.described(self.row)
        others = [row for row in range(len(self.shots.shots)) if row != self.row]
        if others:
            text += f"; --shot {others[0] + 1} runs the {'other' if len(others) == 1 else 'next'}"
            text += ", --all-shots all"
        return text

    def span_toml(self, time_s: NDArray[np.floating[Any]]) -> str:
        """Keys of a manifest's `[frames]` that take these of all frames, whose stamps are given.

        Empty if they are all.
        """
        if len(self.recording.frames) == len(time_s):
            return ""
        first, last = self.shot.first, self.shot.last
        before, after = time_s[max(first - 1, 0)], time_s[min(last + 1, len(time_s) - 1)]
        start_s, end_s = 0.5 * (before + time_s[first]), 0.5 * (after + time_s[last])
        return f"start_s = {float(start_s):.6f}\nend_s = {float(end_s):.6f}\n"


def _read(frames: FrameSequence, kept: dict[int, GrayImage]) -> Iterator[GrayImage]:
    """Grey pictures one after another; those that a sample takes are kept."""
    rows: set[int] = set()
    for number, frame in enumerate(track(frames, "looking for shots", len(frames))):
        gray = np.asarray(frame.gray())
        if not number:
            rows = set(sample_rows(len(frames), gray.size)[0].tolist())
        if number in rows:
            kept[number] = gray
        yield gray


def refuse_oblong_pixels(recording: Recording) -> None:
    """Cameras are found for square pixels alone.

    Raises:
        ValueError: a video that is to be shown wider or narrower than it is stored.
    """
    frames = recording.frames
    if not isinstance(frames, VideoFrames) or abs(frames.pixel_aspect - 1) < _SQUARE:
        return
    name, wide = frames.path.name, float(frames.pixel_aspect)
    raise ValueError(
        f"{recording.name}: expected square pixels, got ones that are shown {wide:.3g} "
        f"times as wide as high: make them square first: ffmpeg -i {quote(name)} "
        "-vf 'scale=trunc(iw*sar/2)*2:ih,setsar=1' square.mp4"
    )
