"""Soles over the ground: how low they are, and heels and toes raised to it by turns of the foot.

Where a foot's heel and toes are is known from the rest pose, in which soles lie on z = 0: the heel
behind the ankle and the tip before the ball by shares of a human foot.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from motorcade.animation.ik.chain import shortest_turn
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import FloatArray, Motor, Rotor

__all__ = ["raised_soles", "sole_clearance_m"]

# Behind the ankle and before the ball, as shares of the way from ankle to ball.
HEEL, TIP = 0.47, 0.7

Heights = Callable[[FloatArray], FloatArray]


def raised_soles(
    skeleton: Skeleton, feet: tuple[Motor, Motor], ankle: int, ball: int, ground_m: Heights
) -> tuple[Motor, Rotor]:
    """A foot turned about its ball until its heel, and its toes until their tip, are not sunk.

    Args:
        skeleton: at rest with its soles on z = 0.
        feet: ankle and ball in the world ``(F,)`` each; the ball is where it shall be.
        ankle: number of the joint.
        ball: number of the joint.
        ground_m: heights ``(*)`` of the ground at positions ``(*, 2)``.

    Returns:
        the ankle in the world ``(F,)``, and the ball's rotor in the world ``(F,)``.
    """
    rest = skeleton.rest_world
    heel, _, tip = _sole(skeleton, ankle, ball)
    pivot = feet[1].translation_m
    behind = feet[0].apply(rest[ankle].inverse().apply(heel)) - pivot
    turn = _raising(behind, pivot, ground_m)
    foot = Motor.from_rotor_translation(
        turn @ feet[0].rotor, pivot + turn.apply(feet[0].translation_m - pivot)
    )
    toes = turn @ feet[1].rotor
    before = toes.apply(rest[ball].inverse().apply(tip))
    return Motor.normalize(foot.coefficients), _raising(before, pivot, ground_m) @ toes


def sole_clearance_m(
    skeleton: Skeleton, feet: tuple[Motor, Motor], ankle: int, ball: int, ground_m: Heights
) -> FloatArray:
    """Heights ``(F,)`` over the ground of the lowest of heel, ball and tip, or the foot's joint.

    Args as for `raised_soles`; a ball that is no child of the ankle, or is the ankle, has no sole
    but itself.
    """
    rest = skeleton.rest_world
    heel, middle, tip = _sole(skeleton, ankle, ball)
    marks = [(1, ball, middle)]
    if skeleton.parents[ball] == ankle:
        marks += [(0, ankle, heel), (1, ball, tip)]
    at = [feet[foot].apply(rest[joint].inverse().apply(mark)) for foot, joint, mark in marks]
    over: FloatArray = np.min([one[:, 2] - ground_m(one[:, :2]) for one in at], axis=0)
    return over


def _sole(skeleton: Skeleton, ankle: int, ball: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Heel, ball and tip of the sole in character space, at rest."""
    at = skeleton.rest_world.translation_m
    along = at[ball] - at[ankle]
    marks = (at[ankle] - HEEL * along, at[ball].copy(), at[ball] + TIP * along)
    for mark in marks:
        mark[2] = 0.0
    return marks


def _raising(lever: FloatArray, pivot: FloatArray, ground_m: Heights) -> Rotor:
    """The least turns that bring the ends of levers ``(F, 3)`` up to the ground."""
    length = np.linalg.norm(lever, axis=1)
    least = ground_m((pivot + lever)[:, :2]) - pivot[:, 2]
    height = np.minimum(np.maximum(lever[:, 2], least), length)
    flat = np.linalg.norm(lever[:, :2], axis=1)
    across = np.sqrt(np.maximum(length**2 - height**2, 0.0))
    raised = lever * np.where(flat > 0.0, across / np.where(flat > 0.0, flat, 1.0), 1.0)[:, None]
    raised[:, 2] = height
    return shortest_turn(lever, raised)
