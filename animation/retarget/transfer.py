"""Retargeting: a clip of one skeleton played by another.

Every joint turns in the world as its like does, but for a constant between the two (`reference`).
So joints that one skeleton has beside the other lose no motion: what a source's extra root or
extra spine joint does arrives in the joints that hang on it. Bones keep the target's lengths.
Spines of different numbers of joints, or of joints spaced otherwise, share turns by length.

Feet on the ground after retargeting: as high as the source's, and on soles of their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, product

import numpy as np

from motorcade.animation.anatomy.tree import SIDES
from motorcade.animation.clip import Clip
from motorcade.animation.ik import Leg
from motorcade.animation.ik.feet import GroundHeights, bent_toes, smooth_over, sole_clearance_m
from motorcade.animation.retarget.reference import (
    LIMBS,
    NO_BONE_M,
    Match,
    ancestors,
    body_of,
    common_parent,
    constants,
    figure_of,
    joints_alike,
    legs_of,
)
from motorcade.animation.skeleton import Skeleton, turned_joint, with_joint
from motorcade.animation.vectors import UP, along_axes, shortest_turn
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
    shares: FloatArray = 0.5 * (ends[:-1] + ends[1:]) / ends[-1]
    return shares


def _joined(parts: list[Motor]) -> Motor:
    return Motor(np.concatenate([one.coefficients for one in parts], axis=-2))


def retarget(
    clip: Clip,
    source: Skeleton,
    target: Skeleton,
    joints: Mapping[str, str] | None = None,
    legs: Sequence[Leg] | None = None,
) -> Clip:
    """The clip for another skeleton; joints without a counterpart stay as they rest.

    The hips' way is scaled by the lengths of the legs; then the figure is raised or lowered so that
    its lower foot is at each moment as high over the ground as the source's. A root below the
    hips, where the target has one, takes the way over the ground. Feet of figures of other
    proportions slide a little: see `plant_feet`. Weights of morph targets are left out: another
    character's targets are others.

    Args:
        clip: of the source. Where its joints grow, growth is left out.
        source: which faces +x in character space, at rest or in the clip.
        target: that is to move; it rests standing, as a bound mesh does.
        joints: the source's joint for each of the target's; by default `joints_alike`. The hips
            go their way only if they, or what carries legs and trunk, are among them.
        legs: of the target, whose soles are put on the ground; `fitted_legs` measures them on a
            mesh. By default those of `legs_of`, of which ankles and balls alone count: how long
            soles are no skeleton tells. Where the source's rest tells no soles, toes that would
            roll into the ground bend, which is told by the legs given.

    Raises:
        ValueError: joints that one of the skeletons does not have, or no pair at all; an animal on
            four legs and a figure on two.

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
    legged = [figure_of(skeleton).four_legged for skeleton in (source, target)]
    if joints is None and legged[0] != legged[1]:
        who = ("source", "target")[legged.index(True)]
        raise ValueError(
            f"retarget: expected two figures on as many legs, got four of the {who} alone; joints="
            "{target's: source's} pairs them all the same"
        )
    pairs = dict(joints_alike(target, source) if joints is None else joints)
    numbers = {target.index(name): source.index(other) for name, other in pairs.items()}
    if not numbers:
        raise ValueError(
            "retarget(joints): expected one pair or more, got none: the skeletons share neither "
            "limbs nor names; joints={target's: source's} pairs what is alike"
        )
    source_world = source.world(clip.poses.rigid)
    carrier, hips = _carrier(target), _carrier(source)
    if joints is None:
        numbers.setdefault(carrier, hips)
    match = Match(source, target, dict(sorted(numbers.items())), source_world)
    if not match.one_rig:
        laid = laid_limbs(source, source_world)
        match = Match(source, target, match.joints, laid)
        match = spread_spine(match) if joints is None else match
    poses = _rotate_joints(match)
    if carrier in numbers:
        poses = _with_way(match, poses, carrier, _way(match, carrier, hips))
        if source is not target:
            poses = grounded(match, clip, poses, carrier, legs)
    return Clip(clip.name, clip.time_s, poses, clip.looped, clip.key_count)


def _rotate_joints(match: Match) -> Motor:
    """Local poses ``(F, J)`` with every joint turned, and where it rests in the one above it."""
    target, offsets = match.target, constants(match)
    world: list[Rotor] = []
    poses = np.empty((len(match.source_world), len(target), 8))
    for joint in range(len(target)):
        parent = int(target.parents[joint])
        before = world[parent] if parent >= 0 else Rotor.identity()
        if joint in match.joints:
            world.append(match.source_world[:, match.joints[joint]].rotor @ offsets[joint])
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
    lengths = [leg_m(skeleton) for skeleton in (match.target, match.source)]
    scale = leg_scale(match)
    if not min(lengths) > NO_BONE_M and min(own[2], start[2]) > NO_BONE_M:
        scale = own[2] / start[2]
    return own + scale * (match.source_world[:, hips].translation_m - start)


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


def laid_limbs(source: Skeleton, world: Motor) -> Motor:
    """Poses ``(F, J)`` in which the bones of limbs turn as a whole where joints lie inside them.

    A knee of two joints bends in both: what follows the first alone would bend by half.
    """
    body, coefficients = body_of(source), world.coefficients.copy()
    rest = source.rest_world
    for side, limb in product(SIDES, LIMBS):
        for start, end in pairwise([body.get(f"{side}_{part}", -1) for part in limb]):
            inner = int(source.parents[end]) if min(start, end) >= 0 else start
            if inner == start or start not in ancestors(source, end):
                continue
            bone = rest.translation_m[end] - rest.translation_m[start]
            turn = world[:, inner].rotor @ rest[inner].rotor.inverse()
            now = world[:, end].translation_m - world[:, start].translation_m
            turn = shortest_turn(turn.apply(bone), now) @ turn
            whole = turn @ rest[start].rotor
            place = world[:, start].translation_m
            coefficients[:, start] = Motor.from_rotor_translation(whole, place).coefficients
    return Motor.normalize(coefficients)


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
    smoothed = smooth_over(np.tile(rise_m[:-1], 3), rounds.ravel())[steps : 2 * steps]
    return np.append(smoothed, smoothed[0])


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
    clearance_m: FloatArray = np.min(feet, axis=0)
    return clearance_m


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
