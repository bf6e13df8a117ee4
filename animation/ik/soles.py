"""Soles over the ground: how low they are, and heels and toes raised to it by turns of the foot.

Where a foot's heel and toes are is known from the rest pose, in which soles lie on z = 0: the heel
behind the ankle and the tip before the ball by shares of the way between the two. Boots are wide as
well: their edges are known where a mesh was measured.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import shortest_turn
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

Heights = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Sole:
    """Numbers of a foot's joints, and how far heel and tip lie behind ankle and before ball.

    Fields:
        foot_m, toes_m: ``(P, 3)`` of the skin in character space at rest, where it may touch the
            ground; they go along with ankle and ball.
    """

    ankle: int
    ball: int
    heel: float
    tip: float
    foot_m: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    toes_m: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    def marks(self, skeleton: Skeleton) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Heel, ball and tip of the sole in character space, at rest."""
        at = skeleton.rest_world.translation_m
        start, end = at[self.ankle], at[self.ball]
        found = start - self.heel * (end - start), end.copy(), end + self.tip * (end - start)
        for mark in found:
            mark[2] = 0.0
        return found


def raised_soles(
    skeleton: Skeleton, feet: tuple[Motor, Motor], sole: Sole, ground_m: Heights
) -> tuple[Motor, Rotor]:
    """A foot turned about its ball until its heel, and its toes until their tip, are not sunk.

    Args:
        skeleton: at rest with its soles on z = 0.
        feet: ankle and ball in the world ``(F,)`` each; the ball is where it shall be.
        sole: which joints they are.
        ground_m: heights ``(*)`` of the ground at positions ``(*, 2)``.

    Returns:
        the ankle in the world ``(F,)``, and the ball's rotor in the world ``(F,)``.
    """
    rest = skeleton.rest_world
    heel, _, tip = sole.marks(skeleton)
    ankle, ball = sole.ankle, sole.ball
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
    skeleton: Skeleton, feet: tuple[Motor, Motor], sole: Sole, ground_m: Heights
) -> FloatArray:
    """Heights ``(F,)`` over the ground of the lowest of what the sole has, or the foot's joint.

    Args as for `raised_soles`; see `sole_points`.
    """
    at = sole_points(skeleton, feet, sole)
    made: FloatArray = np.min(at[..., 2] - ground_m(at[..., :2]), axis=1)
    return made


def sole_points(skeleton: Skeleton, feet: tuple[Motor, Motor], sole: Sole) -> FloatArray:
    """Where the sole is in the world ``(F, P, 3)``: its skin if that was measured, or its marks.

    Marks are heel, ball and tip; a ball that is no child of the ankle, or is the ankle, has no mark
    but itself.

    Args as for `raised_soles`.
    """
    heel, middle, tip = sole.marks(skeleton)
    of_foot, of_toes = sole.foot_m, sole.toes_m
    if not len(of_foot) + len(of_toes):
        joined = skeleton.parents[sole.ball] == sole.ankle
        of_foot = np.array([heel] if joined else []).reshape(-1, 3)
        of_toes = np.array([middle, tip] if joined else [middle])
    parts = ((feet[0], sole.ankle, of_foot), (feet[1], sole.ball, of_toes))
    found = [
        pose.reshape(-1, 1).apply(skeleton.rest_world[joint].inverse().apply(points))
        for pose, joint, points in parts
    ]
    return np.concatenate(found, axis=1)


def bent_toes(
    skeleton: Skeleton, feet: tuple[Motor, Motor], sole: Sole, ground_m: Heights
) -> Rotor:
    """The ball's rotor in the world ``(F,)``: toes bent up about it until their tip is not sunk.

    Args as for `raised_soles`.
    """
    _, _, tip = sole.marks(skeleton)
    pivot = feet[1].translation_m
    before = feet[1].apply(skeleton.rest_world[sole.ball].inverse().apply(tip)) - pivot
    return _raising(before, pivot, ground_m) @ feet[1].rotor


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
