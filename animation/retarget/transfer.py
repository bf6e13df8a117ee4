"""Retargeting: a clip of one skeleton played by another.

Every joint turns in the world as its like does, but for a constant between the two (`reference`).
So joints that one skeleton has beside the other lose no motion: what a source's extra root or
extra spine joint does arrives in the joints that hang on it. Bones keep the target's lengths.
Spines of different numbers of joints, or of joints spaced otherwise, share turns by length.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from motorcade.animation.anatomy.words import SIDES
from motorcade.animation.clip import Clip
from motorcade.animation.retarget.reference import constants
from motorcade.animation.retarget.roles import (
    NO_BONE_M,
    Match,
    along_axes,
    ancestors,
    body_of,
    common_parent,
    joints_alike,
)
from motorcade.animation.skeleton import Skeleton, with_joint
from motorcade.animation.vectors import UP
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

# Joints whose bones lie nearer, as a share of the spine's length, are taken for alike.
ALIKE = 0.01


def spread_spine(match: Match) -> Match:
    """The match with a joint of the source's for each of the target's spine, where its bone lies.

    Each bone of a spine is taken to lie where its middle does, as a share of the way along the
    joints from the spine's first to neck or head. Between two bones of the source a joint is put in
    that turns from its rest by so much of both; beyond the first and the last there is none.
    """
    ours, theirs = _spine(match.target), _spine(match.source)
    if len(ours) < 2 or len(theirs) < 2 or not set(ours) <= set(match.joints):
        return match
    wanted, known = _shares(match.target, ours), _shares(match.source, theirs)
    names, parents = list(match.source.names), list(match.source.parents)
    rest, source_world = [match.source.rest], [match.source_world]
    joints = dict(match.joints)
    for joint, share in zip(ours, wanted, strict=True):
        after = int(np.clip(np.searchsorted(known, share), 1, len(known) - 1))
        a, b = theirs[after - 1], theirs[after]
        part = float(np.clip((share - known[after - 1]) / (known[after] - known[after - 1]), 0, 1))
        if min(part, 1.0 - part) * (known[after] - known[after - 1]) < ALIKE:
            joints[joint] = a if part < 0.5 else b
            continue
        joints[joint] = len(names)
        names.append(f"{match.source.names[a]} to {match.source.names[b]}, {joint}")
        parents.append(a)
        rest.append(Motor.identity((1,)))
        back = match.source.rest_world[b].rotor.inverse() @ match.source.rest_world[a].rotor
        if not match.comparable:  # at rest it is bent as well: frames are built along one another
            back = along_axes(back)
        start, end = match.source_world[:, a], match.source_world[:, b].rotor @ back
        turned = start.rotor.interpolate(end, part)
        between = Motor.from_rotor_translation(turned, start.translation_m)
        source_world.append(between.reshape(-1, 1))
    source = Skeleton(tuple(names), np.array(parents), _joined(rest))
    return Match(source, match.target, joints, _joined(source_world))


def _spine(skeleton: Skeleton) -> list[int]:
    body = body_of(skeleton)
    return [body[role] for role in sorted(body) if role.startswith("spine")]


def _shares(skeleton: Skeleton, spine: list[int]) -> FloatArray:
    """Where the bones' middles lie, rising from 0 to 1 ``(N,)``."""
    body, at = body_of(skeleton), skeleton.rest_world.translation_m
    top = body.get("neck", body.get("head", spine[-1]))
    steps = np.linalg.norm(np.diff(at[[*spine, top]], axis=0), axis=1)
    ends = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-9))])
    made: FloatArray = 0.5 * (ends[:-1] + ends[1:]) / ends[-1]
    return made


def _joined(parts: list[Motor]) -> Motor:
    return Motor(np.concatenate([one.coefficients for one in parts], axis=-2))


# Of all moments, the share in which the lower foot is taken to be below where it stands.
LOWEST_SHARE = 0.2


def retarget(
    clip: Clip,
    source: Skeleton,
    target: Skeleton,
    joints: Mapping[str, str] | None = None,
) -> Clip:
    """The clip for another skeleton; joints without a counterpart stay as they rest.

    The hips' way is scaled by the lengths of the legs. Where the source's rest is no pose to stand
    in, heights are set so that the feet stand on the ground. A root below the hips, where the
    target has one, takes the way over the ground. Feet of figures of other proportions slide a
    little: see `plant_feet`.

    Args:
        clip: of the source. Where its joints grow, growth is left out.
        source: which faces +x in character space, at rest or in the clip.
        target: that is to move; it rests standing, as a bound mesh does.
        joints: the source's joint for each of the target's; by default `joints_alike`. The hips
            go their way only if they, or what carries legs and trunk, are among them.

    Raises:
        ValueError: joints that one of the skeletons does not have, or no pair at all.

    >>> import numpy as np
    >>> from motorcade.animation import Clip, Skeleton, retarget
    >>> from motorcade.ga import Motor
    >>> def leg(*names, bone_m):
    ...     bones_m = bone_m * np.array([[0, 0, 2.0], [0, 0, -1.0], [0, 0, -1.0]])
    ...     return Skeleton(names, np.array([-1, 0, 1]), Motor.from_translation(bones_m))
    >>> actor = leg("LeftUpLeg", "LeftLeg", "LeftFoot", bone_m=0.5)
    >>> puppet = leg("thigh_l", "calf_l", "foot_l", bone_m=0.25)
    >>> step = Motor.from_translation([[1.0, 0, 1.0], [0, 0, -0.5], [0, 0, -0.5]]).reshape(1, 3)
    >>> clip = retarget(Clip("step", np.zeros(1), step), actor, puppet)
    >>> clip.poses.translation_m[0].round(3) + 0.0
    array([[ 0.5 ,  0.  ,  0.5 ],
           [ 0.  ,  0.  , -0.25],
           [ 0.  ,  0.  , -0.25]])
    """
    pairs = dict(joints_alike(target, source) if joints is None else joints)
    numbers = {target.index(name): source.index(other) for name, other in pairs.items()}
    if not numbers:
        raise ValueError(
            "retarget(joints): expected one pair or more, got none: the skeletons share no names"
        )
    source_world = source.world(clip.poses.rigid)
    carrier, hips = _carrier(target), _carrier(source)
    if joints is None:
        numbers.setdefault(carrier, hips)
    match = Match(source, target, dict(sorted(numbers.items())), source_world)
    if joints is None and not match.one_rig:
        match = spread_spine(match)
    poses = _turned(match)
    if carrier in numbers:
        poses = _with_way(match, poses, carrier, _way(match, carrier, hips))
        if not match.comparable:
            poses = _grounded(target, poses, carrier)
    return Clip(clip.name, clip.time_s, poses, clip.looped, clip.key_count)


def _turned(match: Match) -> Motor:
    """Local poses ``(F, J)`` with every joint turned, and where it rests in the one above it."""
    target, made = match.target, constants(match)
    world: list[Rotor] = []
    poses = np.empty((len(match.source_world), len(target), 8))
    for joint in range(len(target)):
        parent = int(target.parents[joint])
        before = world[parent] if parent >= 0 else Rotor.identity()
        if joint in match.joints:
            world.append(match.source_world[:, match.joints[joint]].rotor @ made[joint])
        else:
            world.append(before @ target.rest[joint].rotor)
        shift = target.rest[joint].translation_m
        turn = before.inverse() @ world[joint]
        poses[:, joint] = Motor.from_rotor_translation(turn, shift).coefficients
    return Motor.normalize(poses)


def _carrier(skeleton: Skeleton) -> int:
    """The joint that carries legs and trunk: the hips, or what stands in for them."""
    body = body_of(skeleton)
    limbs = [body[f"{side}_thigh"] for side in SIDES if f"{side}_thigh" in body]
    limbs += [body[role] for role in ("spine_1", "neck", "head") if role in body][:1]
    if not limbs:
        return body.get("hips", skeleton.root)
    carrier = common_parent(skeleton, limbs)
    hips = body.get("hips", carrier)
    return hips if hips in ancestors(skeleton, carrier) else carrier


def _way(match: Match, carrier: int, hips: int) -> FloatArray:
    """Positions ``(F, 3)`` of the target's carrier: the source's way, scaled."""
    start = match.source.rest_world[hips].translation_m
    own = match.target.rest_world[carrier].translation_m
    lengths = [_leg_m(skeleton) for skeleton in (match.target, match.source)]
    scale = 1.0
    if min(lengths) > NO_BONE_M:
        scale = lengths[0] / lengths[1]
    elif min(own[2], start[2]) > NO_BONE_M:
        scale = own[2] / start[2]
    way: FloatArray = own + scale * (match.source_world[:, hips].translation_m - start)
    return way


def _leg_m(skeleton: Skeleton) -> float:
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


def _with_way(match: Match, poses: Motor, carrier: int, way: FloatArray) -> Motor:
    """Poses in which the carrier goes its way: over the ground by its root, the rest by itself."""
    target = match.target
    line = ancestors(target, carrier)
    if line:
        root = line[-1]
        resting = target.rest_world[carrier].translation_m
        shift = target.rest[root].translation_m + (way - resting) * [1.0, 1.0, 0.0]
        poses = with_joint(poses, root, Motor.from_rotor_translation(poses[:, root].rotor, shift))
        above = target.world(poses)[:, line[0]]
        way = above.inverse().apply(way)
    source_world = Motor.from_rotor_translation(poses[:, carrier].rotor, way)
    return with_joint(poses, carrier, source_world)


def _grounded(target: Skeleton, poses: Motor, carrier: int) -> Motor:
    """Poses raised or lowered as a whole, so that the lower foot is as low as it is at rest."""
    body = body_of(target)
    soles = [
        body[f"{side}_{part}"]
        for side in SIDES
        for part in ("foot", "toes")
        if f"{side}_{part}" in body
    ]
    if not soles:
        return poses
    height = target.world(poses).translation_m[:, soles, 2]
    over = np.min(height - target.rest_world.translation_m[soles, 2], axis=1)
    down = -float(np.quantile(over, LOWEST_SHARE)) * UP
    world = target.world(poses)
    parent = int(target.parents[carrier])
    above = world[:, parent].rotor if parent >= 0 else Rotor.identity(poses.shape[:1])
    lift = Motor.from_translation(above.inverse().apply(down))
    return with_joint(poses, carrier, lift @ poses[:, carrier])
