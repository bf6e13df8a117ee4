"""What stays the same between a joint of one skeleton and its like in another: a constant turn.

Each of the target's joints follows ``turned_source @ constant``. Three ways lead to the constant:

- one rig (the same names, bones that lie alike in their joints' frames): rotations are copied;
- resting poses that can be compared, T or A: the constant is between the two, after the target's
  resting limbs are laid along the source's, each joint going along with the one above it, hands
  and fingers by their knuckles and the axes about which they bend (`hands`);
- any other rest, such as the first frame of a walk: the motion itself tells (`motion`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motorcade.animation.retarget.hands import FINGERS, Seen, hand_turn, is_of_hand
from motorcade.animation.retarget.motion import from_motion
from motorcade.animation.retarget.roles import NO_BONE_M, SIDES, Match
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import shortest_turn
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["constants"]


def constants(match: Match) -> dict[int, Rotor]:
    """The constant turn of each matched joint of the target, in the source's joint frame."""
    if match.one_rig:
        return dict.fromkeys(match.joints, Rotor.identity())
    return _from_rests(match) if match.comparable else from_motion(match)


def _from_rests(match: Match) -> dict[int, Rotor]:
    role_of = {joint: role for role, joint in match.roles.items()}
    turns: dict[int, Rotor] = {}
    made: dict[int, Rotor] = {}
    seen = _at_rest(match.target, match.roles), _at_rest(match.source, match.source_roles)
    for joint, other in match.joints.items():
        role, above = role_of.get(joint, ""), match.above(joint)
        back, rest = match.source.rest_world[other].rotor, match.target.rest_world[joint].rotor
        laid = hand_turn(role, *seen) if is_of_hand(role) else None
        if laid is not None:
            made[joint], turns[joint] = laid, back @ laid @ rest.inverse()
            continue
        turn = turns.get(above, Rotor.identity()) if _goes_along(role) else Rotor.identity()
        bones = _bones_at_rest(match, joint) if _is_laid(role) else None
        if bones is not None:
            turn = shortest_turn(turn.apply(bones[0]), bones[1]) @ turn
        turns[joint] = turn
        made[joint] = back.inverse() @ turn @ rest
    return made


def _at_rest(skeleton: Skeleton, roles: Mapping[str, int]) -> Seen:
    rest = skeleton.rest_world.reshape(1, -1)
    return Seen(rest.translation_m, rest.rotor, roles)


def _goes_along(role: str) -> bool:
    """Whether a joint rests in the one above it; trunk, shoulders and feet rest in the world."""
    part = role.split("_", 1)[-1]
    standing = ("thigh", "upper_arm", "clavicle", "foot", "toes")
    return not role or (role.startswith(SIDES) and part not in standing)


def _is_laid(role: str) -> bool:
    part = role.split("_", 1)[-1]
    limb = part in ("thigh", "calf", "upper_arm", "forearm")
    return not role or (role.startswith(SIDES) and (limb or part.startswith(FINGERS)))


def _bones_at_rest(match: Match, joint: int) -> tuple[FloatArray, FloatArray] | None:
    """Directions at rest, the target's and the source's, to the one matched joint that follows."""
    follow = [k for k in match.joints if match.above(k) == joint]
    if len(follow) != 1:
        return None  # hips and hands: where several bones begin, none of them tells the turn
    ends = follow[0], match.joints[follow[0]]
    bones = [
        skeleton.rest_world[end].translation_m - skeleton.rest_world[start].translation_m
        for skeleton, start, end in (
            (match.target, joint, ends[0]),
            (match.source, match.joints[joint], ends[1]),
        )
    ]
    if min(float(np.linalg.norm(bone)) for bone in bones) < NO_BONE_M:
        return None
    return bones[0], bones[1]
