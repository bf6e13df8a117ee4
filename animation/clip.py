"""Clip: local poses of a skeleton sampled over time.

Between samples every joint follows the screw from one pose to the next. A looped clip ends in the
pose it began with and repeats; any other clip holds its first and last pose outside its span.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import FloatArray, Motor, checked_floats, frozen

# How far, in metres and radians, the ends of a loop may lie apart.
LOOP_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Clip:
    """A named motion of a skeleton with J joints.

    Args:
        name: what it is called.
        time_s: (F,) strictly increasing, F at least 1.
        poses: Motor (F, J), local poses `parent_T_joint`.
        looped: whether the motion repeats; its last pose must then equal its first.

    Raises:
        ValueError: an empty name, times that do not increase, shapes that do not fit, or a loop
            whose ends differ by more than 1e-6 m or rad.
    """

    name: str
    time_s: FloatArray
    poses: Motor
    looped: bool = False

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("Clip.name: expected a name, got an empty string")
        times = checked_floats(self.time_s, "Clip.time_s", ())
        if times.ndim != 1 or times.size == 0 or np.any(np.diff(times) <= 0.0):
            raise ValueError(
                f"Clip.time_s of '{self.name}': expected (F,) strictly increasing seconds, got "
                f"shape {times.shape}"
            )
        if len(self.poses.shape) != 2 or self.poses.shape[0] != times.size:
            raise ValueError(
                f"Clip.poses of '{self.name}': expected shape ({times.size}, J), got "
                f"{self.poses.shape}"
            )
        if self.looped:
            self._check_loop(times)
        object.__setattr__(self, "time_s", frozen(times))

    def _check_loop(self, times: FloatArray) -> None:
        if times.size < 2:
            raise ValueError(f"Clip '{self.name}': a loop needs two samples or more, got one")
        gap = float(np.max(np.abs((self.poses[0].inverse() @ self.poses[-1]).as_twist())))
        if gap > LOOP_TOLERANCE:
            raise ValueError(
                f"Clip.poses of '{self.name}': expected the last pose of a loop to equal the "
                f"first, got {gap:.3g} m or rad apart"
            )

    @property
    def duration_s(self) -> float:
        """Seconds from the first sample to the last; the period of a loop."""
        return float(self.time_s[-1] - self.time_s[0])

    def at(self, time_s: ArrayLike) -> Motor:
        """Local poses (*, J) at times (*) in seconds on the clip's own clock.

        Raises:
            ValueError: NaN or infinite times.
        """
        wanted = checked_floats(time_s, "Clip.at(time_s)", ())
        if len(self.time_s) == 1:
            return self.poses[np.zeros(wanted.shape, dtype=np.int64)]
        first, last = self.time_s[0], self.time_s[-1]
        if self.looped:
            clock = first + np.mod(wanted - first, last - first)
        else:
            clock = np.clip(wanted, first, last)
        before = np.searchsorted(self.time_s, clock, side="right") - 1
        before = np.clip(before, 0, len(self.time_s) - 2)
        fraction = (clock - self.time_s[before]) / np.diff(self.time_s)[before]
        return self.poses[before].interpolate(self.poses[before + 1], fraction[..., None])
