"""A tree of joints with places, the pairs of limbs in it, and the words in its names.

Two siblings are a pair where what hangs on them has bones of the same lengths. Lengths do not
change with the pose, so that pairs are found in any rest pose and under any names.

Rigs name joints by the words of Mixamo, Biped, Unreal and MakeHuman, Blender, motion capture, or
their own; sides stand before or after, whole or as a letter. What all names begin with, and
numbers with which all of them end, says nothing.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray

SIDES = ("left", "right")
# Words for parts, where several name joints of one limb the one nearest to the trunk is taken.
CENTRAL = {
    "hips": "hips",
    "pelvis": "hips",
    "hip": "hips",
    "neck": "neck",
    "neck1": "neck",
    "head": "head",
}
SIDED = {
    "thigh": ("thigh", "upleg", "upperleg", "femur"),
    "calf": ("calf", "leg", "lowerleg", "lowleg", "shin", "knee", "knee1", "tibia"),
    "foot": ("foot", "ankle"),
    "toes": ("toe", "toes", "toebase", "toeball", "ball", "toe0", "footthumb1"),
    "clavicle": ("clavicle", "collar"),
    "upper_arm": ("arm", "upperarm", "uparm", "humerus", "bicep", "shldr"),
    "forearm": ("forearm", "lowerarm", "lowarm", "ulna", "elbow"),
    "hand": ("hand", "wrist"),
}
PART_OF = {word: part for part, words in SIDED.items() for word in words}
FINGER = re.compile(
    r"(?:hand)?(thumb|index|middle|ringpinky|ring|pinky|little)(?:finger)?"
    r"(1|2|3|prox|med|dist|metacarpal|proximal|intermediate|distal)"
)
FINGERS = {"ringpinky": "little", "pinky": "little"}
PHALANX = {"prox": "1", "med": "2", "dist": "3"}
PHALANX |= {"proximal": "1", "intermediate": "2", "distal": "3"}
# A thumb has no intermediate phalanx: VRM 1 calls its first joint so, and its second proximal.
THUMB = {"metacarpal": "1", "proximal": "2"}
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
CONTROL = re.compile(r"(?<![A-Za-z])ik|IK|ik(?![a-z])|[Cc]ontrol|[Rr]oll|[Pp]ole|[Tt]arget")
# Of so many names most must begin or end alike, for that to say nothing.
FEWEST_NAMES, MOST_ALIKE = 6, 0.9


def named_roles(names: tuple[str, ...]) -> dict[int, str]:
    """Roles by joint, as far as names tell them; several joints may have one."""
    words = [_side_and_part(name) for name in _bare(names)]
    roles = {}
    for joint, (side, part) in enumerate(words):
        role = _role(side, part, words)
        if role and not CONTROL.search(names[joint]):
            roles[joint] = role
    return roles


def named_sides(names: tuple[str, ...]) -> list[str]:
    """The side that each name tells; "" for none."""
    return [_side_and_part(name)[0] for name in _bare(names)]


def named_eyes(names: tuple[str, ...]) -> list[int]:
    """Joints of eyes, as far as names tell them."""
    parts = [_side_and_part(name)[1] for name in _bare(names)]
    return [joint for joint, part in enumerate(parts) if part in ("eye", "eyeball")]


def _bare(names: tuple[str, ...]) -> list[str]:
    """Names without what most of them begin with, and without numbers that end most of them."""
    bare_names = [name.rsplit(":", 1)[-1] for name in names]
    if len(names) < FEWEST_NAMES:
        return bare_names
    while True:
        starts = Counter(name.split("_", 1)[0] for name in bare_names if "_" in name)
        start, times = starts.most_common(1)[0] if starts else ("", 0)
        if times < MOST_ALIKE * len(names) or start.lower() in (*SIDES, "l", "r"):
            break
        bare_names = [name.removeprefix(start + "_") for name in bare_names]
    ends = [re.fullmatch(r"(.+)_\d+", name) for name in bare_names]
    if sum(end is not None for end in ends) >= MOST_ALIKE * len(names):
        bare_names = [end[1] if end else name for end, name in zip(ends, bare_names, strict=True)]
    return bare_names


def _role(side: str, part: str, words: list[tuple[str, str]]) -> str:
    if not side:
        return CENTRAL.get(part, "")
    finger = FINGER.fullmatch(part)
    if finger:
        name, phalanx = finger.groups()
        if name == "thumb" and (side, "thumbmetacarpal") in words:
            phalanx = THUMB.get(phalanx, phalanx)
        if phalanx == "metacarpal":  # of other fingers it lies in the palm
            return ""
        return f"{side}_{FINGERS.get(name, name)}_{PHALANX.get(phalanx, phalanx)}"
    known = {PART_OF.get(word, "") for at, word in words if at == side}
    if part == "shoulder":  # the collarbone where the upper arm has a word of its own
        part = "clavicle" if known >= {"upper_arm"} and "clavicle" not in known else "arm"
    if part == "hip" and "thigh" not in known:
        part = "thigh"
    return f"{side}_{PART_OF[part]}" if part in PART_OF else ""


def _side_and_part(name: str) -> tuple[str, str]:
    """("left", "upleg") of ``mixamorig:LeftUpLeg``; a side of "" where there is none."""
    words = [word.lower() for word in WORD.findall(name.rsplit(":", 1)[-1])]
    words = [str(int(word)) if word.isdigit() else word for word in words]
    if words and words[0] in ("bip", "mixamorig"):
        words = words[2:] if len(words) > 1 and words[1].isdigit() else words[1:]
    side = ""
    for at in (0, -1, 1):
        if len(words) <= max(at, 0) or side:
            continue
        for whole in SIDES:
            if words[at] in (whole, whole[0]):
                side = whole
                del words[at]
                break
            if words[at].startswith(whole):
                side, words[at] = whole, words[at][len(whole) :]
                break
    return side, "".join(words)


# Bones whose lengths differ by less, as a share of the longer, may be a pair's.
SAME_LENGTH = 0.2
# How far lengths along two chains may differ in all, as a share of the chain.
SAME_CHAIN = 0.12
# Of siblings and of children no more are compared, the longest first.
MOST_BRANCHES = 12
# Trees beyond this size are not searched for limbs.
MOST_JOINTS = 4000


@dataclass(frozen=True, eq=False)
class LimbPair:
    """Two limbs alike.

    Fields:
        chains: joints ``(N, 2)`` from where the limbs begin to their ends, one side a column.
        above: the joint on which both hang, −1 where they are roots.
    """

    chains: IntArray
    above: int


@dataclass(frozen=True, eq=False)
class JointTree:
    """Joints with parents before children, and where they lie in some pose.

    Fields:
        names: J names.
        parents: ``(J,)``, −1 for roots.
        at: ``(J, 3)`` places in one pose, in any unit.

    >>> import numpy as np
    >>> from motorcade.animation.anatomy.tree import JointTree
    >>> at = np.array([[0, 0, 1.0], [0.1, 0, 1], [-0.1, 0, 1], [0.1, 0, 0.5], [-0.1, 0.4, 0.7]])
    >>> tree = JointTree(("a", "b", "c", "d", "e"), np.array([-1, 0, 0, 1, 2]), at)
    >>> tree.limb_pairs[0].chains.tolist()
    [[1, 2], [3, 4]]
    """

    names: tuple[str, ...]
    parents: IntArray
    at: FloatArray

    @cached_property
    def children(self) -> list[list[int]]:
        """Joints below each; of the last entry, the roots."""
        below: list[list[int]] = [[] for _ in range(len(self.names) + 1)]
        for joint, parent in enumerate(self.parents.tolist()):
            below[parent].append(joint)
        return below

    @cached_property
    def bone(self) -> FloatArray:
        """Length ``(J,)`` of the bone from the joint above; 0 for roots."""
        held = self.parents >= 0
        lengths = np.zeros(len(self.names))
        lengths[held] = np.linalg.norm(self.at[held] - self.at[self.parents[held]], axis=1)
        return lengths

    @cached_property
    def reach(self) -> FloatArray:
        """The longest way ``(J,)`` along bones from each joint to an end."""
        reached = np.zeros(len(self.names))
        for joint in range(len(self.names) - 1, -1, -1):
            parent = int(self.parents[joint])
            if parent >= 0:
                reached[parent] = max(reached[parent], reached[joint] + self.bone[joint])
        return reached

    def line(self, joint: int) -> list[int]:
        """A joint and its parents, the nearest first."""
        upward = [joint]
        while self.parents[upward[-1]] >= 0:
            upward.append(int(self.parents[upward[-1]]))
        return upward

    def is_below(self, joint: int, above: int) -> bool:
        """Whether a joint is another, or hangs below it; below −1 hang all."""
        while joint > above:
            joint = int(self.parents[joint])
        return joint == above

    @cached_property
    def limb_pairs(self) -> list[LimbPair]:
        """Pairs that hang on the middle line of the tree, from the roots on."""
        if len(self.names) > MOST_JOINTS:
            return []
        limbs, middle = [], [-1]
        while middle:
            above = middle.pop()
            free = self._longest(self.children[above])
            pairs = [self._chain(a, b) for k, a in enumerate(free) for b in free[k + 1 :]]
            taken: set[int] = set()
            for chains, cost in sorted(pairs, key=lambda candidate: candidate[1]):
                if cost > SAME_CHAIN or taken & set(chains[0]):
                    continue
                taken |= set(chains[0])
                limbs.append(LimbPair(np.array(chains), above))
            middle += [joint for joint in self.children[above] if joint not in taken]
        return limbs

    def _longest(self, joints: list[int]) -> list[int]:
        return sorted(joints, key=lambda joint: -(self.reach[joint] + self.bone[joint]))[
            :MOST_BRANCHES
        ]

    def _chain(self, a: int, b: int) -> tuple[list[tuple[int, int]], float]:
        """The longest chain alike below two joints, and how unlike it is, as a share."""
        chain, length, apart = [(a, b)], 0.0, 0.0
        first = max(self.bone[a], self.bone[b])
        apart += abs(self.bone[a] - self.bone[b])
        while True:
            a, b = chain[-1]
            best, most = None, 0.0
            for c in self._longest(self.children[a]):
                for d in self._longest(self.children[b]):
                    bone_c, other = float(self.bone[c]), float(self.bone[d])
                    if abs(bone_c - other) > SAME_LENGTH * max(bone_c, other) + 0.02 * length:
                        continue
                    ways = bone_c + self.reach[c], other + self.reach[d]
                    worth = min(ways) - 2.0 * abs(bone_c - other)
                    if worth > most or best is None:
                        best, most = (c, d), worth
            if best is None:
                break
            bone_c, other = self.bone[best[0]], self.bone[best[1]]
            length, apart = length + max(bone_c, other), apart + abs(bone_c - other)
            chain.append(best)
        size = length + first
        reached = size / max(min(self.reach[k] + self.bone[k] for k in chain[0]), 1e-12)
        unlike = apart / size if size > 0.0 else 1.0
        return chain, unlike + 0.5 * max(0.0, 1.0 - reached)
