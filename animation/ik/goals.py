"""Goals of inverse kinematics: where joints shall be, how turned, and what they look at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.ik.joints import checked_direction
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, checked_floats, checked_number

# How heavy goals may be, and how far away: beyond that squares of what is left overflow.
_LIGHTEST, _HEAVIEST, _FARTHEST_M = 1e-6, 1e6, 1e9
# Aims as the compiled solver numbers them.
_POSITION, _ORIENTATION, _DIRECTION = range(3)
_NO_TURN = np.array([1.0, 0.0, 0.0, 0.0])

# Aim, point and axis in the joint, and target (*, 7): a point and a rotor.
Row = tuple[int, FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class PoseGoal:
    """A joint at a place, or turned in a way, or both.

    Args:
        joint: its name.
        position_m: ``(*, 3)`` in character space where its `point_m` shall be.
        rotor: Rotor ``(*)``, ``character_T_joint``: how it shall be turned.
        weight: from 1e-6 to 1e6; what is left of goals that cannot all be reached is shared out
            by least squares, in which the figure's longest chain of bones counts as much as one
            radian.
            Two goals for one joint give place and turn weights of their own.
        point_m: ``(3,)`` in the joint's frame: a palm or a sole; by default the joint itself.

    Raises:
        ValueError: neither place nor turn, shapes that do not fit, NaN or infinity, lengths over
            1e9 m, a weight outside its range.
        TypeError: a turn that is no rotor, a weight that is no number.

    >>> from motorcade.animation.ik import PoseGoal
    >>> reach = PoseGoal("left_hand", [0.4, 0.3, 1.2])
    """

    joint: str
    position_m: ArrayLike | None = None
    rotor: Rotor | None = None
    weight: float = 1.0
    point_m: ArrayLike = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.position_m is None and self.rotor is None:
            raise ValueError("PoseGoal: expected position_m or rotor, got neither")
        if self.rotor is not None and not isinstance(self.rotor, Rotor):
            raise TypeError(f"PoseGoal(rotor): expected a Rotor, got {type(self.rotor).__name__}")
        _check_weight(self.weight, "PoseGoal(weight)")
        self.rows()

    @classmethod
    def anchor(
        cls, skeleton: Skeleton, local_pose: Motor, joint: str, weight: float = 1.0
    ) -> PoseGoal:
        """A joint held where a pose has it, place and turn: a foot while the body moves.

        Args:
            skeleton: with J joints.
            local_pose: Motor ``(*, J)``.
            joint: which is held.
            weight: see `PoseGoal`.
        """
        at = skeleton.world(local_pose)[..., skeleton.index(joint)]
        return cls(joint, at.translation_m, at.rotor, weight)

    def rows(self) -> list[Row]:
        """What the compiled solver takes, a row for the place and one for the turn."""
        point = _vector(self.point_m, "PoseGoal(point_m)")
        made = []
        if self.position_m is not None:
            place = _near(self.position_m, "PoseGoal(position_m)")
            made.append((_POSITION, point, np.zeros(3), _target(place, _NO_TURN)))
        if self.rotor is not None:
            target = _target(np.zeros(3), self.rotor.coefficients.astype(np.float64))
            made.append((_ORIENTATION, point, np.zeros(3), target))
        return made


@dataclass(frozen=True, eq=False)
class LookAt:
    """A joint with an axis of its own that points at a target, like a head or a hand.

    Args:
        joint: its name.
        target_m: ``(*, 3)`` in character space.
        axis: ``(3,)`` in the joint's frame, of any length but 0.
        weight: as of `PoseGoal`; the angle that is left counts in radians.
        point_m: ``(3,)`` in the joint's frame from which it looks: the eyes.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity, lengths over 1e9 m, an axis without
            direction, a weight outside its range.
        TypeError: a weight that is no number.

    >>> from motorcade.animation.ik import LookAt
    >>> camera = LookAt("head", [3.0, 0.0, 1.5], axis=[1.0, 0.0, 0.0])
    """

    joint: str
    target_m: ArrayLike
    axis: ArrayLike = (1.0, 0.0, 0.0)
    weight: float = 1.0
    point_m: ArrayLike = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        _check_weight(self.weight, "LookAt(weight)")
        self.rows()

    def rows(self) -> list[Row]:
        """What the compiled solver takes."""
        axis = checked_direction(self.axis, "LookAt(axis)")
        target = _target(_near(self.target_m, "LookAt(target_m)"), _NO_TURN)
        return [(_DIRECTION, _vector(self.point_m, "LookAt(point_m)"), axis, target)]


Goal = PoseGoal | LookAt


def _vector(value: ArrayLike, name: str) -> FloatArray:
    made = _near(value, name)
    if made.shape != (3,):
        raise ValueError(f"{name}: expected shape (3,), got {made.shape}")
    return made


def _near(value: ArrayLike, name: str) -> FloatArray:
    made = checked_floats(value, name, (3,))
    if np.any(np.abs(made) > _FARTHEST_M):
        raise ValueError(
            f"{name}: expected lengths within {_FARTHEST_M:g} m, got {np.abs(made).max():g}"
        )
    return made


def _target(point: FloatArray, rotor: FloatArray) -> FloatArray:
    made = np.empty((*np.broadcast_shapes(point.shape[:-1], rotor.shape[:-1]), 7))
    made[..., :3], made[..., 3:] = point, rotor
    return made


def _check_weight(weight: float, name: str) -> None:
    if not _LIGHTEST <= checked_number(weight, name) <= _HEAVIEST:
        raise ValueError(
            f"{name}: expected a number from {_LIGHTEST:g} to {_HEAVIEST:g}, got {weight}"
        )
