"""Motions of which behaviours are made: layered, leaning and stepping poses, and ways on the plane.

All are `blend.PoseSource`s. A way is the pose of the character on the plane, as of one joint: so
that it is switched from one to the next by inertia as poses are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.blend import (
    PoseLayer,
    Poses,
    PoseSource,
    RootMotion,
    added,
    additive,
    blend_layers,
)
from motorcade.animation.easing import smootherstep, smoothstep
from motorcade.animation.ik import Leg, bend_limb
from motorcade.animation.place.pacing import Pace
from motorcade.animation.place.walks import GroundPath, rigid
from motorcade.animation.skeleton import Skeleton, with_joint
from motorcade.animation.vectors import UP, turn_x, turn_z
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

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
