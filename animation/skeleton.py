"""Skeleton: a tree of joints, each placed in its parent by a motor.

A joint's local pose is `parent_T_joint`, the root's is `character_T_joint`; a pose of the whole
skeleton is a Motor of shape (*, J), or a Similarity where joints grow or shrink. Joints stand in
an order in which parents come first.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor, Similarity, Versor, kernels
from motorcade.ga.arrays import IntArray

Poses = TypeVar("Poses", bound=Versor)


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joint names, parents and the rest pose in which the mesh was bound.

    Args:
        names: J different names.
        parents: (J,) number of each joint's parent, smaller than its own; −1 for a root.
        rest: Motor (J,), local rest pose `parent_T_joint`, metres.

    Raises:
        ValueError: names that repeat, lengths that differ, or a parent that comes after its child.

    >>> import numpy as np
    >>> from motorcade.animation import Skeleton
    >>> from motorcade.ga import Motor
    >>> parent_T_joint = Motor.from_translation([[0, 0, 1.0], [0, 0, -0.5], [0, 0, -0.5]])
    >>> leg = Skeleton(("hip", "knee", "ankle"), np.array([-1, 0, 1]), parent_T_joint)

    >>> leg.world(leg.rest).translation_m + 0.0  # character_T_joint
    array([[0. , 0. , 1. ],
           [0. , 0. , 0.5],
           [0. , 0. , 0. ]])
    >>> leg.names[leg.root], leg.index("ankle")
    ('hip', 2)
    """

    names: tuple[str, ...]
    parents: IntArray
    rest: Motor

    def __post_init__(self) -> None:
        count = len(self.names)
        twice = sorted(name for name, times in Counter(self.names).items() if times > 1)
        if not count or twice:
            raise ValueError(f"Skeleton.names: expected one or more different names, got {twice}")
        parents = np.array(self.parents)
        if parents.shape != (count,) or parents.dtype.kind != "i":
            raise ValueError(
                f"Skeleton.parents: expected {count} integers to match names, got shape "
                f"{parents.shape} of {parents.dtype}"
            )
        wrong = np.flatnonzero((parents >= np.arange(count)) | (parents < -1))
        if wrong.size:
            joint = int(wrong[0])
            raise ValueError(
                "Skeleton.parents: expected -1 or the number of an earlier joint, got "
                f"{int(parents[joint])} for joint {joint} '{self.names[joint]}'"
            )
        if self.rest.shape != (count,):
            raise ValueError(f"Skeleton.rest: expected shape ({count},), got {self.rest.shape}")
        own = parents.astype(np.int64)
        own.setflags(write=False)
        object.__setattr__(self, "parents", own)

    def __len__(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """Number of the joint of that name.

        Raises:
            ValueError: no such joint.
        """
        if name not in self.names:
            raise ValueError(f"Skeleton: expected one of its joints, got '{name}'")
        return self.names.index(name)

    def world(self, local: Poses) -> Poses:
        """Poses `character_T_joint` (*, J) from local poses `parent_T_joint` (*, J).

        Takes motors, or similarities, whose scale children inherit.

        Raises:
            ValueError: a last dimension other than the number of joints.
        """
        if not local.shape or local.shape[-1] != len(self):
            raise ValueError(
                f"Skeleton.world(local): expected shape (*, {len(self)}), got {local.shape}"
            )
        poses = np.array(local.coefficients)
        growing = isinstance(local, Similarity)
        compose = (kernels.SIMILARITIES if growing else kernels.MOTORS).compose
        for joints in self._levels[1:]:
            above = poses[..., self.parents[joints], :]
            poses[..., joints, :] = compose(above, poses[..., joints, :])
        return type(local)(poses)

    def local(self, world: Poses) -> Poses:
        """Local poses `parent_T_joint` (*, J) from poses `character_T_joint` (*, J)."""
        return local_poses(self.parents, world)

    def moved(self, local: Poses, motion: Motor) -> Poses:
        """Local poses (*, J) of the whole figure moved in character space by motors (*)."""
        moved = local
        kind = type(local)
        growing = Similarity.from_motor_scale(motion) if isinstance(local, Similarity) else motion
        before = kind(growing.coefficients)
        for root in np.flatnonzero(self.parents < 0):
            moved = with_joint(moved, int(root), before @ local[..., root])
        return moved

    @cached_property
    def root(self) -> int:
        """Number of the first root."""
        return int(np.argmax(self.parents < 0))

    @cached_property
    def rest_world(self) -> Motor:
        """Rest poses `character_T_joint` (J,)."""
        return self.world(self.rest)

    @cached_property
    def rest_world_inverse(self) -> Motor:
        """`joint_T_character` (J,) in the rest pose: it takes a bound vertex to its joint."""
        return self.rest_world.inverse()

    @cached_property
    def _levels(self) -> list[IntArray]:
        """Joints by their distance from the root."""
        depth = np.zeros(len(self), dtype=np.int64)
        for joint, parent in enumerate(self.parents):
            depth[joint] = 0 if parent < 0 else depth[parent] + 1
        return [np.flatnonzero(depth == level) for level in range(int(depth.max()) + 1)]


def local_poses(parents: IntArray, world: Poses) -> Poses:
    """Poses `parent_T_joint` (*, J) from those in a common frame (*, J); roots stay as they are."""
    held = np.flatnonzero(parents >= 0)
    local = np.array(world.coefficients)
    local[..., held, :] = (world[..., parents[held]].inverse() @ world[..., held]).coefficients
    return type(world).normalize(local)


def with_joint(poses: Poses, joint: int, joint_pose: Poses) -> Poses:
    """Local poses (*, J) in which one joint's pose is `made` (*) instead; batches broadcast."""
    shape = np.broadcast_shapes(poses.shape[:-1], joint_pose.shape)
    size = poses.coefficients.shape[-2:]
    changed = np.broadcast_to(poses.coefficients, (*shape, *size)).copy()
    changed[..., joint, :] = type(poses).normalize(joint_pose.coefficients).coefficients
    return type(poses)(changed)


def turned_joint(poses: Motor, joint: int, rotor: Rotor) -> Motor:
    """Local poses (*, J) in which a joint stays where it is, turned as `rotor` (*) says."""
    shift_m = poses[..., joint].translation_m
    return with_joint(poses, joint, Motor.from_rotor_translation(rotor, shift_m))


def at_or_below(parents: IntArray, joints: int | Sequence[int]) -> NDArray[np.bool_]:
    """Whether each joint (J,) is one of some, or hangs below one; parents stand first."""
    held = np.zeros(len(parents), dtype=bool)
    held[joints] = True
    for joint, parent in enumerate(parents.tolist()):
        held[joint] |= parent >= 0 and held[parent]
    return held
