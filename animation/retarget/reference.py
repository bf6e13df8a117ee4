"""What stays the same between a joint of one skeleton and its like in another: a constant turn.

Each of the target's joints follows ``turned_source @ constant``. Three ways lead to the constant:

- one rig (the same names, bones that lie alike in their joints' frames): rotations are copied;
- resting poses that can be compared, T or A: the constant is between the two, after the target's
  resting limbs are laid along the source's, each joint going along with the one above it;
- any other rest, such as the first frame of a walk: the motion itself tells. Limbs are matched by
  their bones and by the hinges about which knees and elbows bend; feet by how they stand; the
  trunk by its mean over the clip, its forward lean kept.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motorcade.animation.ik.chain import shortest_turn
from motorcade.animation.retarget.roles import SIDES, ancestors, body_of
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import FloatArray, Motor, Rotor, mean

__all__ = ["Match", "constants"]

# Bones shorter than this have no direction to lay along.
NO_BONE_M = 1e-4
# One rig: bones within this angle in their joints' frames, for this share of the joints.
SAME_BONE_RAD, SAME_SHARE = np.radians(4.0), 0.85
# A rest to compare by: limbs of both sides mirrored, thighs hanging, within these angles.
MIRRORED_RAD, HANGING_RAD = np.radians(12.0), np.radians(35.0)
# How much the way in which a limb should bend counts beside how it does.
ASSUMED_BEND = 0.15
# The share of a clip, its lowest moments, in which a foot is taken to stand flat.
FLAT_SHARE = 0.12
LIMBS = (("thigh", "calf", "foot"), ("upper_arm", "forearm", "hand"))
FINGERS = ("thumb", "index", "middle", "ring", "little")
UP = np.array([0.0, 0.0, 1.0])
AHEAD = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class Match:
    """Two skeletons, which joints belong together, and a motion of the source.

    Fields:
        joints: the source's joint for each of the target's, by number.
        moved: Motor ``(F, J)``, the source in character space.
    """

    source: Skeleton
    target: Skeleton
    joints: Mapping[int, int]
    moved: Motor

    @cached_property
    def roles(self) -> dict[str, int]:
        """The target's joints by role, those whose role the matched joint of the source shares."""
        own, other = body_of(self.target), body_of(self.source)
        return {
            role: joint
            for role, joint in own.items()
            if joint in self.joints
            and (role.startswith("spine") or other.get(role) == self.joints[joint])
        }

    def above(self, joint: int) -> int:
        """The nearest matched joint above one of the target's; −1 where there is none."""
        return next((k for k in ancestors(self.target, joint) if k in self.joints), -1)

    @cached_property
    def one_rig(self) -> bool:
        """Whether both are one rig but for joints that one of them leaves out."""
        alike = []
        for joint, other in self.joints.items():
            parent = int(self.target.parents[joint])
            if parent not in self.joints:
                continue
            bones = self.target.rest[joint].translation_m, self.source.rest[other].translation_m
            same = self.joints[parent] == int(self.source.parents[other])
            near = min(float(np.linalg.norm(bone)) for bone in bones) < NO_BONE_M
            alike.append(same and (near or _angle(*bones) < SAME_BONE_RAD))
        named = [self.target.names[a] == self.source.names[b] for a, b in self.joints.items()]
        enough = len(alike) > 0 and np.mean(alike) >= SAME_SHARE
        return bool(enough and np.mean(named) >= SAME_SHARE)

    @cached_property
    def comparable(self) -> bool:
        """Whether the source's rest is one to stand in: its sides mirrored, its legs hanging."""
        body, at = body_of(self.source), self.source.rest_world.translation_m
        for upper, middle, end in LIMBS:
            for a, b in ((upper, middle), (middle, end)):
                bones = [at[body[f"{side}_{b}"]] - at[body[f"{side}_{a}"]] for side in SIDES
                         if f"{side}_{a}" in body and f"{side}_{b}" in body]  # fmt: skip
                if a == "thigh" and any(_angle(bone, -UP) > HANGING_RAD for bone in bones):
                    return False
                if len(bones) == 2 and _angle(bones[0] * [1, -1, 1], bones[1]) > MIRRORED_RAD:
                    return False
        return True


def constants(match: Match) -> dict[int, Rotor]:
    """The constant turn of each matched joint of the target, in the source's joint frame."""
    if match.one_rig:
        return dict.fromkeys(match.joints, Rotor.identity())
    return _from_rests(match) if match.comparable else _from_motion(match)


def _from_rests(match: Match) -> dict[int, Rotor]:
    role_of = {joint: role for role, joint in match.roles.items()}
    turns: dict[int, Rotor] = {}
    made: dict[int, Rotor] = {}
    for joint, other in match.joints.items():
        role, above = role_of.get(joint, ""), match.above(joint)
        carried = turns.get(above, Rotor.identity()) if _goes_along(role) else Rotor.identity()
        bones = _bones_at_rest(match, joint) if _is_laid(role) else None
        if bones is not None:
            carried = shortest_turn(carried.apply(bones[0]), bones[1]) @ carried
        turns[joint] = carried
        back = match.source.rest_world[other].rotor.inverse()
        made[joint] = back @ carried @ match.target.rest_world[joint].rotor
    return made


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


def _from_motion(match: Match) -> dict[int, Rotor]:
    return _Motion(match).constants()


class _Motion:
    """The source's motion seen from its own heading, and what it tells of each joint."""

    def __init__(self, match: Match) -> None:
        self.match, self.roles = match, match.roles
        at = match.moved.translation_m
        self.heading = _headings(match, at)
        self.at = self.heading.reshape(-1, 1).apply(at)
        self.rotors = self.heading.reshape(-1, 1) @ match.moved.rotor
        self.lean = self._lean()
        self.made: dict[int, Rotor] = {}

    def constants(self) -> dict[int, Rotor]:
        """Joint after joint, those above first."""
        role_of = {joint: role for role, joint in self.roles.items()}
        for joint, other in self.match.joints.items():
            side, _, part = role_of.get(joint, "").partition("_")
            made = None
            if side in ("hips", "spine", "neck") or part == "clavicle":
                made = self._as_on_average(joint, other, self.lean)
            elif side == "head":
                made = self._as_on_average(joint, other, Rotor.identity())
            elif part in ("foot", "toes"):
                made = self._as_it_stands(joint, other, side)
            elif part == "hand":
                made = self._as_fingers_lie(side, joint, other)
            elif part in ("thigh", "calf", "upper_arm", "forearm"):
                made = self._as_it_bends(side, part, joint, other)
            elif part.startswith(FINGERS):
                made = self._as_a_finger_lies(side, part, joint, other)
            self.made[joint] = self._along(joint, other) if made is None else made
        return self.made

    def _as_on_average(self, joint: int, other: int, lean: Rotor) -> Rotor:
        return mean(self.rotors[:, other]).inverse() @ lean @ self._rest(joint)

    def _as_it_stands(self, joint: int, other: int, side: str) -> Rotor:
        """Flat on the ground at the foot's lowest moments."""
        low = sum(
            self.at[:, self.match.joints[self.roles[f"{side}_{part}"]], 2]
            for part in ("foot", "toes")
            if f"{side}_{part}" in self.roles
        )
        count = max(1, int(FLAT_SHARE * len(self.at)))
        standing = np.argsort(low)[:count]
        return mean(self.rotors[standing, other]).inverse() @ self._rest(joint)

    def _as_it_bends(self, side: str, part: str, joint: int, other: int) -> Rotor | None:
        """By the limb's bone, and by the hinge of its middle joint."""
        limb = next(limb for limb in LIMBS if part in limb)
        joints = [self.roles.get(f"{side}_{one}", -1) for one in limb]
        if min(joints) < 0:
            return None
        bend = -AHEAD if limb[0] == "thigh" else AHEAD
        first = limb.index(part)
        frames = []
        rest = self.match.target.rest_world
        for at, rotor, numbers in (
            (rest.translation_m[None], rest.rotor[joint : joint + 1], joints),
            (self.at, self.rotors[:, other], [self.match.joints[k] for k in joints]),
        ):
            upper, lower = (at[:, numbers[k + 1]] - at[:, numbers[k]] for k in (0, 1))
            upper, lower = _unit(upper), _unit(lower)
            hinge = np.cross(upper, lower) + ASSUMED_BEND * np.cross(upper, bend)
            inside = rotor.inverse()
            bone = np.mean(inside.apply((upper, lower)[first]), axis=0)
            frames.append(_frame(bone, np.mean(inside.apply(hinge), axis=0)))
        return frames[1] @ frames[0].inverse()

    def _as_fingers_lie(self, side: str, joint: int, other: int) -> Rotor | None:
        """By the hand's fingers: where the middle one begins, and across to the others."""
        bases = [self.roles.get(f"{side}_{finger}_1", -1) for finger in ("middle", "index", "ring")]
        if min(bases) < 0:
            return None
        frames = []
        rest = self.match.target.rest_world
        for at, rotor, numbers, hand in (
            (rest.translation_m[None], rest.rotor[joint : joint + 1], bases, joint),
            (self.at, self.rotors[:, other], [self.match.joints[k] for k in bases], other),
        ):
            inside = rotor.inverse()
            ahead = inside.apply(at[:, numbers[0]] - at[:, hand])
            across = inside.apply(at[:, numbers[1]] - at[:, numbers[2]])
            frames.append(_frame(np.mean(ahead, axis=0), np.mean(across, axis=0)))
        return frames[1] @ frames[0].inverse()

    def _as_a_finger_lies(self, side: str, part: str, joint: int, other: int) -> Rotor | None:
        """By its bone, and across the hand; of a tip, by the bone before, along the same axis."""
        finger = part.partition("_")[0]
        line = [self.roles.get(f"{side}_{finger}_{k}", -1) for k in (1, 2, 3)]
        bases = [self.roles.get(f"{side}_{one}_1", -1) for one in ("index", "ring")]
        start = line.index(joint)
        if start == 2 or line[start + 1] < 0:
            start -= 1
        if start < 0 or min(line[start : start + 2]) < 0 or min(bases) < 0:
            return None
        frames = []
        rest = self.match.target.rest_world
        for at, rotors, named in (
            (rest.translation_m[None], rest.rotor.reshape(1, -1), lambda k: k),
            (self.at, self.rotors, self.match.joints.__getitem__),
        ):
            begin, end, index, ring = (named(k) for k in (*line[start : start + 2], *bases))
            bone = rotors[:, begin].inverse().apply(at[:, end] - at[:, begin])
            across = rotors[:, named(joint)].inverse().apply(at[:, index] - at[:, ring])
            frames.append(_frame(np.mean(bone, axis=0), np.mean(across, axis=0)))
        return frames[1] @ frames[0].inverse()

    def _along(self, joint: int, other: int) -> Rotor:
        """As the target's joint rests in the one above it, so the source's does on average."""
        above = self.match.above(joint)
        if above < 0:
            return self._as_on_average(joint, other, self.lean)
        parent = self.rotors[:, self.match.joints[above]]
        inside = mean(parent.inverse() @ self.rotors[:, other])
        resting = self._rest(above).inverse() @ self._rest(joint)
        return inside.inverse() @ self.made[above] @ resting

    def _lean(self) -> Rotor:
        """How the trunk leans forward on average, from hips to neck or head."""
        body = body_of(self.match.source)
        top = body.get("neck", body.get("head"))
        if top is None or "hips" not in body:
            return Rotor.identity()
        line = np.mean(self.at[:, top] - self.at[:, body["hips"]], axis=0)
        return shortest_turn(UP, line * [1.0, 0.0, 1.0])

    def _rest(self, joint: int) -> Rotor:
        return self.match.target.rest_world[joint].rotor


def _headings(match: Match, at: FloatArray) -> Rotor:
    """Turns ``(F,)`` about z that bring where the hips face to +x."""
    body = body_of(match.source)
    pair = next(((f"left_{part}", f"right_{part}") for part in ("thigh", "upper_arm", "clavicle")
                 if {f"left_{part}", f"right_{part}"} <= set(body)), None)  # fmt: skip
    if pair is None:
        return Rotor.identity((len(at),))
    across = at[:, body[pair[0]]] - at[:, body[pair[1]]]
    turn = np.zeros_like(across)
    turn[:, 2] = np.arctan2(across[:, 0], across[:, 1])
    return Rotor.from_rotation_vector(turn)


def _frame(first: FloatArray, second: FloatArray) -> Rotor:
    """The rotor to axes along one vector, and across it towards another."""
    x = _unit(first)
    z = _unit(np.cross(x, second))
    return Rotor.from_matrix(np.stack([x, np.cross(z, x), z], axis=-1))


def _unit(vectors: FloatArray) -> FloatArray:
    made: FloatArray = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return made


def _angle(a: FloatArray, b: FloatArray) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
