"""The screw-linear path: from pose to pose at constant twist, with the splines' interface.

It passes through every pose, and nothing moves more evenly between two; but at each pose the twist
jumps, so it has no acceleration there. Sensors want `CumulativeBSpline`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, IntArray, checked_floats
from motorcade.ga.motion import SplineSample, TwistSample, sampled_motion
from motorcade.ga.trajectory import Trajectory
from motorcade.ga.versors.motor import Motor

__all__ = ["ScrewPath"]


@dataclass(frozen=True, eq=False)
class ScrewPath:
    """Piecewise screw motion through the poses of a trajectory.

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
        slack = 1e-9 * max(1.0, self.duration_s)
        outside = (time_s < -slack) | (time_s > self.duration_s + slack)
        if np.any(outside):
            raise ValueError(
                f"ScrewPath: expected times in [0, {self.duration_s:.9f}] s after "
                f"{self.start_ns} ns, got {float(np.asarray(time_s)[outside][0]):.9f} s"
            )
        knots = self.trajectory.time_s
        before = np.clip(np.searchsorted(knots, time_s, side="right") - 1, 0, len(knots) - 2)
        fraction = (time_s - knots[before]) / (knots[before + 1] - knots[before])
        return before, np.clip(fraction, 0.0, 1.0)
