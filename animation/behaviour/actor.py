"""Who acts: a character with its gait, how it idles, what it can do, and how far its body reaches.

Everything is at the character's own size; `Actor.scale` takes it to the plane's metres.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from motorcade.animation.behaviour.sources import Gaze
from motorcade.animation.blend import BlendSpace, RootMotion, grounded, in_step
from motorcade.animation.blend.alignment import GroundedMotion, planted
from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.ik import Leg
from motorcade.animation.place.walks import MOST_M_S2, Pace, on_the_spot, passing_s, rigid
from motorcade.animation.retarget import facing_rad
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import wrapped
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive, frozen
from motorcade.ga.names import check_word

# Samples of a blended cycle, and moments of a clip at which a body's reach is looked for.
SAMPLES, MOMENTS = 97, 16
# When a layer may lie over the rest.
LASTING = ("walk", "idle", "act", "always")
# Heights of persons, for whom accelerations are told.
PERSON_M = 1.75
# A cycle's own speed, and a wish for it, may differ by so much.
SAME_SPEED = 0.02
# Gaits that face farther apart as they go do not blend: one goes sideways or backwards.
MOST_APART_RAD = np.deg2rad(45.0)


@dataclass(frozen=True, eq=False)
class Act:
    """A clip on the spot, and what it travels.

    Fields:
        clip: rigid, in character space.
        motion: where it goes meanwhile.
    """

    clip: Clip
    motion: RootMotion

    @classmethod
    def of(cls, clip: Clip, skeleton: Skeleton, legs: Sequence[Leg]) -> Act:
        """A clip as it is acted: from where the character stands, the way that it looks.

        Feet that stand in it are put on the ground: those of captured motions may hang over it.

        Raises:
            ValueError: a clip of a single pose.
        """
        motion = grounded(replace(clip, poses=clip.poses.rigid, looped=False), skeleton)
        motion = planted(replace(motion, clip=replace(motion.clip, looped=False)), skeleton, legs)
        return cls(motion.clip, motion.way)


@dataclass(frozen=True, eq=False)
class ClipLayer:
    """A clip over what the character does in one state.

    Args:
        clip: a loop repeats; any other is played once and holds its last pose.
        mask: ``(J,)`` its share of every joint, 0 to 1.
        during: "walk", "idle", "act", or "always".
        additive: whether it is added, as the difference to its own first pose.

    Raises:
        ValueError: another word, or a mask of another shape or outside 0 to 1.
    """

    clip: Clip
    mask: FloatArray
    during: str = "walk"
    additive: bool = False

    def __post_init__(self) -> None:
        check_word(self.during, LASTING, "ClipLayer.during")
        mask, joints = checked_floats(self.mask, "ClipLayer.mask", ()), self.clip.poses.shape[-1]
        if mask.shape != (joints,) or np.any(mask < 0.0) or np.any(mask > 1.0):
            raise ValueError(
                f"ClipLayer.mask: expected {joints} shares from 0 to 1, got {self.mask!r}"
            )
        object.__setattr__(self, "mask", frozen(mask))


@dataclass(frozen=True, eq=False)
class Actor:
    """A character that can follow an errand.

    Args:
        name: what it is called.
        character: with legs, if it is to walk or turn.
        legs: left first; see `legs_of` and `fitted_legs`.
        scale: from its own size to the plane's metres.
        idle: what it does while it waits, rigid and on the spot.
        cycle: one cycle of its gait on the spot (see `gait_between`); None for one that stays.
        speed_m_s: of the ground under the cycle, at its own size.
        acts: what it can do, by name.
        layers: clips over the others.

    Raises:
        ValueError: a scale or speed that is not above 0, a gait without legs.
    """

    name: str
    character: Character
    legs: tuple[Leg, ...]
    scale: float
    idle: Clip
    cycle: Clip | None = None
    speed_m_s: float = 1.0
    acts: Mapping[str, Act] | None = None
    layers: tuple[ClipLayer, ...] = ()

    def __post_init__(self) -> None:
        checked_positive(self.scale, "Actor.scale")
        checked_positive(self.speed_m_s, "Actor.speed_m_s")
        if self.cycle is not None and not self.legs:
            raise ValueError(f"Actor.cycle: '{self.name}' has no legs to walk with")

    @property
    def skeleton(self) -> Skeleton:
        """Of the character."""
        return self.character.skeleton

    @cached_property
    def standing(self) -> Clip:
        """How it stands between what it does: as its idling begins."""
        return Clip("standing", self.idle.time_s[:1], self.idle.poses.rigid[:1])

    @cached_property
    def gaze(self) -> Gaze:
        """What it looks with.

        Raises:
            ValueError: nothing tells its head.
        """
        return Gaze.of(self.character)

    def pace(self, length_m: float) -> Pace:
        """How it goes a way of this length, in the plane's metres, from standing to standing.

        Raises:
            ValueError: a character without a gait.
        """
        if self.cycle is None:
            raise ValueError(f"'{self.name}' has no gait to walk a path with")
        return Pace(
            length_m / self.scale,
            self.speed_m_s,
            self.cycle.duration_s,
            self._passing_s,
            most_m_s2=self.size * MOST_M_S2,
        )

    @property
    def size(self) -> float:
        """How many times as tall as a person it is by its file, whose clips keep their time."""
        return self.character.height_m / PERSON_M

    @cached_property
    def _passing_s(self) -> tuple[float, ...]:
        assert self.cycle is not None  # asked by `pace` alone
        pose = rigid(self.standing, 0.0)
        return passing_s(self.cycle, pose, self.skeleton, self.legs, self.speed_m_s)

    def skin_m(self, poses: Motor, most: int | None = None) -> FloatArray:
        """Points of the skin ``(*, P, 3)`` in character space, each moved by one joint alone.

        It is the one that moves it most, so that points lie off the skin by little, near joints.

        Args:
            poses: Motor ``(*, J)``.
            most: about how many points, evenly taken; all vertices by default.
        """
        held, own = self._held
        step = 1 if most is None else max(1, len(held) // most)
        world = self.skeleton.world(poses)
        return world[..., held[::step]].apply(own[::step])

    @cached_property
    def _held(self) -> tuple[IntArray, FloatArray]:
        """For each vertex the joint that moves it most, and where it lies in that joint's frame."""
        character = self.character
        joints, _ = character.influences
        held = joints[:, 0]
        return held, self.skeleton.rest_world_inverse[held].apply(character.vertices)

    @cached_property
    def radii_m(self) -> Mapping[tuple[bool, str], float]:
        """Radii in the plane's metres of upright cylinders about its place that hold it.

        By whether it acts, and by what it does: "idle", "walk", or the act's name.
        """
        acts = {name: act.clip for name, act in (self.acts or {}).items()}
        clips = {(True, name): clip for name, clip in acts.items()} | {(False, "idle"): self.idle}
        if self.cycle is not None:
            clips[False, "walk"] = self.cycle
        own = {key: self._radius_m(clip) for key, clip in clips.items()}
        for layer in self.layers:
            over = self._radius_m(layer.clip)
            for key in own:
                state = "act" if key[0] else key[1]
                if layer.during in (state, "always"):
                    own[key] = max(own[key], over)
        return own

    def _radius_m(self, clip: Clip) -> float:
        clock = np.linspace(0.0, clip.duration_s, MOMENTS) + clip.time_s[0]
        at = self.skin_m(rigid(clip, clock))
        return self.scale * float(np.linalg.norm(at[..., :2], axis=-1).max())


def gait_between(
    clips: Sequence[Clip], skeleton: Skeleton, legs: Sequence[Leg], speed_m_s: float | None = None
) -> tuple[Clip, float]:
    """A cycle on the spot for a speed, of gaits blended in phase, and the speed of its ground.

    Args:
        clips: cycles of one walk or more, in any order; they may travel.
        skeleton: with J joints.
        legs: whose feet tell the speeds.
        speed_m_s: at the character's own size, within what the gaits have; the first gait's own by
            default.

    Raises:
        ValueError: no clip, or one that is no gait, gaits of one speed, or a speed that they do
            not have; the message says what they have.
    """
    if not clips:
        raise ValueError("gait_between(clips): expected one gait or more, got none")
    loops = [on_the_spot(replace(clip, poses=clip.poses.rigid), skeleton, legs) for clip in clips]
    if speed_m_s is None:
        return loops[0]
    order = sorted(loops, key=lambda loop: loop[1])
    speeds = np.array([speed for _, speed in order])
    low, high = speeds[0], speeds[-1]
    if not (1.0 - SAME_SPEED) * low <= speed_m_s <= (1.0 + SAME_SPEED) * high:
        had = f"{low:.3g} m/s" if len(order) == 1 else f"{low:.3g} to {high:.3g} m/s"
        raise ValueError(
            f"gait_between(speed_m_s): expected a speed that the gaits have, {had} at the "
            f"character's own size, got {speed_m_s:.3g}; name a slower or faster gait beside them"
        )
    if len(order) == 1:
        return order[0]
    motions = [_straight(loop, speed) for loop, speed in order]
    facing = [facing_rad(skeleton, skeleton.world(loop.poses).translation_m) for loop, _ in order]
    faces = [0.0 if one is None else float(np.mean(one)) for one in facing]
    if (apart := np.abs(wrapped(np.subtract(faces, faces[0]))).max()) > MOST_APART_RAD:
        raise ValueError(
            f"gait_between(clips): expected gaits that face alike as they go, got "
            f"{np.degrees(apart):.0f} degrees between two; blend a forward gait with a forward one"
        )
    alike = [in_step(motions[0], motion, skeleton, legs)[0].clip for motion in motions[1:]]
    space = BlendSpace(speeds, (motions[0].clip, *alike))
    phase = np.linspace(0.0, 1.0, SAMPLES)
    poses = space.pose(speed_m_s, phase).coefficients.copy()
    poses[-1] = poses[0]
    name = " to ".join(clip.name for clip, _ in order)
    cycle = Clip(name, phase * float(space.duration_s(speed_m_s)), Motor(poses), looped=True)
    return on_the_spot(cycle, skeleton, legs)


def _straight(loop: Clip, speed_m_s: float) -> GroundedMotion:
    """A gait on the spot with its way ahead."""
    ahead_m = Motor.from_translation([[0.0, 0.0, 0.0], [speed_m_s * loop.duration_s, 0.0, 0.0]])
    return GroundedMotion(loop, RootMotion(loop.time_s[[0, -1]], ahead_m, True), True)
