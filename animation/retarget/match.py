"""Two skeletons, which of their joints belong together, and whether their rests can be compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations, product

import numpy as np

from motorcade.animation.retarget.roles import SIDES, ancestors, body_of
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import UP
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

__all__ = ["LIMBS", "NO_BONE_M", "Match", "along_axes", "angle_rad"]

# Bones shorter than this have no direction to lay along.
NO_BONE_M = 1e-4
# One rig: bones within this angle in their joints' frames, for this share of the joints.
SAME_BONE_RAD, SAME_SHARE = np.radians(4.0), 0.85
# A rest to compare by: limbs of both sides mirrored, thighs hanging, within these angles.
MIRRORED_RAD, HANGING_RAD = np.radians(12.0), np.radians(35.0)
LIMBS = (("thigh", "calf", "foot"), ("upper_arm", "forearm", "hand"))
# All turns that take the axes to axes.
AXES = Rotor.from_matrix(
    np.array(
        [
            m
            for order in permutations(range(3))
            for signs in product((1.0, -1.0), repeat=3)
            if np.linalg.det(m := np.eye(3)[list(order)] * signs) > 0.0
        ]
    )
)


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


def along_axes(rotor: Rotor) -> Rotor:
    """The nearest turn that takes the axes to axes."""
    return AXES[int(np.argmin((AXES.inverse() @ rotor).angle()))]
