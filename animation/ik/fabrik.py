"""FABRIK: a chain of points brought to a target by passes up and down, in CGA; compiled.

Each step moves one joint onto the sphere around its neighbour, where the line through both meets
it (the kernel ``reach``, generated from that meet). A joint whose bones may bend only so far is
then turned back in their common plane. Passes from the target to the base and back go on until the
end lies at the target. Where limits or a stretched chain make them creep, damped least squares in
the joints' swings go on from the best chain found (`IkSolver` does the same on skeletons).
Source: Aristidou and Lasenby, "FABRIK: a fast, iterative solver for the inverse kinematics problem"
(2011), and "Inverse kinematics solutions using conformal geometric algebra" (2011).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.native import _ik
from motorcade.animation.vectors import unit
from motorcade.ga.arrays import FloatArray, checked_floats


@dataclass(frozen=True, eq=False)
class Reached:
    """A solved chain.

    Fields:
        points: ``(*, N, 3)`` joints, base first; bones keep their lengths.
        error_m: ``(*)`` distance of the end from the target.
        rounds: the most rounds that any of the chains took.

    >>> from motorcade.animation.ik import fabrik
    >>> reached = fabrik([[0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]], [0, 3.0, 0])  # 1 m out of reach
    >>> float(reached.error_m.round(3))
    1.0
    """

    points: FloatArray
    error_m: FloatArray
    rounds: int


def fabrik(
    points: ArrayLike,
    target: ArrayLike,
    max_bend_rad: ArrayLike = np.pi,
    *,
    base_direction: ArrayLike | None = None,
    max_swing_rad: float = np.pi,
    tolerance: float = 1e-5,
) -> Reached:
    """Bring the end of chains to targets; the base stays.

    A target out of reach has the chain stretched straight towards it, as far as limits let it.

    Args:
        points: ``(*, N, 3)`` joints before, base first, metres; N at least 2. Bones of no length
            are kept so.
        target: ``(*, 3)``.
        max_bend_rad: the angle that each inner joint's two bones may make at most, one number or
            ``(N - 2,)``.
        base_direction: ``(*, 3)`` direction that the first bone may leave by at most
            `max_swing_rad`; none by default.
        max_swing_rad: see there.
        tolerance: of the end, as a share of the chain's length.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity, a chain of no length, limits outside
            0 to π.

    >>> from motorcade.animation.ik import fabrik
    >>> reached = fabrik([[0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]], [0, 1.0, 0])
    >>> reached.points[-1].round(3), bool(reached.error_m < 1e-4)
    (array([0., 1., 0.]), True)
    """
    start, goal = checked_floats(points, "points", (3,)), checked_floats(target, "target", (3,))
    if start.ndim < 2 or start.shape[-2] < 2:
        raise ValueError(f"fabrik(points): expected shape (*, N, 3), N >= 2, got {start.shape}")
    count = start.shape[-2]
    limits = _limits(max_bend_rad, max_swing_rad, count, base_direction is not None)
    along = np.zeros(3) if base_direction is None else base_direction
    ahead = unit(checked_floats(along, "base_direction", (3,)))
    batch = np.broadcast_shapes(start.shape[:-2], goal.shape[:-1], ahead.shape[:-1])
    chains = np.array(np.broadcast_to(start, (*batch, count, 3)), dtype=np.float64, order="C")
    error_m = np.empty(batch)
    rounds = _ik.fabrik(
        chains.reshape(-1, count, 3),
        np.ascontiguousarray(np.broadcast_to(goal, (*batch, 3)), np.float64).reshape(-1, 3),
        np.ascontiguousarray(np.broadcast_to(ahead, (*batch, 3)), np.float64).reshape(-1, 3),
        limits,
        tolerance,
        error_m.reshape(-1),
    )
    return Reached(chains, error_m, rounds)


def _limits(bend: ArrayLike, swing: float, count: int, swings: bool) -> FloatArray:
    """The largest angle at each joint ``(N - 1,)``: of the first to the base's direction."""
    given = checked_floats(bend, "max_bend_rad", ())
    if given.ndim > 1 or (given.ndim == 1 and given.shape != (count - 2,)):
        raise ValueError(
            f"fabrik(max_bend_rad): expected one angle or {count - 2}, got shape {given.shape}"
        )
    limits = np.empty(count - 1)
    limits[0], limits[1:] = swing if swings else np.pi, given
    if np.any(limits < 0.0) or np.any(limits > np.pi):
        raise ValueError("fabrik(max_bend_rad, max_swing_rad): expected angles from 0 to pi")
    return limits
