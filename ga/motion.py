"""Poses with their derivatives, and what twists do: the common language of all paths; and the
simplest path, `ScrewPath`.

A twist is the velocity of a body in its own frame, ``pose' = pose · twist``: angular rate (rad/s),
velocity of its origin (m/s), and for similarities the rate of the logarithm of the scale (1/s)
after them; ``(*, 6)`` for motors, ``(*, 7)`` for similarities. Batch in front.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, IntArray, checked_floats
from motorcade.ga.trajectory import Trajectory
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.similarity import Similarity

V = TypeVar("V", Motor, Similarity)


@dataclass(frozen=True, eq=False)
class TwistSample(Generic[V]):
    """Pose, first and second derivative at the evaluated times, batch ``(*)`` in front.

    ``pose`` is ``parent_T_child``; ``body_twist`` and its derivative ``body_twist_rate`` are
    ``(*, 6)``, or ``(*, 7)`` for similarities, in the child's frame.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, TwistSample
        >>> parent_T_child = Motor.from_translation([2.0, 0.0, 0.0])
        >>> turning = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])  # 1 rad/s about the child's z
        >>> sample = TwistSample(parent_T_child, turning, np.zeros(6))
        >>> sample.pose.transform_twist(sample.body_twist)  # about the parent's origin
        array([ 0., -0.,  1.,  0., -2.,  0.])
    """

    pose: V
    body_twist: FloatArray
    body_twist_rate: FloatArray


@dataclass(frozen=True, eq=False)
class SplineSample:
    """Pose and exact derivatives at the evaluated times, batch ``(*)`` in front.

    ``pose`` is ``parent_T_child``. Rates are in the child's (body) frame, velocity and
    acceleration are of the child's origin in the parent's (world) frame, without gravity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, ScrewPath, Trajectory
        >>> world_T_body = Motor.from_euler_translation([[0, 0, 0], [0, 0, 0.5]], np.zeros((2, 3)))
        >>> path = ScrewPath(Trajectory(np.array([0, 1_000_000_000]), world_T_body))
        >>> path.evaluate(0.5).body_angular_rate_rad_s.round(6) + 0.0
        array([0. , 0. , 0.5])
    """

    pose: Motor
    body_angular_rate_rad_s: FloatArray
    body_angular_acceleration_rad_s2: FloatArray
    world_velocity_m_s: FloatArray
    world_acceleration_m_s2: FloatArray


def sampled_motion(sample: TwistSample[Motor]) -> SplineSample:
    """The same derivatives as an inertial sensor or a plot wants them."""
    rotation, twist, rate = sample.pose.rotor, sample.body_twist, sample.body_twist_rate
    body_acceleration = rate[..., 3:] + cross(twist[..., :3], twist[..., 3:])
    return SplineSample(
        sample.pose, twist[..., :3], rate[..., :3],
        rotation.apply(twist[..., 3:]), rotation.apply(body_acceleration),
    )  # fmt: skip


def twist_bracket(a: FloatArray, b: FloatArray) -> FloatArray:
    """Commutator of twists, ``(*, 6)`` or ``(*, 7)``."""
    bracket: FloatArray = np.zeros(np.broadcast_shapes(a.shape, b.shape))
    bracket[..., :3] = cross(a[..., :3], b[..., :3])
    bracket[..., 3:6] = cross(a[..., :3], b[..., 3:6])
    bracket[..., 3:6] += cross(a[..., 3:6], b[..., :3])
    if a.shape[-1] == 7:
        bracket[..., 3:6] += a[..., 6:] * b[..., 3:6] - b[..., 6:] * a[..., 3:6]
    return bracket


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products ``(*, 3)``: the numbers of `numpy.cross`, in a fifth of its time."""
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        product[..., i] = a[..., j] * b[..., k]
        product[..., i] -= a[..., k] * b[..., j]
    return product


def check_within(path: str, time_s: FloatArray, start_ns: int, duration_s: float) -> None:
    """Refuse times ``(*)`` in seconds that lie outside a path's span, a nanosecond aside.

    Raises ValueError: such times.
    """
    slack = 1e-9 * max(1.0, duration_s)
    outside = (time_s < -slack) | (time_s > duration_s + slack)
    if np.any(outside):
        raise ValueError(
            f"{path}: expected times in [0, {duration_s:.9f}] s after {start_ns} ns, "
            f"got {float(np.asarray(time_s)[outside][0]):.9f} s"
        )


@dataclass(frozen=True, eq=False)
class ScrewPath:
    """Piecewise screw motion through the poses of a trajectory, with the splines' interface.

    Nothing moves more evenly between two poses; but at each pose the twist jumps, so it has no
    acceleration there. Sensors want `CumulativeBSpline`.

    Args:
        trajectory: two poses or more; each screw turns by at most π.

    Raises:
        ValueError: a single pose.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, ScrewPath, Trajectory
        >>> poses = Motor.from_translation([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
        >>> path = ScrewPath(Trajectory(np.array([0, 500_000_000]), poses))
        >>> path.evaluate(0.25).world_velocity_m_s
        array([4., 0., 0.])
    """

    trajectory: Trajectory

    def __post_init__(self) -> None:
        if len(self.trajectory) < 2:
            raise ValueError("ScrewPath.trajectory: expected two poses or more, got 1")

    @property
    def start_ns(self) -> int:
        """Stamp of the first pose."""
        return int(self.trajectory.time_ns[0])

    @property
    def duration_s(self) -> float:
        """Seconds from the first pose to the last."""
        return self.trajectory.duration_s

    @property
    def parent(self) -> str:
        """Name of the frame that poses map to."""
        return self.trajectory.parent

    @property
    def child(self) -> str:
        """Name of the frame that moves."""
        return self.trajectory.child

    def at(self, time_ns: ArrayLike) -> Motor:
        """Poses at stamps ``(*)`` in nanoseconds; see `Trajectory.at`."""
        return self.trajectory.motors_at(time_ns)

    def twists(self, time_s: ArrayLike) -> TwistSample[Motor]:
        """Poses and body twists at times ``(*)`` in seconds after the first pose.

        At a pose the twist is that of the screw that follows, at the last pose of the one before;
        the twist's derivative is 0 wherever it exists.

        Raises:
            ValueError: NaN or infinity, or times outside the span.
        """
        before, fraction = self._locate(checked_floats(time_s, "ScrewPath.twists(time_s)", ()))
        poses, stamps = self.trajectory.motors, self.trajectory.time_ns
        screws = poses[:-1].local(poses[1:])
        screw = screws[before]
        pose = poses[before].retract(fraction[..., None] * screw)
        twist = screw / (np.diff(stamps) * 1e-9)[before][..., None]
        return TwistSample(pose, twist, np.zeros_like(twist))

    def evaluate(self, time_s: ArrayLike) -> SplineSample:
        """Poses and derivatives at times ``(*)`` in seconds after the first pose; see `twists`.

        Raises:
            ValueError: NaN or infinity, or times outside the span.
        """
        return sampled_motion(self.twists(time_s))

    def _locate(self, time_s: FloatArray) -> tuple[IntArray, FloatArray]:
        """The pose before each time, and the fraction of the way to the next."""
        check_within("ScrewPath", time_s, self.start_ns, self.duration_s)
        knots = self.trajectory.time_s
        before = np.clip(np.searchsorted(knots, time_s, side="right") - 1, 0, len(knots) - 2)
        fraction = (time_s - knots[before]) / (knots[before + 1] - knots[before])
        return before, np.clip(fraction, 0.0, 1.0)
