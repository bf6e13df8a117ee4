"""Clips taken apart into shots: cuts, fades, black and repeated frames, what the camera does.

Corners are tracked from each image to the next. Where they are lost, the images around are
compared as scenes: a cut is where none of the last few shows what any of the next few shows, so
that a flash, a step of exposure, a blurred pan or one broken image is none. A dissolve is where
images are mixtures of two that show different scenes. Frames are counted from 0; a segment holds
its first and its last frame.

Sources: Boreczky & Rowe 1996 (cuts, and what is mistaken for them); Lienhart 1999 (fades by their
contrast, dissolves as linear mixtures).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.images import track_corners
from motorcade.tracking.native._flow import Pyramid
from motorcade.tracking.shots.camera_motion import CameraMotion, TrackedCorners, motion_of
from motorcade.tracking.shots.rotation import FEWEST_CORNERS, corners_in, rest_of, shows_same_scene

__all__ = ["CameraMotion", "ClipShot", "Shots", "find_shots"]


_LONG_SIDE = 320
_DARK, _FAINT, _PLAIN = 40.0, 3.0, 2.0
"""Of 255: nearly all of a black image is darker, with less contrast than one taken in poor light
has; a plain one has less still."""
_KEPT_SHARE = 0.5
_AROUND = 3
_FEWEST_FRAMES = 8
_SNAPSHOT, _SEGMENT_FRAMES, _SEGMENT_FLOW, _SEGMENT_KEPT = 15, 60, 0.12, 0.6
_FADED = 0.6
_WINDOWS = (8, 14, 24, 42)
_MIXED, _THUMB = 0.8, (64, 48)
_REPEATS, _MOVES_GREY, _FROZEN_FRAMES = 0.1, 0.8, 12


def find_shots(images: Iterable[GrayImage]) -> Shots:
    """Take a clip apart into shots.

    Args:
        images: upright grey images ``(height, width)`` uint8 of one size, in order.

    A shot has at least 8 frames. Images that do not follow one another (photographs in a folder)
    are no film: they are given as one shot, whose motion is unknown.

    Raises:
        ValueError: something that is no grey image.

    >>> import numpy as np
    >>> from motorcade.tracking.shots import find_shots
    >>> noise = np.random.default_rng(0).integers(0, 255, (2, 90, 160)).astype(np.uint8)
    >>> shots = find_shots([noise[0]] * 12 + [noise[1]] * 20)
    >>> print(shots.described(shots.longest))
    2 shots: frames 0-11, 12-31; taken is the second, in which the camera stands
    """
    reading = _Reading()
    for image in images:
        reading.add(_preview(checked_gray(image)))
    return reading.shots()


def _preview(gray: GrayImage) -> GrayImage:
    """The image, its longer side 320 pixels."""
    scale = _LONG_SIDE / max(gray.shape)
    size = max(16, round(gray.shape[1] * scale)), max(16, round(gray.shape[0] * scale))
    return np.asarray(cv2.resize(gray, size, interpolation=cv2.INTER_AREA), np.uint8)


class _Reading:
    """One pass over previews."""

    def __init__(self) -> None:
        self.count = 0
        self.size = (0, 0)
        self._recent: deque[GrayImage] = deque(maxlen=_WINDOWS[-1] + 1)
        self._kinds: list[BreakKind | None] = []  # None: an image with something in it
        self._contrast: list[float] = []
        self._change: list[float] = []
        self._thumbs: deque[FloatArray] = deque(maxlen=_WINDOWS[-1] + 1)
        self._suspects: deque[int] = deque()
        self._cuts: list[int] = []  # frames that begin another scene
        self._segments: list[TrackedCorners] = []
        self._tracks: tuple[int, FloatArray, FloatArray] | None = None  # since, from, to
        self._first_count = 0
        self._pyramid: Pyramid | None = None
        self._anchor: GrayImage | None = None  # where the scene began

    def add(self, preview: GrayImage) -> None:
        """Read on by one image."""
        number, before = self.count, self._recent[-1] if self._recent else None
        self.count += 1
        self.size = preview.shape[1], preview.shape[0]
        contrast = float(preview.std())
        dark = float(np.quantile(preview[::2, ::2], 0.99)) < _DARK
        black = dark and contrast < _FAINT
        kind: BreakKind | None = "black" if black else "plain" if contrast < _PLAIN else None
        self._kinds.append(kind)
        self._contrast.append(contrast)
        self._change.append(0.0 if before is None else float(cv2.absdiff(before, preview).mean()))
        self._recent.append(preview)
        small = cv2.resize(preview, _THUMB, interpolation=cv2.INTER_AREA).astype(np.float64)
        self._thumbs.append((small - cv2.GaussianBlur(small, (0, 0), _THUMB[0] / 20.0)).ravel())
        pyramid = Pyramid(preview)
        if not self._tracked_on(number, pyramid, preview, kind):
            self._suspects.append(number)
        self._pyramid = pyramid
        while self._suspects and self._suspects[0] <= number - _AROUND:
            self._judge(self._suspects.popleft())
        if kind is None:
            self._look_for_dissolve(number)

    def _tracked_on(
        self, number: int, pyramid: Pyramid, preview: GrayImage, kind: BreakKind | None
    ) -> bool:
        """Track corners into this image; False where most of them are lost."""
        if kind is not None:
            self._end_segment(number - 1)
            self._anchor = None
            return True
        linked = number == 0 or self._kinds[number - 1] is not None
        if self._tracks is not None and self._pyramid is not None:
            since, first_px, px = self._tracks
            there, tracked = track_corners(self._pyramid, pyramid, px, px, border_px=4.0)
            kept = int(np.count_nonzero(tracked))
            linked = kept >= max(FEWEST_CORNERS, _KEPT_SHARE * len(px))
            if linked:
                self._tracks = since, first_px[tracked], there[tracked]
                if (number - since) % _SNAPSHOT == 0:
                    self._keep_segment(number)
            if not linked or self._is_long(number):
                self._end_segment(number if linked else number - 1)
        if not linked or self._anchor is None:
            self._anchor = preview
        if self._tracks is None:
            px = corners_in(preview)
            self._first_count = len(px)
            self._tracks = number, px, px
        return linked

    def _is_long(self, number: int) -> bool:
        assert self._tracks is not None
        since, first_px, px = self._tracks
        flow = float(np.median(np.linalg.norm(px - first_px, axis=-1)))
        return (
            number - since >= _SEGMENT_FRAMES
            or flow > _SEGMENT_FLOW * max(self.size)
            or len(px) < _SEGMENT_KEPT * self._first_count
        )

    def _end_segment(self, last: int) -> None:
        self._keep_segment(last)
        self._tracks = None

    def _keep_segment(self, last: int) -> None:
        if self._tracks is not None and last > self._tracks[0] and self._anchor is not None:
            rest = rest_of(self._anchor, self._recent[last - self.count])
            self._segments.append(TrackedCorners(self._tracks[0], last, *self._tracks[1:], rest))

    def _judge(self, frame: int) -> None:
        """Whether a cut lies before a frame into which corners were lost."""
        oldest = self.count - len(self._recent)
        befores = [k for k in range(frame - 1, frame - 1 - _AROUND, -1) if k >= oldest]
        afters = list(range(frame, min(frame + _AROUND + 1, self.count)))
        if not befores or self._kinds[frame - 1] is not None:
            return
        pairs = [(befores[0], after) for after in afters]
        pairs += [(before, after) for before in befores[1:] for after in afters[:2]]
        for before, after in pairs:
            if self._kinds[before] is None and self._kinds[after] is None:
                earlier, later = self._recent[before - oldest], self._recent[after - oldest]
                if shows_same_scene(earlier, later):
                    return
        self._cuts.append(frame)

    def _look_for_dissolve(self, last: int) -> None:
        """Whether the images up to this one are mixtures of one scene and another."""
        for window in _WINDOWS:
            if window >= len(self._thumbs) or any(self._kinds[last - window :]):
                return
            ends = self._thumbs[-1 - window], self._thumbs[-1]
            places = (self._thumbs[-1 - window + window * q // 4] for q in (1, 2, 3))
            early, middle, late = (_later_share(ends, mixed) for mixed in places)
            if (
                0.03 < early < 0.45 < late < 0.97
                and early < middle < late
                and not shows_same_scene(self._recent[-1 - window], self._recent[-1])
            ):
                self._kinds[last - window + 1 : last] = ["dissolve"] * (window - 1)
                self._end_segment(last)
                self._anchor = None
                return

    def shots(self) -> Shots:
        """All that was read, taken apart."""
        self._end_segment(self.count - 1)
        for frame in self._suspects:
            self._judge(frame)
        spans = self._spans()
        for first, last in spans:
            self._fade(first, last)
        spans = self._spans()
        if sum(last - first + 1 for first, last in spans) < 0.5 * sum(
            kind is None for kind in self._kinds
        ):  # photographs, not a film
            return Shots((ClipShot(0, self.count - 1, CameraMotion("unknown")),), (), self.count)
        return Shots(tuple(self._shot(*span) for span in spans), self._breaks(spans), self.count)

    def _spans(self) -> list[tuple[int, int]]:
        """Segments with something to see and without a cut, of enough frames."""
        starts = set(self._cuts)
        spans: list[tuple[int, int]] = []
        for number, kind in enumerate(self._kinds):
            if kind is not None:
                continue
            if spans and spans[-1][1] == number - 1 and number not in starts:
                spans[-1] = spans[-1][0], number
            else:
                spans.append((number, number))
        return [span for span in spans if span[1] - span[0] + 1 >= _FEWEST_FRAMES]

    def _fade(self, first: int, last: int) -> None:
        """Mark the frames of a span that fade in from nothing, or out to it."""
        usual = _FADED * float(np.median(self._contrast[first : last + 1]))
        for number, step, beside in ((first, 1, first - 1), (last, -1, last + 1)):
            if not 0 <= beside < self.count or self._kinds[beside] not in ("black", "plain"):
                continue
            while first <= number <= last and self._contrast[number] < usual:
                self._kinds[number] = "fade"
                number += step

    def _shot(self, first: int, last: int) -> ClipShot:
        segments = [one for one in self._segments if one.first >= first and one.last <= last]
        change = np.array(self._change[first + 1 : last + 1])
        repeats = _repeats(change)
        ends = np.flatnonzero(np.diff(np.concatenate([[0], repeats, [0]])))
        runs: IntArray = np.diff(ends)[::2]
        frozen = int(runs[runs >= _FROZEN_FRAMES].sum())
        return ClipShot(first, last, motion_of(segments, self.size), int(repeats.sum()), frozen)

    def _breaks(self, spans: list[tuple[int, int]]) -> tuple[ShotBreak, ...]:
        inside = np.zeros(self.count, dtype=bool)
        for first, last in spans:
            inside[first : last + 1] = True
        breaks: list[ShotBreak] = []
        for number in np.flatnonzero(~inside).tolist():
            kind = self._kinds[number] or "short"
            if breaks and breaks[-1].last == number - 1 and breaks[-1].kind == kind:
                breaks[-1] = ShotBreak(breaks[-1].first, number, kind)
            else:
                breaks.append(ShotBreak(number, number, kind))
        return tuple(breaks)


def _repeats(change: FloatArray) -> IntArray:
    """Which frames ``(n,)`` hardly differ from the one before, in a shot in which others do."""
    if not len(change):
        return np.zeros(0, np.int64)
    usual = float(np.quantile(change, 0.8))
    return ((change < _REPEATS * usual) & (usual > _MOVES_GREY)).astype(np.int64)


def _later_share(ends: tuple[FloatArray, FloatArray], mixed: FloatArray) -> float:
    """How much of the later image's structure is in a mixture; NaN where it is none."""
    base = np.stack(ends, axis=-1)
    gram = base.T @ base
    if np.linalg.det(gram) < 1e-3 * gram[0, 0] * gram[1, 1]:
        return np.nan  # both are alike, or plain
    early, late = np.linalg.solve(gram, base.T @ mixed)
    explained = 1.0 - np.var(mixed - base @ [early, late]) / max(float(np.var(mixed)), 1e-9)
    return float(late) if explained > _MIXED and 0.8 < early + late < 1.2 else np.nan


BreakKind = Literal["black", "plain", "fade", "dissolve", "short", "zoom"]


@dataclass(frozen=True)
class ShotBreak:
    """Frames `first` to `last` that belong to no shot, and why."""

    first: int
    last: int
    kind: BreakKind


@dataclass(frozen=True)
class ClipShot:
    """Frames taken in one go.

    Fields:
        first, last: its frames.
        motion: what the camera does in it.
        repeated: frames that show the image before once more.
        frozen: of those, how many lie in segments of `FROZEN_FRAMES` and more.

    >>> from motorcade.tracking.shots import CameraMotion, ClipShot
    >>> print(ClipShot(0, 60, CameraMotion("moves"), repeated=12))
    frames 0-60, in which the camera moves (12 frames repeat the one before)
    """

    first: int
    last: int
    motion: CameraMotion
    repeated: int = 0
    frozen: int = 0

    def __len__(self) -> int:
        return self.last - self.first + 1

    def __str__(self) -> str:
        said = f"frames {self.first}-{self.last}, in which {self.motion}"
        if self.repeated > _TOLD_SHARE * len(self):
            which = "frozen" if self.frozen > self.repeated // 2 else "repeat the one before"
            said += f" ({self.repeated} frames {'are ' if which == 'frozen' else ''}{which})"
        return said


@dataclass(frozen=True)
class Shots:
    """A clip taken apart.

    Fields:
        shots: in the order of time; empty where there is nothing to see.
        breaks: what lies between them.
        frames: how many the clip has.
    """

    shots: tuple[ClipShot, ...]
    breaks: tuple[ShotBreak, ...]
    frames: int

    @property
    def longest(self) -> int:
        """Row of the shot to begin with: the longest; -1 without any."""
        return max(range(len(self.shots)), key=lambda row: len(self.shots[row]), default=-1)

    @property
    def whole(self) -> bool:
        """Whether the clip is one shot from its first frame to its last."""
        return len(self.shots) == 1 and len(self.shots[0]) == self.frames

    def described(self, chosen: int) -> str:
        """One line: the shots, what lies between, and which row of `shots` is taken.

        >>> from motorcade.tracking.shots import CameraMotion, ClipShot, Shots
        >>> stands = ClipShot(61, 104, CameraMotion("stands"))
        >>> shots = ClipShot(0, 60, CameraMotion("moves")), stands
        >>> print(Shots(shots, (), 105).described(0))
        2 shots: frames 0-60, 61-104; taken is the first, in which the camera moves
        """
        between = "".join(f"; {each.first}-{each.last} {_SAID[each.kind]}" for each in self.breaks)
        if len(self.shots) == 1:
            return f"one shot: {self.shots[0]}{between}"
        spans = ", ".join(f"{each.first}-{each.last}" for each in self.shots)
        which = _ORDINALS[chosen] if chosen < len(_ORDINALS) else f"number {chosen + 1}"
        what = str(self.shots[chosen]).partition(", ")[2]
        return f"{len(self.shots)} shots: frames {spans}{between}; taken is the {which}, {what}"


_TOLD_SHARE = 0.05
_ORDINALS = ("first", "second", "third", "fourth", "fifth")
_SAID = {
    "black": "black",
    "plain": "plain",
    "fade": "a fade",
    "dissolve": "a dissolve",
    "short": "too short for a shot",
    "zoom": "a zoom",
}
