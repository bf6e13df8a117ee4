"""Clip: local poses of a skeleton sampled over time.

Between samples every joint follows the screw from one pose to the next, or the path of constant
growth where its scale changes. A looped clip ends in the
pose it began with and repeats; any other clip holds its first and last pose outside its span.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.morphs import MorphTrack
from motorcade.ga import Motor, Similarity, Versor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen

Poses = TypeVar("Poses", bound=Versor)

# How far, in metres and radians, the ends of a loop may lie apart.
LOOP_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Clip:
    """A named motion of a skeleton with J joints.

    Args:
        name: what it is called.
        time_s: (F,) strictly increasing, F at least 1.
        poses: Motor (F, J), local poses `parent_T_joint`; Similarity (F, J) only where joints
            grow or shrink over time, relative to the rest pose of the skeleton.
        looped: whether the motion repeats; its last pose must then equal its first.
        key_count: how many keys the fullest channel of its file had, where the motion is sampled
            more finely; by default the number of samples.
        morphs: weights of morph targets over the same clock, or None where they stay at rest.

    Raises:
        ValueError: an empty name, times that do not increase, shapes that do not fit, a count of
            keys outside 1 to F, or a loop whose ends differ by more than 1e-6 m, rad or in the
            logarithm of scale.

    >>> import numpy as np
    >>> from motorcade.animation import Clip
    >>> from motorcade.ga import Motor
    >>> # two samples of one joint
    >>> parent_T_joint = Motor.from_translation([[[0, 0, 1.0]], [[0, 0, 2.0]]])
    >>> rise = Clip("rise", np.array([0.0, 0.5]), parent_T_joint)
    >>> rise.at([0.25, 9.0]).translation_m[:, 0] + 0.0
    array([[0. , 0. , 1.5],
           [0. , 0. , 2. ]])
    """

    name: str
    time_s: FloatArray
    poses: Motor | Similarity
    looped: bool = False
    key_count: int = 0
    morphs: MorphTrack | None = None

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
        if not 0 <= self.key_count <= times.size:
            raise ValueError(
                f"Clip.key_count of '{self.name}': expected 1 to {times.size}, got {self.key_count}"
            )
        object.__setattr__(self, "key_count", self.key_count or times.size)
        object.__setattr__(self, "time_s", frozen(times))

    def _check_loop(self, times: FloatArray) -> None:
        if times.size < 2:
            raise ValueError(f"Clip '{self.name}': a loop needs two samples or more, got one")
        gap = float(np.max(np.abs(_gap(self.poses))))
        if gap > LOOP_TOLERANCE:
            raise ValueError(
                f"Clip.poses of '{self.name}': expected the last pose of a loop to equal the "
                f"first, got {gap:.3g} m or rad apart"
            )

    @property
    def duration_s(self) -> float:
        """Seconds from the first sample to the last; the period of a loop."""
        return float(self.time_s[-1] - self.time_s[0])

    def at(self, time_s: ArrayLike) -> Motor | Similarity:
        """Local poses (*, J) at times (*) in seconds on the clip's own clock.

        Raises:
            ValueError: NaN or infinite times.
        """
        wanted = checked_floats(time_s, "Clip.at(time_s)", ())
        if len(self.time_s) == 1:
            return self.poses[np.zeros(wanted.shape, dtype=np.int64)]
        clock = self._clock(wanted)
        before = np.searchsorted(self.time_s, clock, side="right") - 1
        before = np.clip(before, 0, len(self.time_s) - 2)
        fraction = (clock - self.time_s[before]) / np.diff(self.time_s)[before]
        return _between(self.poses, before, fraction)

    def morph_weights(self, time_s: ArrayLike) -> FloatArray | None:
        """Weights of the morph targets (*, W) at times (*); None where they stay at rest.

        Raises:
            ValueError: NaN or infinite times.
        """
        if self.morphs is None:
            return None
        return self.morphs.at(self._clock(checked_floats(time_s, "Clip.morph_weights", ())))

    def _clock(self, wanted: FloatArray) -> FloatArray:
        """Times within the span: repeated in a loop, else held at its ends."""
        first, last = self.time_s[0], self.time_s[-1]
        if self.looped:
            return np.asarray(first + np.mod(wanted - first, last - first))
        return np.clip(wanted, first, last)


def _gap(poses: Poses) -> FloatArray:
    """Coordinates of what lies between the first poses and the last."""
    return -2.0 * (poses[0].inverse() @ poses[-1]).log()


def _between(poses: Poses, before: IntArray, fraction: FloatArray) -> Poses:
    """Poses on the way from samples `before` to those after them."""
    return poses[before].interpolate(poses[before + 1], fraction[..., None])
