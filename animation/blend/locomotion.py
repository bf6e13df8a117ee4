"""Locomotion: cycles of different lengths blended in phase, along a blend space of one parameter.

Walk, jog and run take different times for one cycle. Blended by the clock their steps drift apart;
blended by phase, the share of the cycle that has passed, every foot keeps its part. The length of
the blended cycle is the weighted mean of the cycles' lengths.

A clip in place can be blended, looped and retargeted; what it travelled moves the character, along
with its weight. Split off is motion on the ground: along x and y, and the turn about z.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.blend.methods import BlendMethod, Poses, additive, blend_poses, stacked
from motorcade.animation.clip import LOOP_TOLERANCE, Clip, between
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_z
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen


@dataclass(frozen=True, eq=False)
class BlendSpace:
    """Cycles placed along a parameter, such as the speed at which they walk.

    Args:
        positions: ``(K,)`` rising values of the parameter, one a clip; K at least 2.
        clips: looped clips of one skeleton, of any lengths.
        offsets: ``(K,)`` phases at which the clips are alike (see `phase_between`); 0 by default.
        method: how poses are blended.

    Raises:
        ValueError: positions that do not rise or are no match for the clips, a clip that is not
            looped or of another skeleton.

    >>> import numpy as np
    >>> from motorcade.animation import Clip, BlendSpace
    >>> from motorcade.ga import Motor
    >>> def swinging(name, reach_m, period_s):
    ...     time_s = np.linspace(0.0, period_s, 9)
    ...     x = reach_m * np.sin(2.0 * np.pi * time_s / period_s)
    ...     poses = Motor.from_translation(x[:, None, None] * [1.0, 0.0, 0.0])
    ...     return Clip(name, time_s, poses, looped=True)
    >>> walk, run = swinging("walk", 1.0, 1.2), swinging("run", 2.0, 0.8)

    >>> gaits = BlendSpace(np.array([1.2, 3.6]), (walk, run))  # by speed, m/s
    >>> gaits.weights(1.8)
    array([0.75, 0.25])
    >>> gaits.pose(1.8, phase=0.25).translation_m + 0.0
    array([[1.25, 0.  , 0.  ]])
    """

    positions: FloatArray
    clips: tuple[Clip, ...]
    offsets: FloatArray = field(default_factory=lambda: np.zeros(0))
    method: BlendMethod = "motor"

    def __post_init__(self) -> None:
        positions = checked_floats(self.positions, "BlendSpace.positions", ())
        count = len(self.clips)
        if count < 2 or positions.shape != (count,) or np.any(np.diff(positions) <= 0.0):
            raise ValueError(
                "BlendSpace.positions: expected rising numbers, one for each of two clips or more, "
                f"got {positions} for {count} clips"
            )
        joints = self.clips[0].poses.shape[1]
        for clip in self.clips:
            if not clip.looped or clip.poses.shape[1] != joints:
                raise ValueError(
                    f"BlendSpace.clips: expected loops of {joints} joints, got '{clip.name}' with "
                    f"{clip.poses.shape[1]}, {'looped' if clip.looped else 'not looped'}"
                )
        offsets = checked_floats(self.offsets, "BlendSpace.offsets", ())
        if not offsets.size:
            offsets = np.zeros(count)
        if offsets.shape != (count,):
            raise ValueError(
                f"BlendSpace.offsets: expected {count} phases, got shape {offsets.shape}"
            )
        object.__setattr__(self, "positions", frozen(positions))
        object.__setattr__(self, "offsets", frozen(offsets))

    def weights(self, value: ArrayLike) -> FloatArray:
        """Shares of the clips ``(*, K)`` at values ``(*)``; outside the positions the nearest."""
        values = checked_floats(value, "BlendSpace.weights(value)", ())
        columns = [np.interp(values, self.positions, row) for row in np.eye(len(self.clips))]
        return np.stack(columns, axis=-1)

    def duration_s(self, value: ArrayLike) -> FloatArray:
        """Seconds ``(*)`` that one cycle takes at values ``(*)``."""
        lengths = np.array([clip.duration_s for clip in self.clips])
        seconds: FloatArray = np.sum(self.weights(value) * lengths, axis=-1)
        return seconds

    def pose(self, value: ArrayLike, phase: ArrayLike) -> Poses:
        """Local poses ``(*, J)`` at values ``(*)`` and phases ``(*)``, of which 1 is a cycle."""
        share = self.weights(value)
        passed = checked_floats(phase, "BlendSpace.pose(phase)", ())
        sampled = [
            clip.at(clip.time_s[0] + (passed + offset) * clip.duration_s)
            for clip, offset in zip(self.clips, self.offsets, strict=True)
        ]
        return blend_poses(stacked(sampled), share, self.method)

    def phases(self, time_s: ArrayLike, value: ArrayLike) -> FloatArray:
        """Phases ``(N,)`` reached at rising times ``(N,)`` while the parameter goes through values.

        The first is 0; between times the parameter is taken to change evenly.

        Raises:
            ValueError: times that do not rise or no match for the values.
        """
        clock = checked_floats(time_s, "BlendSpace.phases(time_s)", ())
        values = checked_floats(value, "BlendSpace.phases(value)", ())
        if clock.ndim != 1 or values.shape != clock.shape or np.any(np.diff(clock) < 0.0):
            raise ValueError(
                "BlendSpace.phases: expected rising times (N,) and as many values, got shapes "
                f"{clock.shape} and {values.shape}"
            )
        rate = 1.0 / self.duration_s(values)
        steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(clock)
        return np.concatenate([[0.0], np.cumsum(steps)])


def phase_between(
    first: Clip, second: Clip, skeleton: Skeleton, joints: Sequence[str], samples: int = 64
) -> float:
    """The phase of a second cycle at which it is like the start of a first one.

    It is where the heights of the joints named (the feet) fit best over the whole cycle, each
    made unit in spread so that a run's high steps compare to a walk's, by circular correlation.

    Raises:
        ValueError: a clip that is not looped, no such joint, or joints that never move.
    """
    heights = [_heights(clip, skeleton, joints, samples) for clip in (first, second)]
    spectra = [np.fft.rfft(height, axis=0) for height in heights]
    likeness = np.fft.irfft(np.sum(spectra[1] * np.conj(spectra[0]), axis=1), samples)
    return float(np.argmax(likeness)) / samples


def _heights(clip: Clip, skeleton: Skeleton, joints: Sequence[str], samples: int) -> FloatArray:
    if not clip.looped:
        raise ValueError(f"phase_between: expected a loop, got '{clip.name}'")
    numbers = [skeleton.index(name) for name in joints]
    clock = clip.time_s[0] + clip.duration_s * np.arange(samples) / samples
    height = skeleton.world(clip.at(clock)).translation_m[:, numbers, 2]
    spread = np.std(height, axis=0)
    if not numbers or np.any(spread < 1e-9):
        raise ValueError(f"phase_between(joints): expected joints that move in '{clip.name}'")
    centred: FloatArray = (height - np.mean(height, axis=0)) / spread
    return centred


@dataclass(frozen=True, eq=False)
class RootMotion:
    """How far a clip has travelled since its start.

    Args:
        time_s: ``(F,)`` strictly increasing seconds on the clip's clock, F at least 2.
        start_T_now: Motor ``(F,)``, motions on the ground; the first is the identity.
        repeated: whether the way goes on from its end with every cycle, as a loop's does.

    Raises:
        ValueError: times that do not increase, shapes that do not fit.

    >>> import numpy as np
    >>> from motorcade.animation.blend import RootMotion
    >>> from motorcade.ga import Motor
    >>> start_T_now = Motor.from_translation([[0.0, 0.0, 0.0], [1.2, 0.0, 0.0]])
    >>> walk = RootMotion(np.array([0.0, 1.0]), start_T_now, repeated=True)
    >>> walk.at(2.5).translation_m  # two cycles and a half
    array([3., 0., 0.])
    """

    time_s: FloatArray
    start_T_now: Motor
    repeated: bool

    def __post_init__(self) -> None:
        times = checked_floats(self.time_s, "RootMotion.time_s", ())
        if times.ndim != 1 or times.size < 2 or np.any(np.diff(times) <= 0.0):
            raise ValueError("RootMotion.time_s: expected (F,) strictly increasing, F at least 2")
        if self.start_T_now.shape != times.shape:
            raise ValueError(
                f"RootMotion.start_T_now: expected shape {times.shape}, got "
                f"{self.start_T_now.shape}"
            )
        object.__setattr__(self, "time_s", frozen(times))

    @property
    def speed_m_s(self) -> float:
        """Length of the way over the clip's seconds."""
        steps = np.diff(self.start_T_now.translation_m, axis=0)
        return float(np.linalg.norm(steps, axis=1).sum() / (self.time_s[-1] - self.time_s[0]))

    def at(self, time_s: ArrayLike) -> Motor:
        """``start_T_now`` ``(*)`` at times ``(*)``: whole cycles, then the part of one."""
        wanted = checked_floats(time_s, "RootMotion.at(time_s)", ())
        first, last = self.time_s[0], self.time_s[-1]
        cycles = np.floor((wanted - first) / (last - first)) if self.repeated else 0.0 * wanted
        clock = np.clip(wanted - cycles * (last - first), first, last)
        before, after, fraction = between(self.time_s, clock)
        way = self.start_T_now
        within = way[before].interpolate(way[after], fraction)
        return Motor.exp(cycles[..., None] * way[-1].log()) @ within


def split_root_motion(
    clip: Clip, skeleton: Skeleton, joint: str | None = None
) -> tuple[Clip, RootMotion]:
    """A clip without its way over the ground, and that way.

    The heading is the joint's turn about z since the clip's start (swing-twist), so that leaning
    stays in the clip. A clip whose ends are alike but for the way becomes a loop.

    Args:
        clip: of the skeleton; its poses are rigid.
        skeleton: with the joint.
        joint: whose motion over the ground is the way; by default the first root.

    Raises:
        ValueError: no such joint, one that is no root, or a clip of a single pose.

    >>> import numpy as np
    >>> from motorcade.animation import Clip, Skeleton
    >>> from motorcade.animation.blend.locomotion import split_root_motion
    >>> from motorcade.ga import Motor
    >>> one = Skeleton(("root",), np.array([-1]), Motor.identity((1,)))
    >>> parent_T_joint = Motor.from_translation([[[0, 0, 1.0]], [[2.0, 0, 1.0]]])
    >>> ahead = Clip("walk", np.array([0.0, 1.0]), parent_T_joint)
    >>> in_place, way = split_root_motion(ahead, one)
    >>> in_place.at(1.0).translation_m + 0.0, way.speed_m_s
    (array([[0., 0., 1.]]), 2.0)
    """
    number = skeleton.index(joint) if joint else skeleton.root
    if skeleton.parents[number] >= 0 or len(clip.time_s) < 2:
        raise ValueError(
            f"split_root_motion: expected a root joint and a clip of two poses or more, got joint "
            f"'{skeleton.names[number]}' and {len(clip.time_s)} poses"
        )
    root = clip.poses.rigid[:, number]
    heading = np.unwrap(heading_of(root @ root[0].inverse()))
    rotor, at = turn_z(heading), root.translation_m * [1.0, 1.0, 0.0]
    way = Motor.from_rotor_translation(rotor, at - rotor.apply(at[0]))
    inside = without_way(clip, skeleton, way)
    return inside, RootMotion(clip.time_s, way, inside.looped)


def heading_of(pose: Motor) -> FloatArray:
    """Turns ``(*)`` about z, in radians, of poses ``(*)``; leaning is left aside (swing-twist)."""
    w, _, _, e12 = np.moveaxis(pose.rotor.coefficients, -1, 0)
    return np.asarray(-2.0 * np.arctan2(e12, w))


def without_way(clip: Clip, skeleton: Skeleton, way: Motor) -> Clip:
    """A clip with motions ``(F,)`` of the whole figure taken back; a loop if its ends are alike."""
    inside = skeleton.moved(clip.poses, way.inverse())
    looped = bool(np.max(np.abs(additive(inside[-1], inside[0]).as_twist())) <= LOOP_TOLERANCE)
    return replace(clip, poses=inside, looped=looped)
