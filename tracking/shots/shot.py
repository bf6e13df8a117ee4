"""What a clip consists of: shots, what lies between them, frames that repeat the one before.

Frames are counted from 0; a stretch holds its first and its last frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from motorcade.tracking.shots.camera_motion import CameraMotion

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
        repeated: frames that show the picture before once more.
        frozen: of those, how many lie in stretches of `FROZEN_FRAMES` and more.

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
