"""Paths in continuous time: a pose and its exact derivatives at any moment of a span.

A path is a spline fitted to poses or an analytic motion; the simulated sensor rides on it. All is
in twists of the moving frame, so a lever arm is one adjoint: the sensor's twist is that of the
frame it is bolted to, seen from the sensor.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from motorcade.fusion.motions import Motion
from motorcade.ga import Motor, Trajectory, TwistSample
from motorcade.ga.arrays import FloatArray, checked_positive
from motorcade.ga.splines import CumulativeBSpline

__all__ = ["ContinuousPath"]


@dataclass(frozen=True, eq=False)
class ContinuousPath:
    """A moving frame over a span of time.

    Args:
        start_ns: stamp at which the span begins.
        duration_s: its length, above 0.
        twists: from seconds after the start ``(*)`` to pose, body twist and its derivative.
        parent: name of the frame that poses map to.
        child: name of the frame that moves.

    Raises:
        ValueError: a duration that is not above 0.

    Examples:
        >>> from motorcade.fusion import ContinuousPath
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> path = ContinuousPath.along(gimbal_crossing(), duration_s=3.0)
        >>> path.twists(0.0).pose.shape
        ()
    """

    start_ns: int
    duration_s: float
    twists: Callable[[FloatArray], TwistSample[Motor]]
    parent: str = "world"
    child: str = "imu"

    def __post_init__(self) -> None:
        checked_positive(self.duration_s, "ContinuousPath.duration_s")

    @classmethod
    def through(cls, trajectory: Trajectory, knot_spacing_s: float = 0.1) -> ContinuousPath:
        """A spline fitted to poses; the spline, not the poses, is then the true path.

        Args:
            trajectory: two poses or more.
            knot_spacing_s: the spline follows motion up to about 1 / (4 spacing) Hz and averages
                what is faster; where poses stand farther apart than knots it only joins them.

        Raises:
            ValueError: a spacing that is not positive, a single pose, or motion too fast for it.
        """
        spline = CumulativeBSpline.fit(trajectory, knot_spacing_s)
        span_s = float(trajectory.time_ns[-1] - trajectory.time_ns[0]) * 1e-9
        return cls(spline.start_ns, span_s, spline.twists, trajectory.parent, trajectory.child)

    @classmethod
    def along(
        cls, motion: Motion[Motor], duration_s: float, start_ns: int = 0, child: str = "imu"
    ) -> ContinuousPath:
        """An analytic motion, from its time 0 on, without any fit.

        Raises:
            ValueError: a duration that is not above 0.
        """
        return cls(start_ns, duration_s, motion.at, "world", child)

    def seen_from(self, imu_T_child: Motor, child: str = "imu") -> ContinuousPath:
        """The path of a frame bolted to this one: another place (the lever arm), other axes.

        Args:
            imu_T_child: pose of this path's frame in the frame wanted, one Motor; for the path of
                a camera it is ``imu_T_camera``, the extrinsics of camera and IMU.
            child: name of the frame wanted.

        Raises:
            ValueError: a batch of poses.
        """
        if imu_T_child.shape != ():
            raise ValueError(f"imu_T_child: expected a single pose, got shape {imu_T_child.shape}")
        child_T_imu = imu_T_child.inverse()

        def twists(time_s: FloatArray) -> TwistSample[Motor]:
            given = self.twists(time_s)
            return TwistSample(
                given.pose @ child_T_imu,
                imu_T_child.transform_twist(given.body_twist),
                imu_T_child.transform_twist(given.body_twist_rate),
            )

        return ContinuousPath(self.start_ns, self.duration_s, twists, self.parent, child)
