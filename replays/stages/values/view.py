"""Who stands where in the augmented view, and the video of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

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


# Of the frames, of a figure's pixels, and of the image's height: less than this is hardly seen.
SEEN_FRAMES, SEEN_PIXELS, SEEN_HEIGHT = 0.5, 0.5, 0.05
# In its heights: lower it is sunk, higher it hovers, and farther a foot slides.
OFF_GROUND, SLIDES = 0.02, 0.02
# Facing farther off its way than this for most of it, a figure does not go as people go.
ASTRAY_DEG = 60.0


@dataclass(frozen=True, eq=False)
class FigureCheck:
    """What a film shows of a figure, frame by frame; NaN where there is no pose or it is not there.

    Fields:
        name: what it is called.
        visible_px: ``(F,)`` pixels of it that are seen.
        drawn_px: ``(F,)`` those in the image, were nothing before it.
        inside: ``(F,)`` the share of it that is in the image.
        height_px: ``(F,)`` how high it is in the image.
        bottom: ``(F,)`` how high its lowest point lies over its ground, in its heights.
        astray_rad: ``(F,)`` how far it faces off its way; NaN where it stands as well.
        slide: the farthest that a foot goes on the ground in one contact, in its heights.
    """

    name: str
    visible_px: FloatArray
    drawn_px: FloatArray
    inside: FloatArray
    height_px: FloatArray
    bottom: FloatArray
    astray_rad: FloatArray
    slide: float

    @property
    def hidden(self) -> float:
        """The share of its pixels in the image that something hides, over all frames."""
        drawn = float(np.nansum(self.drawn_px))
        seen = float(np.nansum(self.visible_px))
        return max(0.0, 1.0 - seen / drawn) if drawn > 0.0 else 0.0

    @property
    def shown(self) -> tuple[int, int]:
        """In how many frames some of it is seen, and in how many it should be."""
        posed = np.isfinite(self.visible_px)
        return int(np.count_nonzero(self.visible_px[posed] >= 1.0)), int(np.count_nonzero(posed))

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready figures, medians over the frames in which it is seen."""
        seen = self.visible_px >= 1.0
        middle = [
            float(np.median(row[seen])) if np.any(seen) else 0.0
            for row in (self.visible_px, self.inside, self.height_px)
        ]
        posed = self.bottom[np.isfinite(self.bottom)]
        astray = self.astray_rad[np.isfinite(self.astray_rad)]
        return {
            "name": self.name,
            "frames_seen": self.shown[0],
            "frames": self.shown[1],
            "visible_px": middle[0],
            "hidden_share": self.hidden,
            "inside_share": middle[1],
            "height_px": middle[2],
            "lowest_share_of_height": float(posed.min()) if len(posed) else None,
            "highest_share_of_height": float(posed.max()) if len(posed) else None,
            "foot_slide_share_of_height": self.slide,
            "heading_off_way_deg": float(np.degrees(np.median(astray))) if len(astray) else None,
        }

    def doubts(self, image_px: int) -> tuple[str, ...]:
        """What somebody who looks at the film would object to.

        Args:
            image_px: height of the image.
        """
        seen, frames = self.shown
        if not frames:
            return ()
        figures, doubts = self.as_dict(), []
        if seen < SEEN_FRAMES * frames:
            doubts.append(f"is seen in {seen} of {frames} frames")
        if self.hidden > SEEN_PIXELS:
            doubts.append(f"is hidden for {self.hidden:.0%} by what is before it")
        if seen and figures["height_px"] < SEEN_HEIGHT * image_px:
            doubts.append(f"is {figures['height_px']:.0f} of {image_px} pixels high")
        low, far = figures["lowest_share_of_height"], figures["heading_off_way_deg"]
        if low < -OFF_GROUND:
            doubts.append(f"reaches {-low:.0%} of its height below its ground")
        if low > OFF_GROUND:
            doubts.append(f"hovers {low:.0%} of its height or more over its ground")
        if self.slide > SLIDES:
            doubts.append(f"slides on a foot by {self.slide:.1%} of its height")
        if far is not None and far > ASTRAY_DEG:
            doubts.append(f"faces {far:.0f}° off the way that it goes")
        return tuple(f"the film: '{self.name}' {doubt}" for doubt in doubts)


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
        checks: what it shows of each figure, and the height of its images.
        seconds: what drawing took.
    """

    path: Path
    frames_with_character: int
    frames: int
    stands_on: str
    lit_by: str
    footage: str
    along: str
    checks: tuple[FigureCheck, ...]
    height_px: int
    seconds: float = field(metadata=ASIDE)
