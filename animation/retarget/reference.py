"""What the joints of a skeleton are, and the constant turn between a joint and its like in another.

Each of the target's joints follows ``turned_source @ constant``. Three ways lead to the constant:

- one rig (the same names, bones that lie alike in their joints' frames): rotations are copied;
- resting poses that can be compared, T or A: the constant is between the two, after the target's
  resting limbs are laid along the source's, each joint going along with the one above it, hands
  and fingers by their knuckles and the axes about which they bend;
- any other rest, such as the first frame of a walk: the motion itself tells.

By motion, limbs are matched by their bones and by the hinges about which knees and elbows bend;
hands and fingers by knuckles, bones and the palm; feet by how they stand; the trunk by its frames,
where these are near the world's axes, or else by its mean over the clip, its forward lean kept; the
head by its mean.

A hand is told by where its middle finger begins and across its knuckles; a finger by its bone and
by the hinge about which it bends, which in a straight finger is taken to lie across the knuckles,
and in a straight thumb to stand on the palm. Without that second direction fingers would point well
and yet be twisted about themselves.

Tree, bones and bends tell them, names are hints (`animation.anatomy`). What nothing tells stays
without a role.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product

import numpy as np

from motorcade.animation.anatomy.body import Body, body_from
from motorcade.animation.anatomy.tree import SIDES, JointTree
from motorcade.animation.ik import Leg
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import UP, along_axes, axes_along, shortest_turn, turn_z, unit
from motorcade.ga import Motor, Rotor, mean
from motorcade.ga.arrays import FloatArray

AHEAD = np.array([1.0, 0.0, 0.0])
# What it counts that read figures face +x, beside other evidence.
FACING = 2.0
# Hips whose line lies lower than by this cosine face somewhere.
LEVEL = 0.3


def body_of(skeleton: Skeleton) -> dict[str, int]:
    """Joints by their role: "hips", "neck", "head", "left_thigh", "right_index_1", "spine_1", …

    Sides are the figure's own: names that tell them as a viewer sees them are turned about. The
    spine's joints are those between hips and neck (or head, or collarbones), counted from
    below, whatever they are called.
    """
    return dict(figure_of(skeleton).roles)


def facing_rad(skeleton: Skeleton, at: FloatArray) -> FloatArray | None:
    """Where a figure faces ``(F,)``, from +x towards +y, by its hips, or arms where it has none.

    Where hips stand upright, as of one that lies on its side, they face nowhere: the heading goes
    evenly from the moment before to that after. None for a skeleton without a left and a right.

    Args:
        skeleton: of J joints.
        at: ``(F, J, 3)`` where they are.
    """
    body = body_of(skeleton)
    for part in ("thigh", "upper_arm", "clavicle"):
        if {f"left_{part}", f"right_{part}"} <= set(body):
            across = at[..., body[f"left_{part}"], :] - at[..., body[f"right_{part}"], :]
            level = np.linalg.norm(across[:, :2], axis=1) > LEVEL * np.linalg.norm(across, axis=1)
            rows = np.flatnonzero(level) if np.any(level) else np.arange(len(at))
            facing = np.unwrap(np.arctan2(-across[rows, 0], across[rows, 1]))
            return np.asarray(np.interp(np.arange(len(at)), rows, facing))
    return None


def legs_of(skeleton: Skeleton) -> list[Leg]:
    """The legs, left first, and an animal's forelegs after its hind legs.

    Joints between hip and knee, or knee and ankle, go along with the bone above them.

    >>> import numpy as np
    >>> from motorcade.animation import Skeleton, legs_of
    >>> from motorcade.ga import Motor
    >>> names = ("mixamorig:LeftUpLeg", "mixamorig:LeftLeg", "mixamorig:LeftFoot")
    >>> legs_of(Skeleton(names, np.array([-1, 0, 1]), Motor.identity((3,))))[0].knee
    'mixamorig:LeftLeg'
    """
    figure = figure_of(skeleton)
    limbs = [("thigh", "calf", "foot")]
    if figure.four_legged:
        limbs.append(("upper_arm", "forearm", "hand"))
    legs = []
    for limb, side in product(limbs, SIDES):
        joints = [figure.roles.get(f"{side}_{part}", -1) for part in limb]
        line = ancestors(skeleton, joints[2]) if min(joints) >= 0 else []
        if not set(joints[:2]) <= set(line) or joints[0] not in ancestors(skeleton, joints[1]):
            continue
        toes = figure.roles.get(f"{side}_toes") if limb[0] == "thigh" else None
        joined = toes is not None and skeleton.parents[toes] == joints[2]
        hip, knee, ankle = (skeleton.names[joint] for joint in joints)
        ball = skeleton.names[toes] if joined and toes is not None else ""
        legs.append(Leg(hip, knee, ankle, ball))
    return legs


def joints_alike(target: Skeleton, source: Skeleton) -> dict[str, str]:
    """The source's joint for each of the target's, by their roles and then by names alike.

    In names, case, separators and a prefix up to a colon (``mixamorig:LeftArm``) do not count.
    Spines of different numbers of joints are laid end on end: their first and last joints match.
    """
    own, other = body_of(target), body_of(source)
    pairs = {
        target.names[own[role]]: source.names[other[role]]
        for role in own
        if role in other and not role.startswith("spine")
    }
    pairs |= _spines(target, source, own, other)
    known: dict[str, str] = {}
    for name in source.names:
        known.setdefault(_plain(name), name)
    taken = set(pairs.values())
    for number, name in enumerate(target.names):
        alike = known.get(_plain(name))
        if number not in own.values() and name not in pairs and alike and alike not in taken:
            pairs[name] = alike
    return {name: pairs[name] for name in target.names if name in pairs}


def _spines(
    target: Skeleton, source: Skeleton, own: Mapping[str, int], other: Mapping[str, int]
) -> dict[str, str]:
    ours, theirs = (
        [body[role] for role in sorted(body) if role.startswith("spine")] for body in (own, other)
    )
    if not theirs:
        return {}
    last, steps = len(theirs) - 1, max(len(ours) - 1, 1)
    chosen = [round(k * last / steps) if len(ours) > 1 else last for k in range(len(ours))]
    return {
        target.names[joint]: source.names[theirs[k]] for joint, k in zip(ours, chosen, strict=True)
    }


def _plain(name: str) -> str:
    return "".join(sign for sign in name.rsplit(":", 1)[-1].lower() if sign.isalnum())


@lru_cache(maxsize=64)
def figure_of(skeleton: Skeleton) -> Body:
    """The body in its rest pose, spine and all, taken to stand with z up and to face +x."""
    tree = JointTree(skeleton.names, skeleton.parents, skeleton.rest_world.translation_m)
    body = body_from(tree, UP, AHEAD, habit=FACING)
    roles = dict(body.roles)
    for level, number in enumerate(_spine(skeleton, roles), start=1):
        roles[f"spine_{level}"] = number
    return replace(body, roles=roles)


def _spine(skeleton: Skeleton, body: Mapping[str, int]) -> list[int]:
    """Joints between the hips and what the trunk carries, from below."""
    carriers = ("neck", "head", "left_clavicle", "left_upper_arm")
    tops = [body[role] for role in carriers if role in body]
    taken, spine = set(body.values()), []
    if not tops or "hips" not in body:
        return []
    joint = int(skeleton.parents[tops[0]])
    # Where arms hang lower than the neck, what lies between belongs to the neck.
    line = ancestors(skeleton, tops[0])
    shoulders = (body.get(f"left_{part}") for part in ("clavicle", "upper_arm"))
    carrier = next((int(skeleton.parents[one]) for one in shoulders if one is not None), -1)
    joint = carrier if carrier in line and carrier not in taken else joint
    above_hips = set(ancestors(skeleton, body["hips"]))
    while joint >= 0 and joint not in taken and joint not in above_hips:
        spine.append(joint)
        joint = int(skeleton.parents[joint])
    return spine[::-1]


def ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """A joint's parents, the nearest first."""
    above = []
    while skeleton.parents[joint] >= 0:
        joint = int(skeleton.parents[joint])
        above.append(joint)
    return above


def common_parent(skeleton: Skeleton, joints: list[int]) -> int:
    """The nearest joint from which all of the given ones hang, or one of these itself."""
    lines = [[joint, *ancestors(skeleton, joint)] for joint in joints]
    shared = set(lines[0]).intersection(*lines[1:])
    return next((joint for joint in lines[0] if joint in shared), lines[0][-1])


# Bones shorter than this have no direction to lay along.
NO_BONE_M = 1e-4
# One rig: bones within this angle in their joints' frames, for this share of the joints.
SAME_BONE_RAD, SAME_SHARE = np.radians(4.0), 0.85
# A rest to compare by: limbs of both sides mirrored, thighs hanging, within these angles.
MIRRORED_RAD, HANGING_RAD = np.radians(12.0), np.radians(35.0)
LIMBS = (("thigh", "calf", "foot"), ("upper_arm", "forearm", "hand"))


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
    source_world: Motor

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

    @cached_property
    def source_roles(self) -> dict[str, int]:
        """The source's joints by the same roles."""
        return {role: self.joints[joint] for role, joint in self.roles.items()}

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
            alike.append(same and (near or angle_rad(*bones) < SAME_BONE_RAD))
        named = [self.target.names[a] == self.source.names[b] for a, b in self.joints.items()]
        enough = len(alike) > 0 and np.mean(alike) >= SAME_SHARE
        return bool(enough and np.mean(named) >= SAME_SHARE)

    @cached_property
    def comparable(self) -> bool:
        """Whether the source's rest is one to stand in: its sides mirrored, its legs hanging."""
        body, at = body_of(self.source), self.source.rest_world.translation_m
        for upper, middle, end in LIMBS:
            for a, b in ((upper, middle), (middle, end)):
                bones = [
                    at[body[f"{side}_{b}"]] - at[body[f"{side}_{a}"]]
                    for side in SIDES
                    if f"{side}_{a}" in body and f"{side}_{b}" in body
                ]
                if a == "thigh" and any(angle_rad(bone, -UP) > HANGING_RAD for bone in bones):
                    return False
                if len(bones) == 2 and angle_rad(bones[0] * [1, -1, 1], bones[1]) > MIRRORED_RAD:
                    return False
        return True


def angle_rad(a: FloatArray, b: FloatArray) -> float:
    """Between two vectors ``(3,)``."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


# How much the way in which a finger should bend counts beside how it is bent.
ASSUMED_FINGER_BEND = 0.05
FINGERS = ("thumb", "index", "middle", "ring", "little")
# How much the way in which a limb should bend counts beside how it does.
ASSUMED_BEND = 0.15
# The share of a clip, its lowest moments, in which a foot is taken to stand flat.
FLAT_SHARE = 0.12
# How far a trunk may lean and twist on average, that is built along the world's axes.
BUILT_RAD = np.radians(44.0)


@dataclass(frozen=True, eq=False)
class Seen:
    """Joints of a skeleton in some poses, by role.

    Fields:
        at_m: ``(F, J, 3)``.
        rotors: ``(F, J)``.
        joints: numbers by role.
    """

    at_m: FloatArray
    rotors: Rotor
    joints: Mapping[str, int]

    def bone(self, start: str, end: str) -> FloatArray:
        """From one joint to another, ``(F, 3)``."""
        return self.at_m[:, self.joints[end]] - self.at_m[:, self.joints[start]]

    def inside(self, role: str, vectors: FloatArray) -> FloatArray:
        """Mean ``(3,)`` of vectors ``(F, 3)`` as a joint sees them."""
        seen = self.rotors[:, self.joints[role]].inverse().apply(vectors)
        mean: FloatArray = np.mean(seen, axis=0)
        return mean


def is_of_hand(role: str) -> bool:
    """Whether a joint is a hand, or of a finger."""
    part = role.partition("_")[2]
    return part == "hand" or part.startswith(FINGERS)


def hand_turn(role: str, target: Seen, source: Seen) -> Rotor | None:
    """The constant turn, in the source's joint frame, of a hand or a finger's joint.

    None where joints that tell it are missing.

    Args:
        role: such as "left_hand" or "right_index_2".
        target: at rest; both know the same roles.
        source: at rest or moving.
    """
    frames = [_hand_frame(role, seen) for seen in (target, source)]
    if frames[0] is None or frames[1] is None:
        return None
    return frames[1] @ frames[0].inverse()


def _hand_frame(role: str, seen: Seen) -> Rotor | None:
    side, _, part = role.partition("_")
    knuckles = {name: f"{side}_{name}_1" for name in FINGERS if f"{side}_{name}_1" in seen.joints}
    last = knuckles.get("ring", knuckles.get("little"))
    hand = f"{side}_hand"
    if last is None or not {"index", "middle"} <= set(knuckles) or hand not in seen.joints:
        return None
    ahead, across = seen.bone(hand, knuckles["middle"]), seen.bone(last, knuckles["index"])
    if part == "hand":
        return axes_along(seen.inside(role, ahead), seen.inside(role, across))
    finger, _, phalanx = part.partition("_")
    line = [f"{side}_{finger}_{number}" for number in (1, 2, 3)]
    line = [name for name in line if name in seen.joints]
    # A tip has no joint that follows: its bone lies in it as the one before does in its own joint.
    first = min(int(phalanx) - 1, len(line) - 2)
    if first < 0:
        return None
    second = _hinge(side, line, seen, ahead, across)
    return axes_along(
        seen.inside(line[first], seen.bone(*line[first : first + 2])), seen.inside(role, second)
    )


def _hinge(
    side: str, line: list[str], seen: Seen, ahead: FloatArray, across: FloatArray
) -> FloatArray:
    """About what a finger bends, ``(F, 3)``: across its bones, told by the hand where straight."""
    thumb = "_thumb_" in line[0]
    by_hand = unit(np.cross(ahead, across) if thumb else across)
    if len(line) < 3:
        return by_hand
    hinge = np.cross(unit(seen.bone(*line[:2])), unit(seen.bone(*line[1:])))
    hinge = hinge if side == "right" and not thumb else -hinge
    # One that is bent the other way, or sideways, does not tell how it would be closed.
    plausible = np.sum(hinge * by_hand, axis=-1, keepdims=True) > 0.0
    return ASSUMED_FINGER_BEND * by_hand + np.where(plausible, hinge, 0.0)


class _Motion:
    """The source's motion seen from its own heading, and what it tells of each joint."""

    def __init__(self, match: Match) -> None:
        self.match, self.roles = match, match.roles
        at = match.source_world.translation_m
        facing = facing_rad(match.source, at)
        self.heading = turn_z(np.zeros(len(at)) if facing is None else -facing)
        self.at = self.heading.reshape(-1, 1).apply(at)
        self.rotors = self.heading.reshape(-1, 1) @ match.source_world.rotor
        self.upright = self._upright()
        self.lean = self._lean()
        rest = match.target.rest_world.reshape(1, -1)
        self.seen = (
            Seen(rest.translation_m, rest.rotor, match.roles),
            Seen(self.at, self.rotors, match.source_roles),
        )
        self.made: dict[int, Rotor] = {}

    def constants(self) -> dict[int, Rotor]:
        """Joint after joint, those above first."""
        role_of = {joint: role for role, joint in self.roles.items()}
        for joint, other in self.match.joints.items():
            side, _, part = role_of.get(joint, "").partition("_")
            constant = None
            if side in ("hips", "spine", "neck"):
                constant = self._as_it_is_built(joint, other)
            elif side == "head":
                constant = self._as_on_average(joint, other, Rotor.identity())
            elif part in ("foot", "toes"):
                constant = self._as_it_stands(joint, other, side)
            elif is_of_hand(role_of.get(joint, "")):
                constant = hand_turn(role_of[joint], *self.seen)
            elif part in ("thigh", "calf", "upper_arm", "forearm"):
                constant = self._as_it_bends(side, part, joint, other)
            self.made[joint] = self._along(joint, other) if constant is None else constant
        return self.made

    def _as_it_is_built(self, joint: int, other: int) -> Rotor:
        """As where its frame lies along the world's axes, which trunks are built in, or on average.

        Biped's, Mixamo's and captured skeletons' trunks stand upright so, whatever the motion.
        """
        if not self.upright:
            return self._as_on_average(joint, other, self.lean)
        return along_axes(mean(self.rotors[:, other])).inverse() @ self._rest(joint)

    def _upright(self) -> bool:
        """Whether frames of the whole trunk are on average near the world's axes."""
        for role, joint in self.roles.items():
            if role.startswith(("hips", "spine", "neck")):
                average = mean(self.rotors[:, self.match.joints[joint]])
                if float((along_axes(average).inverse() @ average).angle()) > BUILT_RAD:
                    return False
        return True

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
            upper, lower = unit(upper), unit(lower)
            hinge = np.cross(upper, lower) + ASSUMED_BEND * np.cross(upper, bend)
            inside = rotor.inverse()
            bone = np.mean(inside.apply((upper, lower)[first]), axis=0)
            frames.append(axes_along(bone, np.mean(inside.apply(hinge), axis=0)))
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


def constants(match: Match) -> dict[int, Rotor]:
    """The constant turn of each matched joint of the target, in the source's joint frame."""
    if match.one_rig:
        return dict.fromkeys(match.joints, Rotor.identity())
    return _from_rests(match) if match.comparable else _Motion(match).constants()


def _from_rests(match: Match) -> dict[int, Rotor]:
    role_of = {joint: role for role, joint in match.roles.items()}
    turns: dict[int, Rotor] = {}
    rotors: dict[int, Rotor] = {}
    seen = _at_rest(match.target, match.roles), _at_rest(match.source, match.source_roles)
    for joint, other in match.joints.items():
        role, above = role_of.get(joint, ""), match.above(joint)
        back, rest = match.source.rest_world[other].rotor, match.target.rest_world[joint].rotor
        laid = hand_turn(role, *seen) if is_of_hand(role) else None
        if laid is not None:
            rotors[joint], turns[joint] = laid, back @ laid @ rest.inverse()
            continue
        turn = turns.get(above, Rotor.identity()) if _goes_along(role) else Rotor.identity()
        bones = _bones_at_rest(match, joint) if _is_laid(role) else None
        if bones is not None:
            turn = shortest_turn(turn.apply(bones[0]), bones[1]) @ turn
        turns[joint] = turn
        rotors[joint] = back.inverse() @ turn @ rest
    return rotors


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
