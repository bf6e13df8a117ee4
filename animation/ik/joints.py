"""How joints may turn in inverse kinematics: hinges, balls, and a body that floats.

A joint's turn ``R`` is measured from its rest pose, in its own frame: ``parent_T_joint`` is
``rest @ R``. A ball's turn is ``R = S @ T``: a twist ``T`` about its axis first, then a swing ``S``
about an axis across it, so that twist turns the bone about itself and swing says where it points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.vectors import perpendicular, unit
from motorcade.ga.arrays import FloatArray, checked_floats, checked_number

# Kinds as the compiled solver numbers them.
_HINGE, _BALL, _FREE_BALL, _FLOATING = range(4)
_ANY_TURN = (-np.inf, np.inf)
# Angles lose their digits far from 0.
_WIDEST_RAD = 1e3


@dataclass(frozen=True)
class Hinge:
    """A joint that turns about one axis, like a knee.

    Args:
        axis: ``(3,)`` in the joint's frame, of any length but 0.
        low_rad, high_rad: between which angles from its rest pose it turns, right-handed about the
            axis; without limits by default.

    Raises:
        ValueError: an axis without direction, NaN, a lower limit above the upper one, finite ones
            beyond 1000 rad.
        TypeError: a limit that is no number.

    >>> from motorcade.animation.ik import Hinge
    >>> Hinge([0.0, 1.0, 0.0], 0.0, 2.4).high_rad
    2.4
    """

    axis: ArrayLike
    low_rad: float = -np.inf
    high_rad: float = np.inf

    def __post_init__(self) -> None:
        checked_direction(self.axis, "Hinge(axis)")
        _check_interval(self.low_rad, self.high_rad, "Hinge(low_rad, high_rad)")

    def row(self, name: str, bone: FloatArray) -> tuple[int, FloatArray, FloatArray]:
        """Kind, axes ``(3, 3)`` and limits ``(4,)`` as the compiled solver takes them."""
        limits = np.array([0.0, 0.0, self.low_rad, self.high_rad])
        return _HINGE, _frame(checked_direction(self.axis, "Hinge(axis)"), None), limits


@dataclass(frozen=True)
class Ball:
    """A joint that turns about all axes, like a shoulder, within limits of swing and twist.

    Args:
        swing_rad: how far the axis may lean away from where it is at rest, in a cone; or a pair of
            angles about `across` and about ``axis × across``, the half-axes of an ellipse of
            rotation vectors. π, the default, is no limit.
        twist_rad: between which angles it may turn about the axis; without limits by default.
        axis: ``(3,)`` in the joint's frame; by default along the bone to its only child.
        across: ``(3,)`` in the joint's frame, not along the axis: what the first of a pair of
            swings turns about. What of it lies along the axis is left out.

    Raises:
        ValueError: swings outside 0 to π, a lower limit of twist above the upper one, axes without
            direction, a pair of swings without `across`.
        TypeError: a limit of twist that is no number.

    >>> from motorcade.animation.ik import Ball
    >>> shoulder = Ball(swing_rad=(1.6, 0.8), twist_rad=(-1.0, 1.0), across=[0.0, 1.0, 0.0])
    """

    swing_rad: float | tuple[float, float] = float(np.pi)
    twist_rad: tuple[float, float] = _ANY_TURN
    axis: ArrayLike | None = None
    across: ArrayLike | None = None

    def __post_init__(self) -> None:
        swings = checked_floats(self.swing_rad, "Ball(swing_rad)", ())
        if swings.shape not in ((), (2,)) or np.any(swings < 0.0) or np.any(swings > np.pi):
            raise ValueError(
                f"Ball(swing_rad): expected one angle from 0 to pi or a pair, got {self.swing_rad}"
            )
        if np.shape(self.twist_rad) != (2,):
            raise ValueError(f"Ball(twist_rad): expected two angles, got {self.twist_rad}")
        _check_interval(*self.twist_rad, "Ball(twist_rad)")
        if swings.ndim and swings[0] != swings[1] and self.across is None:
            raise ValueError("Ball(across): expected a direction with a pair of swings, got None")
        for value, name in ((self.axis, "Ball(axis)"), (self.across, "Ball(across)")):
            if value is not None:
                checked_direction(value, name)

    @property
    def limited(self) -> bool:
        """Whether there is any limit."""
        return bool(np.min(self.swing_rad) < np.pi) or self.twist_rad != _ANY_TURN

    def row(self, name: str, bone: FloatArray) -> tuple[int, FloatArray, FloatArray]:
        """Kind, axes ``(3, 3)`` and limits ``(4,)`` as the compiled solver takes them."""
        swings = np.broadcast_to(np.asarray(self.swing_rad, dtype=np.float64), (2,))
        if not self.limited:
            return _FREE_BALL, np.eye(3), np.array([np.inf, np.inf, *_ANY_TURN])
        if np.all(swings >= np.pi):
            swings = np.full(2, np.inf)
        if self.axis is None and not np.any(bone):
            raise ValueError(
                f"IkSolver(joints): expected an axis for the ball '{name}', which has no "
                "only child to point at; Ball(axis=...) gives it one"
            )
        axis = bone if self.axis is None else checked_direction(self.axis, "Ball(axis)")
        across = None if self.across is None else checked_direction(self.across, "Ball(across)")
        if across is not None and np.linalg.norm(np.cross(unit(axis), unit(across))) < 1e-6:
            raise ValueError(
                f"IkSolver(joints): expected `across` of the ball '{name}' not along its axis"
            )
        return _BALL, _frame(axis, across), np.array([*swings, *self.twist_rad])


@dataclass(frozen=True)
class Floating:
    """A joint that turns and moves freely in its parent, like the hips of a figure.

    >>> from motorcade.animation.ik import Floating
    >>> Floating()
    Floating()
    """

    def row(self, name: str, bone: FloatArray) -> tuple[int, FloatArray, FloatArray]:
        """Kind, axes ``(3, 3)`` and limits ``(4,)`` as the compiled solver takes them."""
        return _FLOATING, np.eye(3), np.array([np.inf, np.inf, *_ANY_TURN])


JointKind = Hinge | Ball | Floating


def checked_direction(value: ArrayLike, name: str) -> FloatArray:
    """A vector ``(3,)`` of any length but 0, at length 1.

    Raises ValueError: another shape, NaN or infinity, no direction.
    """
    axis = checked_floats(value, name, (3,))
    if axis.shape != (3,) or not np.any(axis):
        raise ValueError(f"{name}: expected a direction (3,), got {value!r}")
    return unit(axis / np.abs(axis).max())  # so that no square overflows, or comes to nothing


def _check_interval(low: float, high: float, name: str) -> None:
    checked_number(low, name)
    checked_number(high, name)
    if not low <= high or low == np.inf or high == -np.inf:
        raise ValueError(f"{name}: expected a lower limit and one not below it, got {low}, {high}")
    if any(np.isfinite(one) and abs(one) > _WIDEST_RAD for one in (low, high)):
        raise ValueError(
            f"{name}: expected limits within {_WIDEST_RAD:g} rad or infinite, got {low}, {high}"
        )


def _frame(axis: FloatArray, across: FloatArray | None) -> FloatArray:
    """Axis, across and aside ``(3, 3)`` by rows, orthonormal and right-handed."""
    along = unit(axis)
    side = perpendicular(along)
    if across is not None:
        side = unit(across - (across @ along) * along)
    return np.stack([along, side, np.cross(along, side)])
