"""Retargeting: a clip of one skeleton played by another, by joint names and rest poses.

The target's bones are made to point where the source's point: each joint turns by what the
source's has turned from its rest pose, after the shortest turn that lays the target's resting bone
along the source's. So an A pose and a T pose may be mixed, and frames of joints may differ. Bones
keep the target's lengths; the way of the hips is scaled by the height of the hips. Twist about a
bone is taken over as it is, measured from the rest pose: rest poses whose forearms or feet are
twisted differently end up twisted by that difference.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motorcade.animation.clip import Clip
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import FloatArray, Motor, Rotor

__all__ = ["joints_alike", "retarget"]

# Bones shorter than this have no direction to lay along.
_NO_BONE_M = 1e-4


def joints_alike(target: Skeleton, source: Skeleton) -> dict[str, str]:
    """The source's joint for each of the target's, by names that are alike.

    Case, separators and a prefix up to a colon (``mixamorig:LeftArm``) do not count.
    """
    known: dict[str, str] = {}
    for name in source.names:
        known.setdefault(_plain(name), name)
    pairs = {name: known.get(_plain(name)) for name in target.names}
    return {name: other for name, other in pairs.items() if other is not None}


def _plain(name: str) -> str:
    return "".join(sign for sign in name.rsplit(":", 1)[-1].lower() if sign.isalnum())


def retarget(
    clip: Clip,
    source: Skeleton,
    target: Skeleton,
    joints: Mapping[str, str] | None = None,
) -> Clip:
    """The clip for another skeleton; joints without a counterpart stay at rest.

    Args:
        clip: of the source. Where its joints grow, growth is left out.
        source: whose rest pose stands, like the target's, facing +x in character space.
        target: that is to move.
        joints: the source's joint for each of the target's; by default `joints_alike`.

    Raises:
        ValueError: joints that one of the skeletons does not have, or no pair at all.
    """
    pairs = dict(joints_alike(target, source) if joints is None else joints)
    numbers = {target.index(name): source.index(other) for name, other in pairs.items()}
    if not numbers:
        raise ValueError(
            "retarget(joints): expected one pair or more, got none: the skeletons share no names"
        )
    local = clip.poses if isinstance(clip.poses, Motor) else clip.poses.as_motor_scale()[0]
    moved = source.world(local)
    turned = (moved.rotor @ source.rest_world.rotor.inverse()).coefficients
    along = _laid_along(source, target, numbers)
    world: dict[int, Rotor] = {}
    poses = np.empty((len(clip.time_s), len(target), 8))
    for joint in range(len(target)):
        parent = int(target.parents[joint])
        before = world[parent] if parent >= 0 else Rotor.identity()
        if joint in numbers:
            rest = target.rest_world[joint].rotor
            world[joint] = Rotor(turned[:, numbers[joint]]) @ along[joint] @ rest
        else:
            world[joint] = before @ target.rest[joint].rotor
        shift = target.rest[joint].translation_m
        if parent < 0 and joint in numbers:
            shift = _way(moved, source, target, joint, numbers[joint])
        turn = before.inverse() @ world[joint]
        made = Motor.from_rotor_translation(turn, shift).coefficients
        poses[:, joint] = np.broadcast_to(made, poses[:, joint].shape)
    return Clip(clip.name, clip.time_s, Motor.normalize(poses), clip.looped, clip.key_count)


def _way(moved: Motor, source: Skeleton, target: Skeleton, joint: int, other: int) -> FloatArray:
    """Positions ``(F, 3)`` of a root: the source's way, scaled by the heights of the roots."""
    rest, own = source.rest_world[other].translation_m, target.rest_world[joint].translation_m
    scale = own[2] / rest[2] if rest[2] > _NO_BONE_M and own[2] > _NO_BONE_M else 1.0
    way: FloatArray = own + scale * (moved[:, other].translation_m - rest)
    return way


def _laid_along(source: Skeleton, target: Skeleton, numbers: Mapping[int, int]) -> list[Rotor]:
    """For each of the target's joints the shortest turn from its resting bone to the source's."""
    turns = [Rotor.identity()] * len(target)
    for joint, other in numbers.items():
        pair = _bone(target, joint, set(numbers)), _bone(source, other, set(numbers.values()))
        if pair[0] is None or pair[1] is None:
            # An end has no bone of its own and goes with its parent's.
            parent = int(target.parents[joint])
            turns[joint] = turns[parent] if parent >= 0 else turns[joint]
            continue
        turns[joint] = _shortest(pair[0], pair[1])
    return turns


def _bone(skeleton: Skeleton, joint: int, among: set[int]) -> FloatArray | None:
    """Unit direction at rest from a joint to the mean of its mapped children, if it has one."""
    children = [k for k in np.flatnonzero(skeleton.parents == joint) if int(k) in among]
    if len(children) != 1:
        return None  # hips and hands: where several bones begin, none of them tells the turn
    shift: FloatArray = (
        skeleton.rest_world[children[0]].translation_m - skeleton.rest_world[joint].translation_m
    )
    length = float(np.linalg.norm(shift))
    return shift / length if length > _NO_BONE_M else None


def _shortest(start: FloatArray, end: FloatArray) -> Rotor:
    """The shortest turn of one unit vector onto another; of opposite ones, none is."""
    axis = np.cross(start, end)
    sine, cosine = float(np.linalg.norm(axis)), float(start @ end)
    if sine < 1e-12:
        return Rotor.identity()
    return Rotor.from_rotation_vector(axis / sine * np.arctan2(sine, cosine))
