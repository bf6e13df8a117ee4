"""Who stands where in the augmented view, and the video of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from motorcade.animation import Clip, Placement
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.stages.values.camera_poses import ASIDE


@dataclass(frozen=True)
class PartState:
    """A state of a character of a cast: what it does, by which clip, and from when to when."""

    state: str
    clip: str
    start_s: float
    end_s: float


@dataclass(frozen=True, eq=False)
class PlayedPart:
    """A character of a cast, or a character or prop of a scene, and all that it does.

    Fields:
        name: what it is called.
        character: "mannequin" or a file.
        placement: where its poses are told from.
        time_s: ``(F,)`` from the first frame on.
        poses: Motor ``(F, J)``, local poses; its root goes its way.
        states: in their order.
        note: how it keeps out of the others' way; "" where it does as it was asked.
        worst_slide_m: the farthest that a foot goes on the ground in one step; None for one of a
            scene that does not walk.
        motion: of a scene, `placement_T_character` with its scale, from the first frame on.
        ground_motion: of a scene, what moves the placement along; see `PlacedCharacter`.
        visible_s: from when to when it is seen; None for always.
        up, front: axes of the character's file, where the user knows better than the file.
    """

    name: str
    character: str
    placement: Placement
    time_s: FloatArray
    poses: Motor
    states: tuple[PartState, ...]
    note: str = ""
    worst_slide_m: float | None = None
    motion: Trajectory | None = None
    ground_motion: Trajectory | None = None
    visible_s: tuple[float, float] | None = None
    up: str | None = None
    front: str | None = None

    @property
    def clip(self) -> Clip:
        """All that it does, as one clip."""
        return Clip(self.name, self.time_s, self.poses)


@dataclass(frozen=True, eq=False)
class StandingPlace:
    """Something that a character could stand on.

    Fields:
        name: in words.
        doubt: what of it is a guess, in words; "" where nothing is.
        corners_m: ``(k, 3)`` of as much of it as is known, in the world.
    """

    name: str
    doubt: str
    corners_m: FloatArray


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
        parts: of a cast or a scene, what all do, the one first that the other fields tell of.
        apart_m: the least distance between two bodies of it; None for one alone.
        up, front: axes of the character's file, where the user knows better than the file.
        hide: names of the character's meshes that are not drawn.
        choices: what there is to stand on, by the numbers of `placed.floor` from 1 on.
        doubt: what of it is a guess, in words; "" where nothing is.
        looks_at_m: ``(3,)`` a place in the world that it lifts its head to; None for none.
    """

    character: str
    clip: str
    placement: Placement
    stands_on: str
    path_m: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    plane_T_character: Motor = field(default_factory=Motor.identity)
    ground_motion: Trajectory | None = None
    parts: tuple[PlayedPart, ...] = ()
    apart_m: float | None = None
    up: str | None = None
    front: str | None = None
    hide: tuple[str, ...] = ()
    choices: tuple[StandingPlace, ...] = ()
    doubt: str = ""
    looks_at_m: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class OverlayVideo:
    """A video, and what it shows.

    Fields:
        path: the file.
        frames_with_character: how many frames show something drawn.
        frames: how many there are.
        stands_on, lit_by: on what the character stands, and what lights it.
        footage: "original", "undistorted", or "steadied".
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
