"""What the joints of a skeleton are (hips, thighs, fingers), and which of two skeletons match.

Tree, bones and bends tell them, names are hints (`animation.anatomy`). What nothing tells stays
without a role.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product

import numpy as np

from motorcade.animation.anatomy import Body, JointTree, body_from
from motorcade.animation.anatomy.words import SIDES
from motorcade.animation.ik import Leg
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import UP
from motorcade.ga import Motor
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
