"""Analytic motions: products of exponentials, with exact twists, accelerations and jerks.

``pose(t) = Π exp(axis_i f_i(t))``, the first factor nearest to the world. With
``P_k = P_{k-1} exp(a f)`` the body twist follows factor by factor, ``w_k = y + a f'`` where
``y = Ad(exp(-a f)) w_{k-1}``, and as ``y' = Ad w' + [y, a f']`` so do all its derivatives. It is
the product of exponentials of robot arms (R. W. Brockett, Robotic manipulators and the product of
exponentials formula, 1984) with a joint for each factor.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.motions.signals import Signal
from motorcade.ga import Motor, Similarity, Trajectory, TwistSample
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive, frozen
from motorcade.ga.motion import twist_bracket

__all__ = ["Factor", "Motion", "even_stamps"]

V = TypeVar("V", Motor, Similarity)


@dataclass(frozen=True, eq=False)
class Factor:
    """``exp(twist · signal(t))``: turn, screw, shift or growth along one axis.

    Args:
        twist: ``(6,)`` rotation (rad) and translational part (m) for a signal of 1, or ``(7,)``
            with the logarithm of the scale behind them.
        signal: how far, over time.

    Examples:
        >>> from motorcade.fusion.motions import Factor, Motion, Polynomial
        >>> from motorcade.ga import Motor
        >>> turning = Factor([0, 0, 1, 0, 0, 0], Polynomial((0.0, 0.5)))  # 0.5 rad/s about z
        >>> Motion((turning,), Motor).at(2.0).pose.rotor.as_rotation_vector()
        array([-0.,  0.,  1.])
    """

    twist: FloatArray
    signal: Signal

    def __post_init__(self) -> None:
        given = np.asarray(self.twist)
        size = 7 if given.shape[-1:] == (7,) else 6
        checked = checked_floats(given, "Factor.twist", (size,))
        if checked.ndim != 1:
            raise ValueError(f"Factor.twist: expected shape (6,) or (7,), got {checked.shape}")
        object.__setattr__(self, "twist", frozen(checked))


@dataclass(frozen=True, eq=False)
class Motion(Generic[V]):
    """A pose as a closed function of time, ``world_T_camera`` by default.

    Args:
        factors: from the world to the moving frame.
        versor: Motor, or Similarity where the twists have seven numbers.

    Raises:
        ValueError: no factors, or twists of a size that does not fit the versor.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import Factor, Motion, Polynomial
        >>> from motorcade.ga import Motor
        >>> ahead = Factor([0, 0, 0, 1, 0, 0], Polynomial((0.0, 2.0)))  # 2 m/s along x
        >>> turning = Factor([0, 0, 1, 0, 0, 0], Polynomial((0.0, np.pi)))
        >>> motion = Motion((ahead, turning), Motor)  # world_T_camera
        >>> motion.at(0.5).body_twist.round(6)  # x of the camera points along y of the world by now
        array([ 0.      ,  0.      ,  3.141593,  0.      , -2.      ,  0.      ])
        >>> motion.sampled(rate_hz=30.0, duration_s=2.0)
        Trajectory(world_T_camera, 61 poses, 2.000 s)
    """

    factors: tuple[Factor, ...]
    versor: type[V]

    def __post_init__(self) -> None:
        size = 7 if self.versor is Similarity else 6
        sizes = [factor.twist.size for factor in self.factors]
        if not sizes or set(sizes) != {size}:
            raise ValueError(
                f"Motion.factors: expected one or more with twists of {size} numbers, got {sizes}"
            )

    def at(self, time_s: ArrayLike) -> TwistSample[V]:
        """Pose, body twist and its derivative at times ``(*)`` in seconds; exact at all times.

        Raises:
            ValueError: NaN or infinity.
        """
        pose, twist, rate, _ = self._derived(time_s)
        return TwistSample(pose, twist, rate)

    def twist_jerk(self, time_s: ArrayLike) -> FloatArray:
        """Second derivative of the body twist ``(*, 6)`` (similarities: 7) at times ``(*)``."""
        return self._derived(time_s)[3]

    def sampled(
        self,
        rate_hz: float,
        duration_s: float,
        start_ns: int = 0,
        start_s: float = 0.0,
        parent: str = "world",
        child: str = "camera",
    ) -> Trajectory:
        """The motion at even stamps.

        Args:
            rate_hz: poses a second.
            duration_s: from the first stamp to the last, at most.
            start_ns: the first stamp.
            start_s: time of the motion at the first stamp.
            parent: name of the frame that poses map to.
            child: name of the frame that moves.

        Raises:
            ValueError: a rate or duration that is not positive.
        """
        offset_ns = even_stamps(rate_hz, duration_s)
        poses = self.at(start_s + offset_ns * 1e-9).pose
        return Trajectory(start_ns + offset_ns, poses, parent, child)

    def _derived(self, time_s: ArrayLike) -> tuple[V, FloatArray, FloatArray, FloatArray]:
        times: FloatArray = checked_floats(time_s, "Motion.at(time_s)", ())
        pose = self.versor.identity(times.shape)
        twist = rate = jerk = np.zeros((*times.shape, self.factors[0].twist.size))
        for factor in self.factors:
            value, first, second, third = (
                d[..., None] * factor.twist for d in factor.signal.derivatives(times)
            )
            step = self.versor.from_twist(value)
            back = step.inverse()
            twist, rate, jerk = (back.transform_twist(part) for part in (twist, rate, jerk))
            crossed = rate + twist_bracket(twist, first)
            jerk = jerk + twist_bracket(rate + crossed, first) + twist_bracket(twist, second)
            pose, twist, rate, jerk = pose @ step, twist + first, crossed + second, jerk + third
        return pose, twist, rate, jerk


def even_stamps(rate_hz: float, duration_s: float) -> IntArray:
    """Stamps ``(N,)`` in nanoseconds from zero to at most `duration_s`, rounded each for itself.

    Raises:
        ValueError: a rate or duration that is not positive and finite.

    Examples:
        >>> from motorcade.fusion.motions import even_stamps
        >>> even_stamps(rate_hz=30.0, duration_s=0.1)
        array([        0,  33333333,  66666667, 100000000])
    """
    for name, value in (("rate_hz", rate_hz), ("duration_s", duration_s)):
        checked_positive(value, name)
    count = int(np.floor(duration_s * rate_hz + 1e-6)) + 1
    return np.round(np.arange(count) * (1e9 / rate_hz)).astype(np.int64)
