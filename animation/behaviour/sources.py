"""Motions of which behaviours are made: layers, leaning, steps, looks, and ways on the plane.

All are `blend.PoseSource`s. A way is the pose of the character on the plane, as of one joint: so
that it is switched from one to the next by inertia as poses are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.anatomy.tree import named_eyes
from motorcade.animation.blend import PoseLayer, RootMotion, added, additive, blend_layers
from motorcade.animation.blend.methods import Poses
from motorcade.animation.blend.transitions import PoseSource
from motorcade.animation.character import Character
from motorcade.animation.easing import smootherstep, smoothstep
from motorcade.animation.ik import Leg, bend_limb
from motorcade.animation.ik.chain import Ball
from motorcade.animation.ik.solver import IkSolver, LookAt
from motorcade.animation.place.walks import GroundPath, Pace, rigid
from motorcade.animation.retarget import body_of
from motorcade.animation.skeleton import Skeleton, with_joint
from motorcade.animation.vectors import UP, length, turn_x, turn_z, unit
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen

GRAVITY_M_S2 = 9.81
# A lean goes by the bend of the way from so long before to so long after.
LEAN_OVER_S = 0.25
# Farther nobody leans: a bend that needs it is taken too fast.
MOST_LEAN_RAD = np.deg2rad(20.0)
# A step of a turn: one foot swings for this long, and no turn in two steps is wider than that.
STEP_S, WIDEST_RAD = 0.4, np.deg2rad(75.0)
# How high a foot is lifted in it, as a share of the leg.
LIFTED = 0.06


@dataclass(frozen=True, eq=False)
class Still:
    """A way that stays where it is."""

    plane_T_character: Motor

    def at(self, time_s: ArrayLike) -> Motor:
        """Motor ``(*, 1)``."""
        shape = (*np.shape(time_s), 1, 8)
        return Motor(np.broadcast_to(self.plane_T_character.coefficients, shape))


@dataclass(frozen=True, eq=False)
class Along:
    """A way along a path at a pace, from `start_s` on."""

    path: GroundPath
    pace: Pace
    scale: float
    start_s: float
    gravity_m_s2: float = GRAVITY_M_S2

    def at(self, time_s: ArrayLike) -> Motor:
        """Motor ``(*, 1)``."""
        position, heading = self._on(np.asarray(time_s, dtype=np.float64) - self.start_s)
        flat = np.concatenate([position, np.zeros((*position.shape[:-1], 1))], axis=-1)
        motor = Motor.from_rotor_translation(turn_z(heading), flat)
        return motor.reshape(*motor.shape, 1)

    def lean_rad(self, passed_s: FloatArray) -> FloatArray:
        """How far to lean to the left ``(*)``, so that gravity and the bend's pull go down."""
        clock = np.clip(passed_s, 0.0, self.pace.done_s)
        ends = np.stack([clock - LEAN_OVER_S, clock + LEAN_OVER_S])
        along = self.pace.along_m(ends)
        heading = np.unwrap(self.path.at(self.scale * along)[1], axis=0)
        speed = (along[1] - along[0]) / (2.0 * LEAN_OVER_S)
        rate = (heading[1] - heading[0]) / (2.0 * LEAN_OVER_S)
        lean = np.arctan2(speed * rate, self.gravity_m_s2)
        return np.asarray(MOST_LEAN_RAD * np.tanh(lean / MOST_LEAN_RAD))

    def _on(self, passed_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        along = self.scale * self.pace.along_m(np.clip(passed_s, 0.0, self.pace.done_s))
        return self.path.at(np.clip(along, 0.0, self.path.length_m))


@dataclass(frozen=True, eq=False)
class Turning:
    """A way that turns on the spot by an angle, in steps of both feet, from `start_s` on."""

    before: Motor
    angle_rad: float
    start_s: float

    @property
    def rounds(self) -> int:
        """How often both feet step."""
        return max(1, int(np.ceil(abs(self.angle_rad) / WIDEST_RAD)))

    @property
    def lasts_s(self) -> float:
        """From its start to its end."""
        return 2.0 * STEP_S * self.rounds

    def at(self, time_s: ArrayLike) -> Motor:
        """Motor ``(*, 1)``."""
        beat = (np.asarray(time_s, dtype=np.float64) - self.start_s) / STEP_S
        beats = 2.0 * self.rounds
        # The body rests between two steps, so that no foot slides as it is lifted and set down.
        whole = np.floor(np.clip(beat, 0.0, beats))
        share = (whole + smootherstep(beat - whole) * (whole < beats)) / beats
        turn = turn_z(self.angle_rad * share)
        motors = self.before @ Motor.from_rotor_translation(turn, np.zeros((*share.shape, 3)))
        return motors.reshape(*motors.shape, 1)

    def swinging(self, leg: int, passed_s: FloatArray) -> FloatArray:
        """How far leg 0 (left) or 1 is through its swing ``(*)``, from 0 to 1; 0 where it stands.

        The foot on the side that is turned to goes first, so that feet do not cross.
        """
        first = 0 if self.angle_rad > 0.0 else 1
        beat = passed_s / STEP_S - (0.0 if leg == first else 1.0)
        inside = (beat >= 0.0) & (beat < 2.0 * self.rounds) & (beat % 2.0 < 1.0)
        return np.where(inside, beat % 2.0, 0.0)


@dataclass(frozen=True, eq=False)
class Travelling:
    """A way that a clip travels from where it starts, at the size of the character."""

    before: Motor
    motion: RootMotion
    scale: float
    start_s: float

    def at(self, time_s: ArrayLike) -> Motor:
        """Motor ``(*, 1)``."""
        first, last = self.motion.time_s[[0, -1]]
        clock = np.asarray(time_s, dtype=np.float64) - self.start_s + first
        moved = self.motion.at(np.clip(clock, first, last - 1e-9))
        motors = self.before @ Motor.from_rotor_translation(
            moved.rotor, self.scale * moved.translation_m
        )
        return motors.reshape(*motors.shape, 1)


@dataclass(frozen=True, eq=False)
class Leaning:
    """Poses that lean into the bends of a way, about the character's own x on the ground."""

    motion: PoseSource
    along: Along
    root: int

    def at(self, time_s: ArrayLike) -> Motor:
        """Local poses ``(*, J)``."""
        poses = rigid(self.motion, time_s)
        passed = np.asarray(time_s, dtype=np.float64) - self.along.start_s
        turn = turn_x(-self.along.lean_rad(passed))
        lean = Motor.from_rotor_translation(turn, np.zeros((*passed.shape, 3)))
        return with_joint(poses, self.root, lean @ poses[..., self.root])


@dataclass(frozen=True, eq=False)
class Stepping:
    """Poses whose feet are lifted where a turn has them swing."""

    motion: PoseSource
    turn: Turning
    skeleton: Skeleton
    legs: Sequence[Leg]

    def at(self, time_s: ArrayLike) -> Motor:
        """Local poses ``(*, J)``."""
        poses = rigid(self.motion, time_s)
        passed = np.asarray(time_s, dtype=np.float64) - self.turn.start_s
        for number, leg in enumerate(self.legs[:2]):
            poses = lifted(self.skeleton, poses, leg, self.turn.swinging(number, passed))
        return poses


def lifted(
    skeleton: Skeleton,
    poses: Motor,
    leg: Leg,
    through: FloatArray,
    ankle_m: FloatArray | None = None,
) -> Motor:
    """Poses ``(*, J)`` whose foot is lifted by how far ``(*)`` it is through a step, 0 to 1.

    The ankle is lifted over where it is, or over places ``(*, 3)`` in character space.
    """
    at = skeleton.world(poses).translation_m
    hip, ankle = (at[..., skeleton.index(name), :] for name in (leg.hip, leg.ankle))
    high = LIFTED * np.linalg.norm(hip - ankle, axis=-1) * np.sin(np.pi * through) ** 2
    over = ankle if ankle_m is None else ankle_m
    return bend_limb(skeleton, poses, leg.limb, over + high[..., None] * UP)


@dataclass(frozen=True, eq=False)
class Layered:
    """A motion with another over some of its joints, or added to it, from one time to another.

    Args:
        over: the motion laid over it, or where `reference` is given, added to it.
        mask: ``(J,)`` its share of every joint.
        span_s: from when to when; it is faded in and out over `fade_s` within.
        reference: the pose ``(J,)`` that an additive motion is the difference to.
    """

    base: PoseSource
    over: PoseSource
    mask: FloatArray
    span_s: tuple[float, float]
    fade_s: float
    reference: Motor | None = None

    def at(self, time_s: ArrayLike) -> Motor:
        """Local poses ``(*, J)``."""
        clock = np.asarray(time_s, dtype=np.float64)
        below, above = rigid(self.base, clock), rigid(self.over, clock)
        start, end = self.span_s
        fade = max(min(self.fade_s, 0.5 * (end - start)), 1e-9)
        share = smoothstep((clock - start) / fade) * smoothstep((end - clock) / fade)
        if self.reference is not None:
            weights = share[..., None] * self.mask
            return _motor(added(below, additive(above, self.reference), weights))
        layers = [PoseLayer(below, mask=1.0 - self.mask), PoseLayer(above, mask=self.mask)]
        layered = _motor(blend_layers(layers, Motor.identity(self.mask.shape)))
        return below.interpolate(layered, share[..., None])


def _motor(poses: Poses) -> Motor:
    """What was made of rigid poses."""
    assert isinstance(poses, Motor)
    return poses


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
        eyes = [eye for eye in named_eyes(skeleton.names) if skeleton.parents[eye] == head]
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
