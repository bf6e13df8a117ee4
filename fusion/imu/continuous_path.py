"""A moving frame in continuous time: splines through poses, or an analytic motion.

A path gives a pose and its exact derivatives at any moment of a span. All is in twists of the
moving frame, so a lever arm is one adjoint: the sensor's twist is that of the frame it is bolted
to, seen from the sensor.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from motorcade.fusion.motions import Motion
from motorcade.ga import Motor, Trajectory, TwistSample
from motorcade.ga.arrays import FloatArray, IntArray, checked_positive
from motorcade.ga.motion import ScrewPath
from motorcade.ga.splines import CumulativeBSpline
from motorcade.ga.stamps import segments


@dataclass(frozen=True, eq=False)
class ContinuousPath:
    """A moving frame over a span of time.

    Args:
        start_ns: stamp at which the span begins.
        duration_s: its length, above 0.
        twists: from seconds after the start ``(*)`` to pose, body twist and its derivative.
        parent: name of the frame that poses map to.
        child: name of the frame that moves.
        segments_s: ``(S, 2)`` first and last second of the segments in which a sensor is read;
            by default the whole span.

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
    segments_s: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        checked_positive(self.duration_s, "ContinuousPath.duration_s")
        if not self.segments_s:
            object.__setattr__(self, "segments_s", ((0.0, self.duration_s),))

    @classmethod
    def through(cls, trajectory: Trajectory, knot_spacing_s: float = 0.1) -> ContinuousPath:
        """A spline fitted to poses; the spline, not the poses, is then the true path.

        A gap of more than ten seconds (and three median intervals) splits the path: there is a
        spline for each segment, and no sensor is read between them, where the path follows the
        screw from one to the next.

        Args:
            trajectory: two poses or more.
            knot_spacing_s: the spline follows motion up to about 1 / (4 spacing) Hz and averages
                what is faster; where poses stand farther apart than knots it only joins them.

        Raises:
            ValueError: a spacing that is not positive, a single pose, motion too fast for it, or
                more than 2,000 knots and 20 more a pose in a segment.
        """
        parts = [trajectory[part] for part in segments(trajectory.time_ns)]
        whole = parts if len(parts) == 1 else [part for part in parts if len(part) > 1]
        splines = [CumulativeBSpline.fit(part, knot_spacing_s) for part in whole]
        first, last = splines[0], splines[-1]
        starts_s = [(spline.start_ns - first.start_ns) * 1e-9 for spline in splines]
        spans = tuple(
            (start, start + spline.duration_s)
            for start, spline in zip(starts_s, splines, strict=True)
        )
        twists = first.twists if first is last else _Segments(tuple(splines), spans).twists
        return cls(first.start_ns, spans[-1][1], twists, trajectory.parent, trajectory.child, spans)

    @classmethod
    def along(cls, motion: Motion[Motor], duration_s: float, start_ns: int = 0) -> ContinuousPath:
        """An analytic motion, from its time 0 on, without any fit.

        Raises:
            ValueError: a duration that is not above 0.
        """
        return cls(start_ns, duration_s, motion.at)

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
            sample = self.twists(time_s)
            return TwistSample(
                sample.pose @ child_T_imu,
                imu_T_child.transform_twist(sample.body_twist),
                imu_T_child.transform_twist(sample.body_twist_rate),
            )

        return replace(self, twists=twists, child=child)


@dataclass(frozen=True, eq=False)
class _Segments:
    """Splines one after another, joined by screws."""

    splines: tuple[CumulativeBSpline, ...]
    spans_s: tuple[tuple[float, float], ...]

    def twists(self, time_s: FloatArray) -> TwistSample[Motor]:
        """As `CumulativeBSpline.twists`, seconds after the first spline's start."""
        flat = np.ravel(time_s)
        pose = np.zeros((flat.size, 8))
        twist, rate = np.zeros((2, flat.size, 6))
        for here, sample in self._parts(flat):
            pose[here], twist[here], rate[here] = (
                sample.pose.coefficients, sample.body_twist, sample.body_twist_rate
            )  # fmt: skip
        shape = np.shape(time_s)
        twist, rate = twist.reshape(*shape, 6), rate.reshape(*shape, 6)
        return TwistSample(Motor(pose.reshape(*shape, 8)), twist, rate)

    def _parts(self, time_s: FloatArray) -> Iterator[tuple[IntArray, TwistSample[Motor]]]:
        begins, ends = np.array(self.spans_s).T
        number = np.clip(np.searchsorted(begins, time_s, side="right") - 1, 0, None)
        between = time_s > ends[number]
        between &= number < len(ends) - 1
        for k, spline in enumerate(self.splines):
            here = np.flatnonzero((number == k) & ~between)
            if here.size:
                own_s = np.clip(time_s[here] - begins[k], 0.0, spline.duration_s)
                yield here, spline.twists(own_s)
            here = np.flatnonzero((number == k) & between)
            if here.size:
                yield here, self._screw(k).twists(time_s[here] - ends[k])

    def _screw(self, number: int) -> ScrewPath:
        before, after = self.splines[number : number + 2]
        poses = Motor.stack([before.twists(before.duration_s).pose, after.twists(0.0).pose])
        gap_ns = round((self.spans_s[number + 1][0] - self.spans_s[number][1]) * 1e9)
        return ScrewPath(Trajectory(np.array([0, gap_ns]), poses))
