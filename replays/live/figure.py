"""A figure that stands where one taps, is dragged, turned and scaled, and walks to a tapped point.

The ground is z = 0 of the tracker's world, and gestures are pixels of the frame that was on show:
a finger is the ray of its pixel, from the camera's pose in that frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from motorcade.animation import Character
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
from motorcade.replays.pipeline.look.document import gltf_bytes
from motorcade.replays.pipeline.look.packing import packed, rows_of, scaled_rows
from motorcade.replays.stages.characters.acting import IDLE, character_named, rigid_clip
from motorcade.tracking import Camera

RATE_HZ = 30.0
SMALLEST, LARGEST = 0.1, 10.0
"""Of the size at which it stood first."""
FARTHEST = 50.0
"""Heights of the figure, from the ground's middle: rays that almost miss the ground end there."""
LONGEST_WALK_S = 60.0
_NEAREST = 0.05
"""Heights of the figure below which a walk is none."""
_KEPT = 16


def on_ground(pixel: FloatArray, camera: Camera, world_T_camera: Motor) -> FloatArray | None:
    """Where a pixel's ray meets the ground: ``(2,)``, None where it does not.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.replays.live.figure import on_ground
    >>> from motorcade.tracking import Camera
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> down = Motor.from_rotor_translation(Rotor.from_rotation_vector([np.pi, 0, 0]), [0, 0, 1.0])
    >>> on_ground(np.array([369.5, 239.5]), camera, down).round(3) + 0.0
    array([0.1, 0. ])
    """
    ray = world_T_camera.rotor.apply(camera.bearings(pixel))
    eye = world_T_camera.translation_m
    if not np.isfinite(ray).all() or abs(ray[2]) < 1e-9 or not -eye[2] / ray[2] > 0.0:
        return None
    point: FloatArray = (eye - ray * (eye[2] / ray[2]))[:2]
    return point


@dataclass
class LiveFigure:
    """Who stands on the ground, and what it does now. Times are seconds of the frames' clock.

    Args:
        file: "mannequin", or a character's file.
        height_m: how tall it stands at first, in the world's unit.

    Raises:
        ValueError: a file that holds no character, or one whose legs nothing tells.
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
