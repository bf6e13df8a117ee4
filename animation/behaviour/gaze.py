"""Looking at something: neck, head and eyes turned to a place that may move, within their limits.

The trunk goes on with what it does. What is behind the figure is not looked at: the head goes back
to its own motion, and comes again when the target comes into reach.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.anatomy.words import named_eyes
from motorcade.animation.character import Character
from motorcade.animation.easing import smootherstep, smoothstep
from motorcade.animation.ik import Ball, IkSolver, LookAt
from motorcade.animation.retarget import body_of
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import UP, length, unit
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen

AHEAD = np.array([1.0, 0.0, 0.0])
# How far neck and head together nod or lean, and turn, from rest; and eyes, any way.
SWING_RAD, TURN_RAD, EYES_RAD = np.deg2rad(50.0), np.deg2rad(70.0), np.deg2rad(25.0)
# Off the way that the trunk faces: within the first angle all of it is looked at, beyond the other
# none.
REACH_RAD, LOST_RAD = np.deg2rad(75.0), np.deg2rad(110.0)
# When it begins to look, and how long it takes to.
WAITS_S, ONSET_S = 0.2, 0.8
# Where eyes are in a head: half way up, and ahead by so much of its depth.
EYES_AHEAD = 0.8


@dataclass(frozen=True, eq=False)
class LookTarget:
    """A place that is looked at.

    Args:
        time_s: ``(T,)`` rising; before the first and after the last it is still.
        at_m: ``(T, 3)`` on the plane, metres.

    Raises:
        ValueError: no place, times that do not rise, shapes that do not fit, numbers not finite.

    >>> from motorcade.animation.behaviour import LookTarget
    >>> LookTarget([0.0, 2.0], [[1.0, 0, 1], [3.0, 0, 1]]).at([0.5]).tolist()
    [[1.5, 0.0, 1.0]]
    """

    time_s: FloatArray
    at_m: FloatArray

    def __post_init__(self) -> None:
        times = checked_floats(self.time_s, "LookTarget.time_s", ())
        places = checked_floats(self.at_m, "LookTarget.at_m", (3,))
        if times.ndim != 1 or not times.size or np.any(np.diff(times) <= 0.0):
            raise ValueError("LookTarget.time_s: expected (T,) rising seconds, T at least 1")
        if places.shape != (times.size, 3):
            raise ValueError(
                f"LookTarget.at_m: expected shape ({times.size}, 3), got {places.shape}"
            )
        object.__setattr__(self, "time_s", frozen(times))
        object.__setattr__(self, "at_m", frozen(places))

    def at(self, time_s: ArrayLike) -> FloatArray:
        """Places ``(*, 3)`` at times ``(*)``."""
        clock = np.asarray(time_s, dtype=np.float64)
        columns = [np.interp(clock, self.time_s, column) for column in self.at_m.T]
        return np.stack(columns, axis=-1)


@dataclass(frozen=True, eq=False)
class Gaze:
    """What a figure looks with.

    Fields:
        solver: of neck, head and eyes.
        head: its number.
        eyes: names of joints of eyes; none in most rigs.
        point_m: ``(3,)`` in the head's frame, between the eyes.
        trunk: number of the joint that neck or head hangs on.
    """

    solver: IkSolver
    head: int
    eyes: tuple[str, ...]
    point_m: FloatArray
    trunk: int

    @classmethod
    def of(cls, character: Character) -> Gaze:
        """Of a character at rest, looking along +x.

        Raises:
            ValueError: neither bones nor names tell a head that hangs on a trunk.
        """
        skeleton, body = character.skeleton, body_of(character.skeleton)
        head, neck = body.get("head"), body.get("neck")
        first = head if neck is None else neck
        if head is None or first is None or skeleton.parents[first] < 0:
            raise ValueError("look_at: neither bones nor names tell the character's head")
        line = [head] if neck is None else [neck, head]
        eyes = _eyes(skeleton, head)
        swing, turn = SWING_RAD / len(line), TURN_RAD / len(line)
        joints = {
            skeleton.names[joint]: Ball(swing, (-turn, turn), axis=_inside(skeleton, joint, UP))
            for joint in line
        }
        joints |= {
            skeleton.names[eye]: Ball(EYES_RAD, (0.0, 0.0), axis=_inside(skeleton, eye, AHEAD))
            for eye in eyes
        }
        return cls(
            IkSolver(skeleton, joints),
            head,
            tuple(skeleton.names[one] for one in eyes),
            _between_eyes(character, head, eyes),
            int(skeleton.parents[first]),
        )

    def looking(self, poses: Motor, target_m: FloatArray, time_s: FloatArray) -> Motor:
        """Poses ``(F, J)`` that look at places ``(F, 3)`` in character space, from `WAITS_S` on."""
        skeleton = self.solver.skeleton
        world = skeleton.world(poses)
        faces = world[:, self.trunk].rotor.apply(_inside(skeleton, self.trunk, AHEAD))
        eyes = world[:, self.head].apply(self.point_m)
        away, far = unit(target_m - eyes), length(target_m - eyes)
        off = np.arccos(np.clip(np.sum(away * faces, axis=-1), -1.0, 1.0))
        # Beyond the neck's reach it aims as far as that goes: at limits a search would jump.
        aside = unit(away - np.sum(away * faces, axis=-1, keepdims=True) * faces)
        held = np.minimum(off, TURN_RAD)[:, None]
        aim = np.cos(held) * faces + np.sin(held) * aside
        target = np.where(off[:, None] > TURN_RAD, eyes + far * aim, target_m)
        names, ahead = skeleton.names, _inside(skeleton, self.head, AHEAD)
        goals = [LookAt(names[self.head], target, ahead, point_m=self.point_m)]
        for eye in self.eyes:
            goals.append(LookAt(eye, target, _inside(skeleton, skeleton.index(eye), AHEAD)))
        turned = self.solver.solve(poses, goals, restarts=0).local_pose
        share = smootherstep((LOST_RAD - off) / (LOST_RAD - REACH_RAD))
        share = share * smoothstep((time_s - WAITS_S) / ONSET_S)
        return poses.interpolate(turned, share[:, None])


def _inside(skeleton: Skeleton, joint: int, direction: FloatArray) -> FloatArray:
    """A direction of the figure at rest in a joint's frame."""
    return np.asarray(skeleton.rest_world[joint].rotor.inverse().apply(direction))


def _eyes(skeleton: Skeleton, head: int) -> list[int]:
    """Joints of eyes that hang on the head itself, by their names."""
    return [joint for joint in named_eyes(skeleton.names) if skeleton.parents[joint] == head]


def _between_eyes(character: Character, head: int, eyes: list[int]) -> FloatArray:
    """``(3,)`` in the head's frame: between joints of eyes, or where eyes are in most heads."""
    skeleton = character.skeleton
    back = skeleton.rest_world[head].inverse()
    if eyes:
        return np.asarray(back.apply(skeleton.rest_world.translation_m[eyes].mean(axis=0)))
    joints, _ = character.influences
    skin = character.vertices[joints[:, 0] == head]
    if not len(skin):
        return np.zeros(3)
    low, high = skin.min(axis=0), skin.max(axis=0)
    middle = 0.5 * (low + high)
    middle[0] = low[0] + EYES_AHEAD * (high[0] - low[0])
    return np.asarray(back.apply(middle))
