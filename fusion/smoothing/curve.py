"""The curve through smoothed poses: what a path is between its stamps, and how fast it moves.

The rates at the stamps are those of a natural cubic spline, so that the acceleration is continuous
(C. de Boor, A practical guide to splines, 1978, ch. 4); between them the pose is ``X exp(p)`` with
the cubic twist ``p`` that meets the next pose and both rates. Of poses smoothed under a constant
velocity that white acceleration changes this is the most probable motion between them (T. D.
Barfoot, State Estimation for Robotics, 2nd ed., 2024, ch. 11); of others it is the curve of least
acceleration.

The spline runs on the sum of the steps from pose to pose. A step is the integral of the body's
rate but for what turns do to each other, ``∫ω = ξ - h²/12 [ω₀, ω₁]`` (W. Magnus, On the exponential
solution of differential equations for a linear operator, 1954), which is put right in rounds.

Steps of more than three median ones are gaps: across them, and across jumps of level, the pose
follows the screw, since nothing tells how the motion curved; the rates beside them are one-sided.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.motion import TwistSample, twist_bracket
from motorcade.ga.stamps import checked_stamps, near_steps

# Each takes the error of the one before by the square of the turn in a step: 1e-2 at 10° or less.
_ROUNDS = 4
# Seconds by which a Jacobian is told ahead and back: errors of rounding and of the step are alike.
_STEP = 1e-5

_Steps = tuple[FloatArray, FloatArray, NDArray[np.bool_]]


@dataclass(frozen=True, eq=False)
class PathCurve:
    """The curve through the poses of a trajectory; see the module.

    Args:
        trajectory: two poses or more.
        jumps: rows before which the path jumps.

    Raises:
        ValueError: a single pose, or rows that no step leads to.

    It breaks down where a step turns by 180° or more: the shorter way is taken. At 60° a step rates
    are off by some thousandths, and the acceleration leaps at the stamps by some per cent.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import PathCurve
        >>> motion = screw()
        >>> curve = PathCurve(motion.sampled(rate_hz=20.0, duration_s=2.0))  # world_T_camera
        >>> found = curve.twists(np.array([510_000_000, 1_234_567_890]))
        >>> true = motion.at([0.51, 1.23456789])
        >>> bool(abs(found.body_twist - true.body_twist).max() < 1e-4)  # rad/s, then m/s
        True
    """

    trajectory: Trajectory
    jumps: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __post_init__(self) -> None:
        count = len(self.trajectory)
        if count < 2:
            raise ValueError("PathCurve.trajectory: expected two poses or more, got 1")
        if np.any((self.jumps < 1) | (self.jumps >= count)):
            raise ValueError(
                f"PathCurve.jumps: expected rows from 1 to {count - 1}, got {self.jumps}"
            )

    @cached_property
    def body_twist(self) -> FloatArray:
        """Angular rate (rad/s) and velocity (m/s) in the moving frame ``(N, 6)`` at the stamps.

        Of similarities the rate of the logarithm of the scale stands behind them. Poses between two
        gaps have that of the screw to the nearer neighbour.
        """
        screws, step_s, near = self._steps
        weights = np.zeros(len(step_s) + 2)
        weights[1:-1][near] = 1.0 / step_s[near]
        diagonal = 2.0 * (weights[:-1] + weights[1:])
        alone = diagonal == 0.0
        diagonal[alone] = 1.0
        integrals, twist = screws, np.zeros((len(self.trajectory), screws.shape[1]))
        for _ in range(_ROUNDS):
            pull = np.zeros((len(weights), screws.shape[1]))
            pull[1:-1] = 3.0 * weights[1:-1, None] ** 2 * integrals
            twist = _tridiagonal(weights[:-1], diagonal, weights[1:], pull[:-1] + pull[1:])
            turned = step_s[:, None] ** 2 / 12.0 * twist_bracket(twist[:-1], twist[1:])
            integrals = screws - np.where(near[:, None], turned, 0.0)
        twist = _beside_gaps(twist, self._steps) if np.any(alone) else twist
        twist.setflags(write=False)
        return twist

    def at(self, time_ns: ArrayLike) -> Motor | Similarity:
        """Poses at stamps ``(*)`` in nanoseconds.

        Raises:
            ValueError: stamps that are no integers, or outside the span of the trajectory.
        """
        pose: Motor | Similarity = self.twists(time_ns).pose
        return pose

    def twists(self, time_ns: ArrayLike) -> TwistSample[Any]:
        """Poses, body twists and their derivatives at stamps ``(*)`` in nanoseconds.

        Raises:
            ValueError: as `at`.
        """
        stamps = checked_stamps(time_ns, "PathCurve.twists(time_ns)")
        own, poses = self.trajectory.time_ns, self.trajectory.poses
        outside = (stamps < own[0]) | (stamps > own[-1])
        if np.any(outside):
            raise ValueError(
                f"PathCurve.twists(time_ns): expected stamps in [{own[0]}, {own[-1]}], got "
                f"{int(stamps[outside][0])} and {int(np.count_nonzero(outside)) - 1} more outside"
            )
        screws, step_s, _ = self._steps
        before = np.clip(np.searchsorted(own, stamps, side="right") - 1, 0, len(own) - 2)
        h = step_s[before][..., None]
        u = (1e-9 * (stamps - own[before]))[..., None] / h
        screw = screws[before]
        start, end = (h * slope[before] for slope in self._slopes)
        p = u * (u * (screw * (3.0 - 2.0 * u) - (1.0 - u) * end) + (1.0 - u) ** 2 * start)
        slope = (
            6.0 * u * (1.0 - u) * screw
            + (1.0 - u) * (1.0 - 3.0 * u) * start
            + u * (3.0 * u - 2.0) * end
        ) / h
        bend = ((6.0 - 12.0 * u) * screw + (6.0 * u - 4.0) * start + (6.0 * u - 2.0) * end) / h**2
        kind = type(poses)
        twist = (kind.right_jacobian(p) @ slope[..., None])[..., 0]
        rate = (kind.right_jacobian(p) @ bend[..., None])[..., 0]
        # How the Jacobian changes on the way, by differences.
        later, earlier = (kind.right_jacobian(p + ahead * slope) for ahead in (_STEP, -_STEP))
        rate += ((later - earlier) @ slope[..., None])[..., 0] / (2.0 * _STEP)
        return TwistSample(poses[before].retract(p), twist, rate)

    @cached_property
    def _steps(self) -> _Steps:
        """Screws ``(N - 1, d)`` from pose to pose, seconds that they take, which are no gaps."""
        poses: Any = self.trajectory.poses
        steps = np.diff(self.trajectory.time_ns)
        near = near_steps(steps)
        near[self.jumps - 1] = False
        return poses[:-1].local(poses[1:]), 1e-9 * steps, near

    @cached_property
    def _slopes(self) -> tuple[FloatArray, FloatArray]:
        """How the cubic twists leave a pose and meet the next, ``(N - 1, d)`` per second each."""
        screws, step_s, near = self._steps
        even, gap = screws / step_s[:, None], ~near[:, None]
        back = type(self.trajectory.poses).right_jacobian_inverse(screws)
        met = (back @ self.body_twist[1:, :, None])[..., 0]
        return np.where(gap, even, self.body_twist[:-1]), np.where(gap, even, met)


def _beside_gaps(twist: FloatArray, steps: _Steps) -> FloatArray:
    """Of poses between two gaps the twist of the screw to the nearer neighbour."""
    screws, step_s, near = steps
    padded = np.concatenate([[False], near, [False]])
    for at in np.flatnonzero(~(padded[:-1] | padded[1:])):
        beside = [one for one in (at - 1, at) if 0 <= one < len(step_s)]
        nearer = min(beside, key=lambda step: step_s[step])
        twist[at] = screws[nearer] / step_s[nearer]
    return twist


def _tridiagonal(
    below: FloatArray, diagonal: FloatArray, above: FloatArray, right: FloatArray
) -> FloatArray:
    """Solve for ``(N, d)``, diagonals ``(N,)``, by cyclic reduction: every other row goes, as often
    as it takes. `below[0]` and `above[-1]` are 0, and the diagonal outweighs the others.
    """
    count = len(diagonal)
    if count == 1:
        return np.asarray(right / diagonal[:, None], dtype=np.float64)
    if count % 2 == 0:
        below, above = np.append(below, 0.0), np.append(above, 0.0)
        diagonal = np.append(diagonal, 1.0)
        right = np.concatenate([right, np.zeros((1, right.shape[1]))])
    even, odd = slice(0, None, 2), slice(1, None, 2)
    down, up = -below[odd] / diagonal[:-1:2], -above[odd] / diagonal[2::2]
    kept = right[odd] + down[:, None] * right[:-1:2] + up[:, None] * right[2::2]
    middle = diagonal[odd] + down * above[:-1:2] + up * below[2::2]
    solution = np.zeros(right.shape)
    solution[odd] = _tridiagonal(down * below[:-1:2], middle, up * above[2::2], kept)
    rest = right[even].copy()
    rest[1:] -= below[2::2, None] * solution[odd]
    rest[:-1] -= above[:-1:2, None] * solution[odd]
    solution[even] = rest / diagonal[even, None]
    return solution[:count]
