"""Chains of joints brought to points, and how joints may turn.

FABRIK: each step moves one joint onto the sphere around its neighbour, where the line through both
meets it (the kernel ``reach``, generated from that meet). A joint whose bones may bend only so far
is then turned back in their common plane. Passes from the target to the base and back go on until
the end lies at the target. Where limits or a stretched chain make them creep, damped least squares
in the joints' swings go on from the best chain found (`IkSolver` does the same on skeletons).
Source: Aristidou and Lasenby, "FABRIK: a fast, iterative solver for the inverse kinematics problem"
(2011), and "Inverse kinematics solutions using conformal geometric algebra" (2011).

Limbs of two bones are solved in closed form: the middle joint lies on two spheres, around the
limb's root and around its target, hence on a circle; of that the point is taken that lies towards
the pole. The same meet of spheres stands as a CLUScript in ``docs/scripts/two_link_arm.clu``.

A joint's turn ``R`` is measured from its rest pose, in its own frame: ``parent_T_joint`` is
``rest @ R``. A ball's turn is ``R = S @ T``: a twist ``T`` about its axis first, then a swing ``S``
about an axis across it, so that twist turns the bone about itself and swing says where it points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.native import _ik
from motorcade.animation.skeleton import Skeleton, turned_joint
from motorcade.animation.vectors import length, perpendicular, shortest_turn, unit
from motorcade.ga import Motor, Rotor
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

    >>> from motorcade.animation.ik.chain import Floating
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
    laid = Motor(np.broadcast_to(local_pose.coefficients, (*batch, *size)))
    turned = Rotor.identity()
    at = world.translation_m
    for k, joint in enumerate(numbers[:-1]):
        parent = int(skeleton.parents[joint])
        # What lies between two joints of the chain has turned as the first of them did.
        above = turned @ world[..., parent].rotor if parent >= 0 else Rotor.identity()
        bone = at[..., numbers[k + 1], :] - at[..., joint, :]
        turned = shortest_turn(bone, points_m[..., k + 1, :] - points_m[..., k, :])
        laid = turned_joint(laid, joint, above.inverse() @ turned @ world[..., joint].rotor)
    return laid


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
    angles = checked_floats(bend, "max_bend_rad", ())
    if angles.ndim > 1 or (angles.ndim == 1 and angles.shape != (count - 2,)):
        raise ValueError(
            f"fabrik(max_bend_rad): expected one angle or {count - 2}, got shape {angles.shape}"
        )
    limits = np.empty(count - 1)
    limits[0], limits[1:] = swing if swings else np.pi, angles
    if np.any(limits < 0.0) or np.any(limits > np.pi):
        raise ValueError("fabrik(max_bend_rad, max_swing_rad): expected angles from 0 to pi")
    return limits


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
    >>> from motorcade.animation import Skeleton
    >>> from motorcade.animation.ik import aim
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
