"""What became of every frame of visual SLAM, and what happened on the way."""

from __future__ import annotations

import csv
import io
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from motorcade.ga.arrays import IntArray

SlamState = Literal["initialising", "tracking", "weak", "lost", "relocalised"]
SLAM_STATES: tuple[SlamState, ...] = ("initialising", "tracking", "weak", "lost", "relocalised")
SlamEventKind = Literal["map begun", "lost", "relocalised", "loop closed", "maps joined"]


@dataclass(frozen=True)
class SlamEvent:
    """Something that happened to the camera or to its maps.

    Fields:
        time_ns: stamp of the frame or keyframe that it happened at.
        kind: what.
        map_number: of the map that the camera is in then; None where it is lost.
        seen_ns: stamp of the old keyframe that was recognised; None without one.
        moved: by how much a loop moved the newest keyframe, in the map's lengths.
        turned_rad: by how much it turned it.
        stretched: by how much it stretched lengths there.
    """

    time_ns: int
    kind: SlamEventKind
    map_number: int | None
    seen_ns: int | None = None
    moved: float | None = None
    turned_rad: float | None = None
    stretched: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready, without what is None."""
        return {key: value for key, value in vars(self).items() if value is not None}


@dataclass(frozen=True, eq=False)
class SlamHistory:
    """What became of every frame.

    Args:
        time_ns: ``(f,)`` stamps of all frames.
        states: theirs: "weak" is tracked by so few corners, or so close together, that half of
            them would be too few.
        map_number: ``(f,)`` of the map that the frame was tracked in; -1 without a pose.
        inliers: ``(f,)`` how many corners its pose explains.
        keyframes: ``(f,)`` how many keyframes there are after it.
        events: in order of time.

    >>> import numpy as np
    >>> from motorcade.tracking.slam import SlamEvent, SlamHistory
    >>> begun = SlamEvent(0, "map begun", 0)
    >>> one = np.array([0]), ("tracking",), np.array([0]), np.array([250]), np.array([1])
    >>> history = SlamHistory(*one, (begun,))
    >>> history.frames_in_state["tracking"], history.count("loop closed")
    (1, 0)
    >>> print(history.as_csv())
    time_ns,state,map_number,inliers,keyframes
    0,tracking,0,250,1
    """

    time_ns: IntArray
    states: tuple[SlamState, ...]
    map_number: IntArray
    inliers: IntArray
    keyframes: IntArray
    events: tuple[SlamEvent, ...]

    @property
    def frames_in_state(self) -> dict[SlamState, int]:
        """How many frames were in each state."""
        counted = Counter(self.states)
        return {state: counted[state] for state in SLAM_STATES}

    def count(self, kind: SlamEventKind) -> int:
        """How often something happened."""
        return sum(one.kind == kind for one in self.events)

    def as_dict(self) -> dict[str, Any]:
        """Its figures and events, JSON-ready."""
        return {
            "frames_in_state": self.frames_in_state,
            "keyframes": int(self.keyframes[-1]) if len(self.keyframes) else 0,
            "maps_begun": self.count("map begun"),
            "maps_joined": self.count("maps joined"),
            "loops_closed": self.count("loop closed"),
            "events": [one.as_dict() for one in self.events],
        }

    def as_csv(self) -> str:
        """A row a frame."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(("time_ns", "state", "map_number", "inliers", "keyframes"))
        numbers = np.stack([self.map_number, self.inliers, self.keyframes], axis=1).tolist()
        stamps = self.time_ns.tolist()
        writer.writerows(
            (stamp, state, *row)
            for stamp, state, row in zip(stamps, self.states, numbers, strict=True)
        )
        return text.getvalue()

    def save(self, path: Path) -> None:
        """Write `as_csv` to a file.

        Raises:
            OSError: a file that cannot be written.
        """
        path.write_text(self.as_csv(), encoding="utf-8")
