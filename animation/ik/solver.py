"""Inverse kinematics of a skeleton: joints with limits brought to goals, several at once; compiled.

Damped least squares (Levenberg and Marquardt) in the joints' own coordinates: angles of hinges,
swing and twist of balls. Directions that press on a limit are left out of a step, and a step is
brought back within the limits before it is judged, so that limits hold in every result, also where
goals cannot be reached. Where goals stay unreached, other poses are tried.
Source: Kanzow, Yamashita and Fukushima, "Levenberg-Marquardt methods with strong local convergence
properties for solving nonlinear equations with convex constraints" (2004).

Goals of inverse kinematics: where joints shall be, how turned, and what they look at.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.ik.chain import Hinge, JointKind, checked_direction
from motorcade.animation.native import _ik
from motorcade.animation.skeleton import Skeleton, at_or_below
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import (
    FloatArray,
    IntArray,
    checked_floats,
    checked_number,
    checked_positive,
)

# A limit holds a goal where yielding by a radian would take off so much of what is left, in
# lengths of the figure's longest chain or in radians.
_HOLDS = 1e-3
# Who asks for more has mistaken the knob.
MOST_RESTARTS = 1000


@dataclass(frozen=True)
class HeldLimit:
    """A limit that keeps a goal from being reached.

    Fields:
        joint: its name.
        limit: "swing", "twist" or "hinge".
        end: "high" or "low" of twists and hinges; "edge" of swings.
        share: of what the goal lacks, how much one radian more would take off, in lengths of the
            figure's longest chain or in radians; what holds most comes first.
    """

    joint: str
    limit: str
    end: str
    share: float


@dataclass(frozen=True, eq=False)
class _Found:
    """What the compiled solver leaves, a row for each place and for each turn that is asked for."""

    goals: tuple[Goal, ...]
    owners: IntArray  # (G, 2): rows of each goal's place and turn, -1 where it has none
    residuals: FloatArray  # (*, R, 3)
    presses: FloatArray  # (*, R, D, 2)
    turning: tuple[tuple[str, bool], ...]  # names of the D joints, and whether they are hinges
    size_m: float
    tolerance: float

    @cached_property
    def left(self) -> FloatArray:
        """``(*, R)`` in metres or radians."""
        return np.asarray(np.linalg.norm(self.residuals, axis=-1))

    @cached_property
    def late(self) -> FloatArray:
        """``(*, R)``, 1 where a row is beyond the tolerance."""
        allowed = np.full(self.left.shape[-1], self.tolerance)
        allowed[self.owners[self.owners[:, 0] >= 0, 0]] *= self.size_m
        return np.where(self.left <= allowed * (1.0 + 1e-9), 0.0, 1.0)

    def by_goal(self, rows: FloatArray, which: int) -> FloatArray:
        """Of ``(*, R)`` those of the goals' places (0) or turns (1), ``(*, G)``; 0 without one."""
        owners = self.owners[:, which]
        return np.where(owners >= 0, rows[..., np.maximum(owners, 0)], 0.0)

    def presses_on(self, goal: int, at: tuple[int, ...]) -> FloatArray:
        """How hard what a goal lacks presses on swing and turn, ``(D, 2)``, as shares of it."""
        presses = np.zeros(self.presses.shape[-2:])
        for which, unit in ((0, self.size_m), (1, 1.0)):
            row = int(self.owners[goal, which])
            if row >= 0 and self.late[at][row] > 0.0:
                lacks = self.left[at][row] / unit * self.goals[goal].weight ** 2
                presses += self.presses[at][row] / lacks
        return presses


@dataclass(frozen=True, eq=False)
class IkSolution:
    """A pose found for G goals.

    Fields:
        local_pose: Motor ``(*, J)``; within all limits.
        rounds: steps that all poses took together.

    >>> import numpy as np
    >>> from motorcade.animation import Skeleton
    >>> from motorcade.animation.ik import Hinge, IkSolver, PoseGoal
    >>> from motorcade.ga import Motor
    >>> parent_T_joint = Motor.from_translation([[0, 0, 1.0], [0, 0, -0.5], [0, 0, -0.5]])
    >>> leg = Skeleton(("hip", "knee", "ankle"), np.array([-1, 0, 1]), parent_T_joint)
    >>> solver = IkSolver(leg, {"knee": Hinge([0, 1.0, 0], 0.0, 1.0)})
    >>> solved = solver.solve(leg.rest, [PoseGoal("ankle", [-0.5, 0.0, 0.5])])
    >>> print(solved.summary())  # the knee would have to bend by 90 degrees
    ankle: 0.282 m off, held by knee (hinge, high)
    """

    local_pose: Motor
    rounds: int
    _found: _Found = field(repr=False)

    @cached_property
    def error_m(self) -> FloatArray:
        """``(*, G)`` how far each goal's point is from its place; 0 without one."""
        return self._found.by_goal(self._found.left, 0)

    @cached_property
    def error_rad(self) -> FloatArray:
        """``(*, G)`` by how much each goal's turn or direction is off; 0 without one."""
        return self._found.by_goal(self._found.left, 1)

    @cached_property
    def reached(self) -> NDArray[np.bool_]:
        """``(*, G)``, whether each goal is within the tolerance."""
        late = self._found.late
        by_pose: NDArray[np.bool_] = (
            self._found.by_goal(late, 0) + self._found.by_goal(late, 1) == 0
        )
        return by_pose

    def held_by(self, goal: int, at: tuple[int, ...] = ()) -> tuple[HeldLimit, ...]:
        """Limits that keep a goal from being reached; none where it is, or where bones are too
        short.

        Args:
            goal: its number.
            at: which pose of a batch.

        Raises:
            ValueError: no such goal, or no such pose of the batch.
        """
        missed = self._missed_goals(at)
        if not 0 <= goal < len(self._found.goals):
            raise ValueError(
                f"held_by(goal): expected 0 to {len(self._found.goals) - 1}, got {goal}"
            )
        if missed[goal]:
            return ()
        limits = []
        for (joint, hinge), (swing, turn) in zip(
            self._found.turning, self._found.presses_on(goal, at), strict=True
        ):
            if swing > _HOLDS:
                limits.append(HeldLimit(joint, "swing", "edge", float(swing)))
            if abs(turn) > _HOLDS:
                end = "high" if turn > 0.0 else "low"
                kind = "hinge" if hinge else "twist"
                limits.append(HeldLimit(joint, kind, end, float(abs(turn))))
        return tuple(sorted(limits, key=lambda limit: -limit.share))

    def summary(self, at: tuple[int, ...] = ()) -> str:
        """A line for each goal: reached, or how much it lacks and what holds it.

        Args:
            at: which pose of a batch.

        Raises:
            ValueError: no such pose of the batch.
        """
        lines, missed = [], self._missed_goals(at)
        for k, goal in enumerate(self._found.goals):
            if missed[k]:
                lines.append(f"{goal.joint}: reached")
                continue
            lacks = [f"{self.error_m[at][k]:.3f} m"] if self.error_m[at][k] > 0.0 else []
            if self.error_rad[at][k] > 0.0:
                lacks.append(f"{np.degrees(self.error_rad[at][k]):.1f} deg")
            held = [f"{one.joint} ({one.limit}, {one.end})" for one in self.held_by(k, at)]
            why = (
                "held by " + ", ".join(held)
                if held
                else "no limit holds it: out of reach, or no way found"
            )
            lines.append(f"{goal.joint}: {' and '.join(lacks)} off, {why}")
        return "\n".join(lines)

    def _missed_goals(self, at: tuple[int, ...]) -> NDArray[np.bool_]:
        """``(G,)``, which goals one pose of a batch reaches."""
        batch = self.reached.shape[:-1]
        inside = len(at) == len(batch) and all(
            -most <= k < most for k, most in zip(at, batch, strict=True)
        )
        if not inside:
            raise ValueError(f"IkSolution(at): expected a place in a batch {batch}, got {at}")
        return np.asarray(self.reached[at])


class IkSolver:
    """A skeleton and the joints of it that may turn. One may serve several threads.

    Args:
        skeleton: with J joints.
        joints: how those turn that may, by name; all others keep their local poses.

    Raises:
        ValueError: no joint, or one that the skeleton lacks; a ball with limits that needs an axis.
        TypeError: no mapping, or one to something else.

    A figure of two legs whose feet stay where they are while its hips sink:

    >>> import numpy as np
    >>> from motorcade.animation import Skeleton
    >>> from motorcade.animation.ik import Ball, Hinge, IkSolver, PoseGoal
    >>> from motorcade.ga import Motor
    >>> names = ("hips", "thigh_l", "calf_l", "foot_l", "thigh_r", "calf_r", "foot_r")
    >>> shifts_m = [[0, 0, 0.9], [0, 0.1, 0], [0, 0, -0.45], [0, 0, -0.45]]
    >>> shifts_m += [[0, -0.1, 0], [0, 0, -0.45], [0, 0, -0.45]]
    >>> figure = Skeleton(
    ...     names, np.array([-1, 0, 1, 2, 0, 4, 5]), Motor.from_translation(shifts_m)
    ... )
    >>> thigh, knee, ankle = Ball(1.8, (-0.6, 0.6)), Hinge([0, 1.0, 0], 0.0, 2.5), Ball()
    >>> solver = IkSolver(figure, {
    ...     "thigh_l": thigh, "calf_l": knee, "foot_l": ankle,
    ...     "thigh_r": thigh, "calf_r": knee, "foot_r": ankle,
    ... })
    >>> feet = [PoseGoal.anchor(figure, figure.rest, name) for name in ("foot_l", "foot_r")]
    >>> sunk = figure.rest.coefficients.copy()
    >>> sunk[0] = Motor.from_translation([0, 0, 0.75]).coefficients
    >>> solved = solver.solve(Motor(sunk), feet)
    >>> solved.reached
    array([ True,  True])
    >>> figure.world(solved.local_pose).translation_m[3].round(6) + 0.0
    array([0. , 0.1, 0. ])
    """

    def __init__(self, skeleton: Skeleton, joints: Mapping[str, JointKind]) -> None:
        if not isinstance(joints, Mapping):
            raise TypeError(
                f"IkSolver(joints): expected a mapping by name, got {type(joints).__name__}"
            )
        if not joints:
            raise ValueError("IkSolver(joints): expected one or more that may turn, got none")
        self.skeleton = skeleton
        numbers = sorted(skeleton.index(name) for name in joints)
        names = [skeleton.names[k] for k in numbers]
        for name in names:
            if not isinstance(joints[name], JointKind):
                raise TypeError(
                    f"IkSolver(joints): expected a Hinge, Ball or Floating for '{name}', got "
                    f"{joints[name]!r}"
                )
        rows = [joints[name].row(name, _bone(skeleton, skeleton.index(name))) for name in names]
        self._turning = tuple((name, isinstance(joints[name], Hinge)) for name in names)
        self._solver = _ik.Solver(
            np.ascontiguousarray(skeleton.parents),
            np.ascontiguousarray(skeleton.rest.coefficients, dtype=np.float64),
            np.array([kind for kind, *_ in rows], dtype=np.int64),
            np.array(numbers, dtype=np.int64),
            np.stack([axes for _, axes, _ in rows]),
            np.stack([limits for *_, limits in rows]),
        )
        self._led = at_or_below(skeleton.parents, numbers)

    @property
    def size_m(self) -> float:
        """The figure's longest chain of bones, which counts as much as a radian."""
        return self._solver.size_m

    def solve(
        self,
        local_pose: Motor,
        goals: Sequence[Goal],
        *,
        restarts: int = 4,
        tolerance: float = 1e-6,
    ) -> IkSolution:
        """A pose near a given one that brings joints to goals, as nearly as limits let it.

        The same input gives the same bytes. To follow a target that moves, start each frame from
        the pose of the last and set `restarts` to 0: then the pose goes on without jumps, where
        other poses are tried it may leap to a better one.

        Args:
            local_pose: Motor ``(*, J)`` from which the search starts; it is first brought within
                the limits.
            goals: one or more, with targets ``(*)`` that broadcast with the poses.
            restarts: how many other poses are tried where goals stay unreached.
            tolerance: what counts as reached: a share of `size_m`, and radians.

        Raises:
            ValueError: no goal, one for a joint that no joint that may turn leads to, shapes that
                do not fit, bones whose squares overflow, a number of restarts outside 0 to 1000, a
                tolerance that is not above 0.
            TypeError: a pose, goals, or numbers of another kind.

        It breaks down, as all local searches do, where the way to a goal leads through poses that
        are worse: then it says that the goal is not reached.
        """
        if not isinstance(local_pose, Motor):
            raise TypeError(f"solve(local_pose): expected a Motor, got {type(local_pose).__name__}")
        if local_pose.shape[-1:] != (len(self.skeleton),):
            raise ValueError(
                f"solve(local_pose): expected shape (*, {len(self.skeleton)}), got "
                f"{local_pose.shape}"
            )
        whole: object = restarts
        if not isinstance(whole, Integral):
            raise TypeError(f"solve(restarts): expected a whole number, got {restarts!r}")
        if not 0 <= restarts <= MOST_RESTARTS:
            raise ValueError(f"solve(restarts): expected 0 to {MOST_RESTARTS}, got {restarts}")
        checked_positive(tolerance, "solve(tolerance)")
        aims, marks, targets, owners = self._rows(goals)
        batch = np.broadcast_shapes(local_pose.shape[:-1], *(one.shape[:-1] for one in targets))
        wanted = np.empty((*batch, len(aims), 7))
        for k, target in enumerate(targets):
            wanted[..., k, :] = target
        count, rows, size = int(np.prod(batch)), len(aims), len(self.skeleton)
        start = np.broadcast_to(local_pose.coefficients, (*batch, size, 8))
        poses, residuals = np.empty((count, size, 8)), np.empty((count, rows, 3))
        presses = np.empty((count, rows, len(self._turning), 2))
        rounds = self._solver.solve(
            np.ascontiguousarray(start, dtype=np.float64).reshape(-1, size, 8),
            aims, marks, wanted.reshape(-1, rows, 7), tolerance, restarts,
            poses, residuals, presses,
        )  # fmt: skip
        if not np.isfinite(residuals).all():
            raise ValueError("solve: expected bones and a pose within 1e9 m, got longer ones")
        outcome = _Found(
            tuple(goals),
            owners,
            residuals.reshape(*batch, rows, 3),
            presses.reshape(*batch, *presses.shape[1:]),
            self._turning,
            self.size_m,
            tolerance,
        )
        pose = Motor._trusted(poses.reshape(*batch, size, 8))
        return IkSolution(pose, rounds, outcome)

    def _rows(
        self, goals: Sequence[Goal]
    ) -> tuple[IntArray, FloatArray, list[FloatArray], IntArray]:
        """What the compiled solver takes, and which of its rows are each goal's."""
        if not isinstance(goals, Sequence) or not all(isinstance(one, Goal) for one in goals):
            raise TypeError(f"solve(goals): expected a list of PoseGoal and LookAt, got {goals!r}")
        if not goals:
            raise ValueError("solve(goals): expected one or more, got none")
        aims: list[tuple[int, int]] = []
        marks: list[Any] = []
        targets = []
        owners = np.full((len(goals), 2), -1)
        for number, goal in enumerate(goals):
            joint = self.skeleton.index(goal.joint)
            if not self._led[joint]:
                raise ValueError(
                    f"solve(goals): expected '{goal.joint}' to be, or to hang on, a joint that may "
                    f"turn; those are {[name for name, _ in self._turning]}"
                )
            for aim, point, axis, target in goal.rows():
                owners[number, 0 if aim == 0 else 1] = len(aims)
                aims.append((aim, joint))
                marks.append([*point, *axis, goal.weight])
                targets.append(target)
        return np.array(aims, dtype=np.int64), np.array(marks), targets, owners


def _bone(skeleton: Skeleton, joint: int) -> FloatArray:
    """From a joint to its only child, in its own frame; zero where it has none or several."""
    children = np.flatnonzero(skeleton.parents == joint)
    if len(children) != 1:
        return np.zeros(3)
    return np.asarray(skeleton.rest[int(children[0])].translation_m, dtype=np.float64)


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
        targets = []
        if self.position_m is not None:
            place = _near(self.position_m, "PoseGoal(position_m)")
            targets.append((_POSITION, point, np.zeros(3), _target(place, _NO_TURN)))
        if self.rotor is not None:
            target = _target(np.zeros(3), self.rotor.coefficients.astype(np.float64))
            targets.append((_ORIENTATION, point, np.zeros(3), target))
        return targets


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
    vector = _near(value, name)
    if vector.shape != (3,):
        raise ValueError(f"{name}: expected shape (3,), got {vector.shape}")
    return vector


def _near(value: ArrayLike, name: str) -> FloatArray:
    vector = checked_floats(value, name, (3,))
    if np.any(np.abs(vector) > _FARTHEST_M):
        raise ValueError(
            f"{name}: expected lengths within {_FARTHEST_M:g} m, got {np.abs(vector).max():g}"
        )
    return vector


def _target(point: FloatArray, rotor: FloatArray) -> FloatArray:
    target = np.empty((*np.broadcast_shapes(point.shape[:-1], rotor.shape[:-1]), 7))
    target[..., :3], target[..., 3:] = point, rotor
    return target


def _check_weight(weight: float, name: str) -> None:
    if not _LIGHTEST <= checked_number(weight, name) <= _HEAVIEST:
        raise ValueError(
            f"{name}: expected a number from {_LIGHTEST:g} to {_HEAVIEST:g}, got {weight}"
        )
