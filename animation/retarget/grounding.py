"""Feet on the ground after retargeting: as high as the source's, and on soles of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from motorcade.animation.anatomy.words import SIDES
from motorcade.animation.clip import Clip
from motorcade.animation.ik import Leg
from motorcade.animation.ik.feet import GroundHeights, smooth_over
from motorcade.animation.ik.soles import bent_toes, sole_clearance_m
from motorcade.animation.retarget.roles import NO_BONE_M, Match, body_of, legs_of
from motorcade.animation.skeleton import Skeleton, turned_joint, with_joint
from motorcade.animation.vectors import UP
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

# Of all moments, the share in which the lower foot is taken to be below where it stands.
LOWEST_SHARE = 0.2
# A source whose soles come down to within this share of its legs stands there.
STANDING = 0.15
FLOOR = GroundHeights()


def grounded(
    match: Match, clip: Clip, poses: Motor, carrier: int, fitted: Sequence[Leg] | None
) -> Motor:
    """Poses raised or lowered so that at each moment the lower foot is as high as the source's.

    Heights are in proportion to the legs, and measured on both figures alike. Where the source's
    rest tells no soles, they are differences; the target's soles then are put on the ground as a
    whole: raised moment by moment, feet that roll would lift the body, and none would stand still.
    Toes that would roll into the ground then bend, and only what is below it after that is raised.
    Without feet on both sides poses stay.

    Args:
        match: of the two figures.
        clip: of the source.
        poses: Motor ``(F, J)`` of the target.
        carrier: the target's joint that is raised.
        fitted: legs of the target whose soles are known; None where ankles and balls alone are.
    """
    target, flat, others = match.target, match.comparable, legs_of(match.source)
    bare = [replace(leg, heel=0.0, tip=0.0) for leg in legs_of(target)]
    legs = bare if fitted is None else fitted
    if not legs or not others:
        return poses
    world = target.world(poses)
    own = _clearance_m(target, world, legs, flat)
    other = _clearance_m(match.source, match.source_world, others, flat)
    level = float(np.quantile(other, LOWEST_SHARE))
    if abs(level) < STANDING * leg_m(match.source):
        other = np.maximum(other - level, 0.0)
    rise = leg_scale(match) * other - own
    if not flat:
        rise -= np.quantile(_clearance_m(target, world, legs, True) + rise, LOWEST_SHARE)
    poses = _raised(target, poses, carrier, rise)
    if flat or fitted is None:
        return poses
    for leg in legs:
        poses = _with_bent_toes(target, poses, leg)
    sunk = np.maximum(-_clearance_m(target, target.world(poses), legs, True), 0.0)
    return _raised(target, poses, carrier, _smoothly(sunk, clip))


def _smoothly(rise_m: FloatArray, clip: Clip) -> FloatArray:
    """A smooth curve ``(F,)`` nowhere below, which closes where the clip is a loop."""
    steps = len(rise_m) - 1
    if not clip.looped or steps < 1:
        return smooth_over(rise_m, clip.time_s)
    rounds = clip.time_s[None, :-1] + clip.duration_s * np.array([[-1.0], [0.0], [1.0]])
    made = smooth_over(np.tile(rise_m[:-1], 3), rounds.ravel())[steps : 2 * steps]
    return np.append(made, made[0])


def _raised(target: Skeleton, poses: Motor, carrier: int, rise_m: FloatArray) -> Motor:
    """Poses whose carrier is raised by heights ``(F,)``."""
    parent = int(target.parents[carrier])
    up = np.broadcast_to(UP, (len(rise_m), 3)) * rise_m[:, None]
    if parent >= 0:
        up = target.world(poses)[:, parent].rotor.inverse().apply(up)
    return with_joint(poses, carrier, Motor.from_translation(up) @ poses[:, carrier])


def _with_bent_toes(target: Skeleton, poses: Motor, leg: Leg) -> Motor:
    ankle, ball = leg.foot(target)
    if target.parents[ball] != ankle:
        return poses
    world = target.world(poses)
    toes = bent_toes(target, (world[:, ankle], world[:, ball]), leg.sole(target), FLOOR.height_m)
    return turned_joint(poses, ball, world[:, ankle].rotor.inverse() @ toes)


def _clearance_m(skeleton: Skeleton, world: Motor, legs: Sequence[Leg], flat: bool) -> FloatArray:
    """Heights ``(F,)`` of the lowest part of the feet over the ground.

    Soles lie on z = 0 at rest; where the rest is a stride, the height at which each foot's joints
    stand is told by their lowest moments.

    Args:
        skeleton: with J joints.
        world: Motor ``(F, J)``, its joints in character space.
        legs: of it, one or more.
        flat: whether the rest pose tells the soles.
    """
    feet = []
    pairs = [leg.foot(skeleton) for leg in legs]
    for leg, (ankle, ball) in zip(legs, pairs, strict=True):
        if flat:
            pair = world[:, ankle], world[:, ball]
            feet.append(sole_clearance_m(skeleton, pair, leg.sole(skeleton), FLOOR.height_m))
            continue
        for joint in {ankle, ball}:
            height = world[:, joint].translation_m[:, 2]
            feet.append(height - np.quantile(height, LOWEST_SHARE))
    made: FloatArray = np.min(feet, axis=0)
    return made


def leg_scale(match: Match) -> float:
    """How much longer the target's legs are; 1 where they are not known."""
    lengths = [leg_m(skeleton) for skeleton in (match.target, match.source)]
    return lengths[0] / lengths[1] if min(lengths) > NO_BONE_M else 1.0


def leg_m(skeleton: Skeleton) -> float:
    """Mean length of the legs, thigh and calf; 0 where they are not known."""
    body, at = body_of(skeleton), skeleton.rest_world.translation_m
    parts = ("thigh", "calf", "foot")
    lengths = [
        sum(
            float(np.linalg.norm(at[body[f"{side}_{b}"]] - at[body[f"{side}_{a}"]]))
            for a, b in pairwise(parts)
        )
        for side in SIDES
        if all(f"{side}_{part}" in body for part in parts)
    ]
    return float(np.mean(lengths)) if lengths else 0.0
