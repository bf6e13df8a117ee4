"""A reference trajectory between its stamps, smooth enough to be differentiated.

Screw interpolation has corners at the stamps, and second differences taken across a corner are
large where the true acceleration is small. This interpolant passes through every pose with
continuous velocity, acceleration and angular rate (cubic splines; scipy's `CubicSpline` and
`RotationSpline`). It invents nothing across gaps: `covers` says where the stamps stand close.
"""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import near_steps


class NotObservableError(ValueError):
    """The trajectories are sound but too short, too sparse or too still to tell the figure.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import NotObservableError, position_lag_s
        >>> from motorcade.ga import Motor, Trajectory
        >>> still = Trajectory(np.arange(100) * 10_000_000, Motor.identity((100,)))
        >>> try:
        ...     position_lag_s(still, still)
        ... except NotObservableError as reason:
        ...     print(reason)
        lag: expected trajectories that move, got one that stands still or turns evenly
    """


class SmoothPath:
    """Cubic interpolation of a trajectory; times are seconds after its first stamp, `origin_ns`.

    Raises:
        NotObservableError: fewer than two poses, or steps so uneven that no spline is found.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        from scipy.interpolate import CubicSpline
        from scipy.spatial.transform import Rotation, RotationSpline

        if len(trajectory) < 2:
            raise NotObservableError(f"reference: expected 2 or more poses, got {len(trajectory)}")
        self.origin_ns = int(trajectory.time_ns[0])
        self._time_s = trajectory.time_s
        self._rotors = trajectory.motors.rotor
        turns = Rotation.from_quat(self._rotors.as_quaternion(), scalar_first=True)
        try:
            with np.errstate(over="raise", invalid="raise"):  # its iteration may run away
                self._rotation = RotationSpline(self._time_s, turns)
        except (FloatingPointError, ValueError) as fault:
            raise NotObservableError(
                "reference: expected stamps near enough to even for a spline of rotations, got "
                f"steps of {np.diff(self._time_s).min():.3g} to {np.diff(self._time_s).max():.3g} s"
            ) from fault
        self._position = CubicSpline(self._time_s, trajectory.motors.translation_m)

    @classmethod
    def through(cls, trajectory: Trajectory) -> SmoothPath:
        """The interpolation of a trajectory, computed once for as long as the trajectory lives."""
        fitted = _FITTED.get(trajectory)
        if fitted is None:
            fitted = _FITTED[trajectory] = cls(trajectory)
        return fitted

    @property
    def span_s(self) -> tuple[float, float]:
        """First and last time in seconds."""
        return 0.0, float(self._time_s[-1])

    def seconds(self, time_ns: IntArray) -> FloatArray:
        """Stamps in seconds after `origin_ns`."""
        return np.asarray((time_ns - self.origin_ns) * 1e-9, dtype=np.float64)

    def covers(self, time_s: FloatArray) -> NDArray[np.bool_]:
        """Which times lie between two stamps at most three median intervals apart."""
        steps = np.diff(self._time_s)
        close = near_steps(steps)
        before = np.clip(np.searchsorted(self._time_s, time_s, side="right") - 1, 0, steps.size - 1)
        inside = (time_s >= self._time_s[0]) & (time_s <= self._time_s[-1])
        return np.asarray(inside & close[before], dtype=np.bool_)

    def positions_m(self, time_s: FloatArray) -> FloatArray:
        """Positions ``(*, 3)``."""
        return np.asarray(self._position(time_s), dtype=np.float64)

    def rotors(self, time_s: FloatArray) -> Rotor:
        """Rotations ``(N,)`` at times ``(N,)``.

        The spline itself composes rotations one after another, ten times as slowly.
        """
        spline = self._rotation
        before = np.searchsorted(self._time_s, time_s, side="right") - 1
        turned = Rotor.from_rotation_vector(spline.interpolator(time_s))
        return self._rotors[np.clip(before, 0, len(self._time_s) - 2)] @ turned

    def poses(self, time_s: FloatArray) -> Motor:
        """Poses ``(N,)`` at times ``(N,)``."""
        return Motor.from_rotor_translation(self.rotors(time_s), self.positions_m(time_s))


def beside(
    estimate: Trajectory, truth: Trajectory, fewest: int, name: str
) -> tuple[Trajectory, Trajectory]:
    """Both at those stamps of the estimate that the ground truth covers.

    Raises:
        NotObservableError: fewer than `fewest` of them.
    """
    path = SmoothPath.through(truth)
    time_s = path.seconds(estimate.time_ns)
    kept = np.flatnonzero(path.covers(time_s))
    if kept.size < fewest:
        raise NotObservableError(
            f"{name}: expected {fewest} or more stamps within the ground truth, got {kept.size}"
        )
    ours = estimate[kept]
    return ours, replace(ours, poses=path.poses(time_s[kept]))


_FITTED: WeakKeyDictionary[Trajectory, SmoothPath] = WeakKeyDictionary()
