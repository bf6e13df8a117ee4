"""Chains of a skeleton brought to points: joints turn by the least that lays their bones there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.ik.fabrik import fabrik
from motorcade.animation.skeleton import Skeleton, turned_joint
from motorcade.animation.vectors import shortest_turn
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, checked_floats


@dataclass(frozen=True)
class Chain:
    """Joints from a base to an end, each the parent of the next, with limits.

    Args:
        joints: names, base first, two or more.
        max_bend_rad: the angle that the bones at each inner joint may make at most: one number, or
            one for each.

    Raises:
        ValueError: fewer than two joints.

    >>> import numpy as np
    >>> from motorcade.animation import Chain, Skeleton
    >>> from motorcade.ga import Motor
    >>> rest = Motor.from_translation([[0.0, 0.0, 1.4], [0.3, 0.0, 0.0], [0.3, 0.0, 0.0]])
    >>> arm = Skeleton(("shoulder", "elbow", "wrist"), np.array([-1, 0, 1]), rest)
    >>> Chain(("elbow", "wrist"), max_bend_rad=2.5).numbers(arm)
    [1, 2]
    """

    joints: tuple[str, ...]
    max_bend_rad: float | tuple[float, ...] = float(np.pi)

    def __post_init__(self) -> None:
        if len(self.joints) < 2:
            raise ValueError(f"Chain.joints: expected two or more, got {self.joints}")

    def numbers(self, skeleton: Skeleton) -> list[int]:
        """Numbers of the joints in a skeleton.

        Raises:
            ValueError: a joint that it does not have, or one whose parent is not the one before.
        """
        numbers = [skeleton.index(name) for name in self.joints]
        for above, below in pairwise(numbers):
            if skeleton.parents[below] != above:
                raise ValueError(
                    f"Chain.joints: expected '{skeleton.names[above]}' to be the parent of "
                    f"'{skeleton.names[below]}'"
                )
        return numbers


def reach_with(
    skeleton: Skeleton, local_pose: Motor, chain: Chain, target_m: ArrayLike
) -> tuple[Motor, FloatArray]:
    """Bring the end of a chain to a target; all other joints keep their local poses.

    Args:
        skeleton: with J joints.
        local_pose: Motor ``(*, J)``.
        chain: which joints turn, all but the last.
        target_m: ``(*, 3)`` in character space.

    Returns:
        local poses ``(*, J)``, and the distance ``(*)`` of the end from the target in metres.

    Raises:
        ValueError: a chain that is none of the skeleton, shapes that do not fit.

    >>> import numpy as np
    >>> from motorcade.animation import Chain, Skeleton, reach_with
    >>> from motorcade.ga import Motor
    >>> parent_T_joint = Motor.from_translation([[0, 0, 1.0], [0, 0, -0.5], [0, 0, -0.5]])
    >>> leg = Skeleton(("hip", "knee", "ankle"), np.array([-1, 0, 1]), parent_T_joint)

    >>> made, error_m = reach_with(leg, leg.rest, Chain(("hip", "knee", "ankle")), [0.4, 0, 0.4])
    >>> bool(error_m < 1e-4)
    True
    >>> leg.world(made).translation_m[2].round(3) + 0.0
    array([0.4, 0. , 0.4])
    """
    numbers = chain.numbers(skeleton)
    goal = checked_floats(target_m, "reach_with(target_m)", (3,))
    start = skeleton.world(local_pose).translation_m[..., numbers, :]
    solved = fabrik(start, goal, chain.max_bend_rad)
    return laid_along(skeleton, local_pose, numbers, solved.points), solved.error_m


def laid_along(
    skeleton: Skeleton, local_pose: Motor, numbers: Sequence[int], points_m: FloatArray
) -> Motor:
    """Turn a chain's joints so that its bones lie along points; the first joint stays.

    Args:
        skeleton: with J joints.
        local_pose: Motor ``(*, J)``.
        numbers: N joints of the chain, base first; joints between go along with those above.
        points_m: ``(*, N, 3)`` in character space, as far apart as the bones are long.

    Returns:
        local poses ``(*, J)``.
    """
    world = skeleton.world(local_pose)
    batch = np.broadcast_shapes(world.shape[:-1], points_m.shape[:-2])
    size = local_pose.coefficients.shape[-2:]
    made = Motor(np.broadcast_to(local_pose.coefficients, (*batch, *size)))
    turned = Rotor.identity()
    at = world.translation_m
    for k, joint in enumerate(numbers[:-1]):
        parent = int(skeleton.parents[joint])
        # What lies between two joints of the chain has turned as the first of them did.
        above = turned @ world[..., parent].rotor if parent >= 0 else Rotor.identity()
        bone = at[..., numbers[k + 1], :] - at[..., joint, :]
        turned = shortest_turn(bone, points_m[..., k + 1, :] - points_m[..., k, :])
        made = turned_joint(made, joint, above.inverse() @ turned @ world[..., joint].rotor)
    return made
