"""Who stands where in the augmented view, and the video of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from motorcade.animation import Placement
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.engine.aside import ASIDE


@dataclass(frozen=True, eq=False)
class PlacedCharacter:
    """A character by name, the clip it plays, where it stands in the world, and on what.

    Fields:
        character: "mannequin" or a file.
        clip: name of what it plays.
        placement: where it stands.
        stands_on: the same in words.
        path_m: where it walks, ``(P, 2)`` points of the plane; else none.
        plane_T_character: where the placement stands in that plane.
        ground_motion: on a marker that moves, what moves the placement along: the pose
            that takes what stands in the world at the first frame to where it is later.
    """

    character: str
    clip: str
    placement: Placement
    stands_on: str
    path_m: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    plane_T_character: Motor = field(default_factory=Motor.identity)
    ground_motion: Trajectory | None = None


@dataclass(frozen=True, eq=False)
class OverlayVideo:
    """A video, and what it shows.

    Fields:
        path: the file.
        frames_with_character: how many frames show something drawn.
        frames: how many there are.
        stands_on, lit_by: on what the character stands, and what lights it.
        footage: "original", or "undistorted".
        along: which path it was drawn along: "measured", or "smoothed".
        seconds: what drawing took.
    """

    path: Path
    frames_with_character: int
    frames: int
    stands_on: str
    lit_by: str
    footage: str
    along: str
    seconds: float = field(metadata=ASIDE)
