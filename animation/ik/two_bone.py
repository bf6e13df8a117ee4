"""Limbs of two bones, solved in closed form, and joints that look at something.

The middle joint lies on two spheres, around the limb's root and around its target, hence on a
circle; of that the point is taken that lies towards the pole. The same meet of spheres stands as a
CLUScript in ``docs/scripts/two_link_arm.clu``.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.ik.chain import laid_along
from motorcade.animation.skeleton import Skeleton, turned_joint
from motorcade.animation.vectors import length, perpendicular, shortest_turn, unit
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, checked_floats

# A limb is never quite stretched or folded: there its bend would have no direction.
SLACK = 1e-6


def bend_limb(
    skeleton: Skeleton,
    local_pose: Motor,
    joints: tuple[str, str, str],
    target_m: ArrayLike,
    pole_m: ArrayLike | None = None,
    *,
    keep_end_orientation: bool = True,
) -> Motor:
    """Bring the end of an arm or leg to a target.

    A target out of reach has the limb stretched straight towards it, one too near has it folded.

    Args:
        skeleton: with J joints.
        local_pose: Motor ``(*, J)``.
        joints: root, middle and end of the limb, each above the next; joints between them go
            along with the one above.
        target_m: ``(*, 3)`` in character space.
        pole_m: ``(*, 3)`` the middle joint bends towards it; without one it bends as it did.
        keep_end_orientation: whether the end keeps its orientation in character space (a foot on
            the ground) or goes along with the lower bone (a hand).

    Returns:
        local poses ``(*, J)``.

    Raises:
        ValueError: joints that are no limb, shapes that do not fit, bones of no length.

    >>> import numpy as np
    >>> from motorcade.animation import Skeleton, bend_limb
    >>> from motorcade.ga import Motor
    >>> parent_T_joint = Motor.from_translation([[0, 0, 1.0], [0, 0, -0.5], [0, 0, -0.5]])
    >>> leg = Skeleton(("hip", "knee", "ankle"), np.array([-1, 0, 1]), parent_T_joint)

    >>> limb = ("hip", "knee", "ankle")
    >>> crouched = bend_limb(leg, leg.rest, limb, [0.0, 0, 0.2], pole_m=[1.0, 0, 0.5])
    >>> leg.world(crouched).translation_m.round(3) + 0.0  # the knee goes ahead
    array([[0. , 0. , 1. ],
           [0.3, 0. , 0.6],
           [0. , 0. , 0.2]])
    """
    numbers = _limb(skeleton, joints)
    goal = checked_floats(target_m, "bend_limb(target_m)", (3,))
    world = skeleton.world(local_pose)
    root, middle, end = (world.translation_m[..., k, :] for k in numbers)
    upper, lower = length(middle - root), length(end - middle)
    if not (np.all(upper > 0.0) and np.all(lower > 0.0)):
        raise ValueError(f"bend_limb(joints): expected bones longer than 0 between {joints}")
    pole = middle if pole_m is None else checked_floats(pole_m, "bend_limb(pole_m)", (3,))
    knee, ankle = _middle_and_end(root, goal, pole - root, upper, lower)
    batch = np.broadcast_shapes(root.shape, ankle.shape)
    points = np.stack([np.broadcast_to(one, batch) for one in (root, knee, ankle)], axis=-2)
    bent = laid_along(skeleton, local_pose, numbers, points)
    if not keep_end_orientation:
        return bent
    above = skeleton.world(bent)[..., int(skeleton.parents[numbers[2]])].rotor
    return turned_joint(bent, numbers[2], above.inverse() @ world[..., numbers[2]].rotor)


def _limb(skeleton: Skeleton, joints: tuple[str, str, str]) -> list[int]:
    """Numbers of a limb's joints.

    Raises ValueError: a joint that it does not have, or one that is not above the next.
    """
    numbers = [skeleton.index(name) for name in joints]
    for above, below in pairwise(numbers):
        joint = int(skeleton.parents[below])
        while joint > above:
            joint = int(skeleton.parents[joint])
        if joint != above:
            raise ValueError(
                f"bend_limb(joints): expected '{skeleton.names[above]}' to be above "
                f"'{skeleton.names[below]}', whose parents do not lead there"
            )
    return numbers


def _middle_and_end(
    root: FloatArray, goal: FloatArray, towards: FloatArray, upper: FloatArray, lower: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Where middle and end lie, ``(*, 3)`` each."""
    away = goal - root
    distance = length(away)
    ahead = unit(away, [0.0, 0.0, -1.0])
    most, least = (1.0 - SLACK) * (upper + lower), np.abs(upper - lower) * (1.0 + SLACK)
    reach = np.clip(distance, np.maximum(least, SLACK * most), most)
    side = towards - np.sum(towards * ahead, axis=-1, keepdims=True) * ahead
    side = unit(np.where(length(side) > SLACK * upper, side, perpendicular(ahead)))
    along = (reach**2 + upper**2 - lower**2) / (2.0 * reach)
    height = np.sqrt(np.maximum(upper**2 - along**2, 0.0))
    return root + along * ahead + height * side, root + reach * ahead


def aim(
    skeleton: Skeleton,
    local_pose: Motor,
    joint: str,
    target_m: ArrayLike,
    axis: ArrayLike = (1.0, 0.0, 0.0),
    *,
    share: float = 1.0,
    max_turn_rad: float = np.pi,
) -> Motor:
    """Turn a joint so that an axis of its own points at a target, by the least turn.

    Args:
        skeleton: with J joints.
        local_pose: Motor ``(*, J)``.
        joint: which turns; its children go along.
        target_m: ``(*, 3)`` in character space.
        axis: ``(3,)`` in the joint's frame.
        share: of the turn, 0 to 1.
        max_turn_rad: the turn is cut off there.

    Returns:
        local poses ``(*, J)``.

    Raises:
        ValueError: no such joint, an axis without direction, a share outside 0 to 1.

    >>> import numpy as np
    >>> from motorcade.animation import Skeleton, aim
    >>> from motorcade.ga import Motor
    >>> parent_T_joint = Motor.from_translation([[0, 0, 1.0], [0, 0, -0.5], [0, 0, -0.5]])
    >>> leg = Skeleton(("hip", "knee", "ankle"), np.array([-1, 0, 1]), parent_T_joint)

    >>> looking = aim(leg, leg.rest, "hip", [0.0, 3.0, 1.0], axis=[1.0, 0, 0])
    >>> looking.rotor.apply([1.0, 0, 0])[0].round(6) + 0.0
    array([0., 1., 0.])
    """
    number = skeleton.index(joint)
    own = checked_floats(axis, "aim(axis)", (3,))
    if not np.any(own):
        raise ValueError(f"aim(axis): expected a direction, got {own}")
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"aim(share): expected 0 to 1, got {share}")
    goal = checked_floats(target_m, "aim(target_m)", (3,))
    world = skeleton.world(local_pose)
    pose = world[..., number]
    turn = shortest_turn(pose.rotor.apply(own), goal - pose.translation_m).as_rotation_vector()
    angle = length(turn)
    held = np.minimum(share * angle, max_turn_rad)
    turned = Rotor.from_rotation_vector(held * unit(turn))
    parent = int(skeleton.parents[number])
    above = world[..., parent].rotor if parent >= 0 else Rotor.identity()
    return turned_joint(local_pose, number, above.inverse() @ turned @ pose.rotor)
