"""Errors of time: stamps that tremble, frames that are missing, poses that come late.

The poses themselves stay; what changes is when they are said to have been, and whether at all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.motions.degradations.poses import (
    Degradation,
    check_number,
    check_runs,
    runs,
)
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import check_count

# Neighbours that move towards each other by this part of the gap between them stay in order.
_REACH = 0.49


@dataclass(frozen=True)
class StampJitter(Degradation):
    """Stamps off by independent Gaussian errors of deviation `sigma_s`; poses stay.

    So that the order stays, no stamp moves by more than 0.49 of the gap to its neighbour: from a
    deviation of a fifth of the interval on, the errors are smaller than asked for.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import StampJitter
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> moved = StampJitter(sigma_s=0.002).apply(true, rng)
        >>> print(f"{1e-6 * (moved.time_ns - true.time_ns).std():.1f} ms")
        2.0 ms
    """

    sigma_s: float

    def __post_init__(self) -> None:
        check_number(self, "sigma_s", high=1e6)

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Move the stamps."""
        time_ns = trajectory.time_ns
        offset = 1e9 * self.sigma_s * rng.standard_normal(time_ns.size)
        gaps = np.concatenate([[np.inf], _REACH * np.diff(time_ns), [np.inf]])
        held = np.clip(offset, -gaps[:-1], gaps[1:])
        return _stamped(trajectory, time_ns + np.trunc(held).astype(np.int64))


@dataclass(frozen=True)
class DroppedFrames(Degradation):
    """A share of the poses is missing, in bursts of a mean length; the first one always stays.

    Args:
        share: of the poses, 0 to below 1.
        mean_run: mean length of a burst in poses, geometric; None drops each pose for itself.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import DroppedFrames
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> len(true), len(DroppedFrames(share=0.2, mean_run=3.0).apply(true, rng))
        (301, 244)
    """

    share: float
    mean_run: float | None = None

    def __post_init__(self) -> None:
        check_runs(self, self.share, self._mean_run())

    def _mean_run(self) -> float:
        alone = 1.0 / (1.0 - self.share) if self.share < 1.0 else np.inf
        return alone if self.mean_run is None else self.mean_run

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Leave the rest."""
        lost = runs(rng, len(trajectory), self.share, self._mean_run())
        lost[0] = False
        return trajectory[~lost]


@dataclass(frozen=True)
class Blackouts(Degradation):
    """No pose at all for `length_s` every `every_s`, the first time `every_s` after the first pose.

    A blackout that would not end before the path does is left out.

    Args:
        length_s: of each blackout, above zero and below `every_s`.
        every_s: from the start of one to the start of the next.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Blackouts
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> dark = Blackouts(length_s=1.0, every_s=4.0)
        >>> dark.spans_s(10.0)
        array([[4., 5.],
               [8., 9.]])
        >>> len(true), len(dark.apply(true, rng))
        (301, 241)
    """

    length_s: float
    every_s: float

    def __post_init__(self) -> None:
        check_number(self, "every_s", 1e-9)
        check_number(self, "length_s", 1e-9, self.every_s)

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Leave the poses outside the blackouts."""
        offset_s = (trajectory.time_ns - trajectory.time_ns[0]) * 1e-9
        return trajectory[~self.dark(offset_s, trajectory.duration_s)]

    def spans_s(self, duration_s: float) -> FloatArray:
        """Start and end ``(K, 2)`` of every blackout on a path so long, in seconds from its start.

        Poses are missing from each start on, up to but not at the end.

        Raises:
            ValueError: more than ten million of them.
        """
        check_count(duration_s / self.every_s, "Blackouts.spans_s(duration_s)")
        starts: FloatArray = self.every_s * np.arange(1.0, self._count(duration_s) + 1.0)
        return np.stack([starts, starts + self.length_s], axis=-1)

    def dark(self, offset_s: FloatArray, duration_s: float) -> NDArray[np.bool_]:
        """Which times ``(N,)`` after the start of a path so long lie in a blackout.

        Times within half a microsecond of an edge count as on it.
        """
        at = np.round(offset_s, 6)[:, None]
        # Which blackout began last, or the neighbours of that by rounding.
        number = np.floor(at / self.every_s) + np.arange(-1.0, 2.0)
        start = self.every_s * number
        end = start + self.length_s
        there = (number >= 1.0) & (number <= self._count(duration_s))
        dark: NDArray[np.bool_] = (there & (at >= start) & (at < end)).any(axis=1)
        return dark

    def _count(self, duration_s: float) -> int:
        return max(0, int(np.floor((duration_s - self.length_s) / self.every_s + 1e-9)))


@dataclass(frozen=True)
class Latency(Degradation):
    """Poses are stamped when they arrive, `delay_s` late on average.

    Delays are gamma distributed with deviation `spread_s`, and no pose overtakes another. Where the
    mean is `known` it is taken off the stamps again: a constant known delay then harms nothing
    after the fact, a varying one leaves its variation.

    Args:
        delay_s: mean delay, above zero.
        spread_s: deviation of the delay from pose to pose; 0 is a constant delay.
        known: whether the mean is taken off.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.motions.degradations import Latency
        >>> true, rng = screw().sampled(rate_hz=30.0, duration_s=10.0), np.random.default_rng(0)
        >>> late = Latency(delay_s=0.03).apply(true, rng)
        >>> (late.time_ns - true.time_ns)[:3]
        array([30000000, 30000000, 30000000])
    """

    delay_s: float
    spread_s: float = 0.0
    known: bool = False

    def __post_init__(self) -> None:
        check_number(self, "delay_s", 1e-9, 1e6)
        check_number(self, "spread_s", high=1e6)
        if self.spread_s > 0.0:
            check_number(self, "spread_s", 1e-9, 1e6)  # as fine as stamps

    def apply(self, trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
        """Stamp the poses with their arrival, or what is thought to be their time."""
        count = len(trajectory)
        delay_s = np.full(count, self.delay_s)
        if self.spread_s > 0.0:
            shape = (self.delay_s / self.spread_s) ** 2
            delay_s = rng.gamma(shape, self.delay_s / shape, count)
        if self.known:
            delay_s = delay_s - self.delay_s
        arrival_ns = trajectory.time_ns + np.round(1e9 * delay_s).astype(np.int64)
        # One nanosecond each, so that poses that arrive together stay in order.
        places = np.arange(count)
        return _stamped(trajectory, np.maximum.accumulate(arrival_ns - places) + places)


def _stamped(trajectory: Trajectory, time_ns: IntArray) -> Trajectory:
    return Trajectory(time_ns, trajectory.poses, trajectory.parent, trajectory.child)
