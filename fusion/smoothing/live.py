"""Smoothing of poses as they come, on plain numbers, with nothing to tune.

Filters of held pose, of steady velocity and of steady acceleration run side by side, each with
twelve cut-offs from four times the sampling rate down by halves, for position and for rotation
apart. Each is weighed by how well it has foretold the latest poses, the size of the noise at its
likeliest, and the weighted mean is what comes out. So noise and motion need not be known, and may
change. Poses off by more than 4.6 deviations are heard the less the farther off they are; where
such poses agree with each other for a tenth of a second, the path has jumped and is gone on from
there. Where even intervals foretell poses better than their stamps do, stamps are not believed.

Sources: D. T. Magill, Optimal adaptive estimation of sampled stochastic processes, IEEE TAC 10
(1965); the filters and the recursion back as in `motorcade.fusion.smoothing.causal.kalman`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.smoothing.checks import warn_of_coarse
from motorcade.fusion.smoothing.native import _live
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_number, checked_positive

MEMORY_S = 2.0
"""How fast the past is forgotten: noise and motion of hands and drones change within seconds.
Chosen on EuRoC's V1_02 and four synthetic motions, where 4 and 8 s do as well within 1 %."""

_FEWEST = 5
# Stamps are whole nanoseconds; no pose comes so soon after another that a shorter lag waits for it.
_SHORTEST_S = 1e-9


class LiveSmoother:
    """Smooths a stream of poses, now or a constant lag later, and predicts ahead for display.

    Args:
        lag_s: how far behind the latest pose the smoothed one is, in seconds. 0 gives the pose now;
            a tenth of a second takes away more noise. Memory and time grow with the poses
            within it.
        memory_s: time constant in seconds by which the weights of the filters follow.

    Raises:
        ValueError: a negative lag, one above 0 but below a nanosecond, or a memory that is not
            positive.
        TypeError: what is no number.

    It breaks down where noise is no noise but motion: drift and errors that last longer than the
    memory stay, and wrong poses that agree with each other for longer than 0.1 s are followed.
    Until the fifth pose those given come back as they are. A copy goes its own way from where it
    was taken; what has taken poses can't be pickled.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.smoothing import LiveSmoother
        >>> rng = np.random.default_rng(0)
        >>> live = LiveSmoother()
        >>> for k in range(300):  # at 60 Hz along x at 1 m/s, with noise of 5 mm
        ...     measured = [k / 60, 0.0, 0.0] + 0.005 * rng.standard_normal(3)
        ...     time_s, position_m, wxyz = live.update(k / 60, measured, (1.0, 0.0, 0.0, 0.0))
        >>> print(f"{1e3 * np.linalg.norm(position_m - [299 / 60, 0.0, 0.0]):.0f} mm off")
        1 mm off
        >>> shown_s, position_m, wxyz = live.predict(time_s + 0.05)  # when the display lights up
        >>> print(f"{1e3 * np.linalg.norm(position_m - [shown_s, 0.0, 0.0]):.0f} mm off")
        1 mm off
    """

    def __init__(self, lag_s: float = 0.0, memory_s: float = MEMORY_S) -> None:
        if not 0.0 <= checked_number(lag_s, "lag_s") < np.inf:
            raise ValueError(f"lag_s: expected 0 or more seconds, got {lag_s}")
        if 0.0 < lag_s < _SHORTEST_S:
            raise ValueError(f"lag_s: expected 0, or {_SHORTEST_S:g} seconds or more, got {lag_s}")
        self.lag_s = float(lag_s)
        self.memory_s = checked_positive(memory_s, "memory_s", "seconds")
        self.reset()

    def reset(self) -> None:
        """Forget all poses."""
        self._live = _live.Live(self.lag_s, self.memory_s)
        self._seen = 0

    def __copy__(self) -> LiveSmoother:
        other = LiveSmoother(self.lag_s, self.memory_s)
        other._live, other._seen = _live.Live(self._live), self._seen
        return other

    def __deepcopy__(self, _: Any) -> LiveSmoother:
        return self.__copy__()

    def __reduce__(self) -> tuple[type[LiveSmoother], tuple[float, float]]:
        if self._seen:
            raise TypeError(
                "LiveSmoother: expected to be pickled before its first pose, for what it learnt of "
                "a stream stays in this process; pickle it after reset(), or use copy.deepcopy"
            )
        return LiveSmoother, (self.lag_s, self.memory_s)

    def update(
        self, time_s: float, position_m: ArrayLike, wxyz: ArrayLike
    ) -> tuple[float, FloatArray, FloatArray]:
        """Take a measured pose; give the smoothed one that is due.

        Args:
            time_s: stamp in seconds, after those before.
            position_m: ``(3,)`` in any unit of length; results are in the same.
            wxyz: ``(4,)`` quaternion, scalar first, of any length; its sign is free.

        Returns:
            Stamp, position ``(3,)`` and unit quaternion ``(4,)``: at the newest stamp that lies
            `lag_s` back, or at the first while there is none.

        Raises:
            ValueError: a stamp not after the last one or more than 1000 s after it, as of
                nanoseconds; numbers that are not finite, a quaternion of length 0, or too few
                numbers. The smoother is then as it was.
        """
        due = self._live.update(time_s, position_m, wxyz)
        if self._seen < _FEWEST:
            self._seen += 1
            if self._seen == _FEWEST:
                warn_of_coarse(self._live.usual_interval_s)
        return due

    def predict(self, time_s: float) -> tuple[float, FloatArray, FloatArray]:
        """The pose at a time to come, such as when a display will light up.

        Args:
            time_s: not before the latest pose, and at most half a second or four intervals after
                it. Beyond a tenth of a second no model foretells hands.

        Raises:
            ValueError: a time before the latest pose or too long after it, or no pose yet.
        """
        return self._live.predict(time_s)

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """Every pose of a trajectory as it falls due; those within the lag of the end by what is.

        A stream that this smoother is fed with goes on as if nothing had been.

        Raises:
            ValueError: poses with a scale, which this smoother knows nothing of.
        """
        if not isinstance(trajectory.poses, Motor):
            raise ValueError(
                "trajectory: expected rigid poses, got similarities; .rigid gives them"
            )
        if len(trajectory) < _FEWEST:
            return trajectory
        poses = trajectory.motors.astype(np.float64)
        measured = np.concatenate([poses.translation_m, poses.rotor.coefficients], axis=-1)
        out = np.empty(measured.shape)  # rows, however the conversions laid theirs
        # Seconds since the first stamp: those since 1970 would be rounded to a quarter microsecond.
        time_s = 1e-9 * (trajectory.time_ns - trajectory.time_ns[0])
        _live.smooth(self.lag_s, self.memory_s, time_s, np.ascontiguousarray(measured), out)
        smoothed = Motor.from_rotor_translation(Rotor(out[:, 3:]), out[:, :3])
        return Trajectory(trajectory.time_ns, smoothed, trajectory.parent, trajectory.child)
