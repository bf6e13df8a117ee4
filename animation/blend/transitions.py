"""Two motions made one: cross-fades, offsets that die away by inertia, and clips blended in phase.

A motion is anything with `at(time_s)`, local poses ``(*, J)`` at times ``(*)``; transitions are
motions themselves, so they chain.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.blend.methods import (
    BLEND_METHODS,
    BlendMethod,
    Poses,
    added,
    additive,
    blend_poses,
    stacked,
)
from motorcade.animation.clip import Clip, MorphTrack
from motorcade.animation.easing import smoothstep
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive

# Step of the differences from which the velocity at a switch is taken.
_STEP_S = 1e-3


class PoseSource(Protocol):
    """Local poses ``(*, J)`` at times ``(*)`` in seconds.

    >>> import numpy as np
    >>> from motorcade.animation import Clip
    >>> from motorcade.animation.blend import Shifted
    >>> from motorcade.animation.blend.transitions import PoseSource
    >>> from motorcade.ga import Motor
    >>> def shape_of(motion: PoseSource) -> tuple[int, ...]:
    ...     return motion.at([0.0, 0.5]).shape
    >>> wave = Clip("wave", np.array([0.0, 1.0]), Motor.identity((2, 3)))  # of three joints
    >>> shape_of(wave), shape_of(Shifted(wave, start_s=4.0))
    ((2, 3), (2, 3))
    """

    def at(self, time_s: ArrayLike) -> Poses:
        """Local poses at times on the motion's own clock."""
        ...


@dataclass(frozen=True, eq=False)
class Shifted:
    """A motion on another clock: it is at its own `into_s` when the clock says `start_s`.

    Raises:
        ValueError: times that are not finite, or a rate that is not positive.

    >>> import numpy as np
    >>> from motorcade.animation import Clip
    >>> from motorcade.animation.blend import Shifted
    >>> from motorcade.ga import Motor
    >>> parent_T_joint = Motor.from_translation([[[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0]]])
    >>> ahead = Clip("ahead", np.array([0.0, 1.0]), parent_T_joint)
    >>> late = Shifted(ahead, start_s=10.0, rate=2.0)  # begins at 10 s, twice as fast
    >>> late.at(10.25).translation_m
    array([[0.5, 0. , 0. ]])
    """

    motion: PoseSource
    start_s: float = 0.0
    into_s: float = 0.0
    rate: float = 1.0

    def __post_init__(self) -> None:
        _check("Shifted", self.start_s, self.rate, "rate")
        if not np.isfinite(self.into_s):
            raise ValueError(f"Shifted.into_s: expected seconds, got {self.into_s}")

    def at(self, time_s: ArrayLike) -> Poses:
        """Local poses at times on the outer clock."""
        clock = checked_floats(time_s, "Shifted.at(time_s)", ())
        return self.motion.at((clock - self.start_s) * self.rate + self.into_s)


@dataclass(frozen=True, eq=False)
class CrossFade:
    """One motion until `start_s`, another from `start_s + duration_s` on, blended in between.

    The share follows `smoothstep`, so that velocities have no step. Both motions go on running
    meanwhile. With motions in phase feet stay where they are; others slide.

    Raises:
        ValueError: a start that is not finite, a duration that is not positive.

    >>> import numpy as np
    >>> from motorcade.animation import Clip
    >>> from motorcade.animation.blend import CrossFade
    >>> from motorcade.ga import Motor
    >>> def swinging(name, reach_m, period_s):
    ...     time_s = np.linspace(0.0, period_s, 9)
    ...     x = reach_m * np.sin(2.0 * np.pi * time_s / period_s)
    ...     poses = Motor.from_translation(x[:, None, None] * [1.0, 0.0, 0.0])
    ...     return Clip(name, time_s, poses, looped=True)
    >>> walk, run = swinging("walk", 1.0, 1.2), swinging("run", 2.0, 0.8)

    >>> start = CrossFade(walk, run, start_s=0.0, duration_s=0.4)
    >>> bool(np.all(start.at(0.6).coefficients == run.at(0.6).coefficients))
    True
    """

    first: PoseSource
    second: PoseSource
    start_s: float
    duration_s: float
    method: BlendMethod = "motor"

    def __post_init__(self) -> None:
        _check("CrossFade", self.start_s, self.duration_s)

    def at(self, time_s: ArrayLike) -> Poses:
        """Local poses ``(*, J)``."""
        clock = checked_floats(time_s, "CrossFade.at(time_s)", ())
        share = smoothstep((clock - self.start_s) / self.duration_s)
        pair = stacked([self.first.at(clock), self.second.at(clock)])
        return blend_poses(pair, np.stack([1.0 - share, share], axis=-1), self.method)


@dataclass(frozen=True, eq=False)
class Inertialized:
    """A switch at once, with what it would make jump carried over and let die away.

    At the switch every joint's pose differs from the new motion's by a twist that changes at some
    rate; from there a polynomial of fifth degree brings twist, rate and change of rate to zero.
    Only the new motion runs on, so it costs no second sampling (Bollo, "Inertialization", 2018).
    A component that already moves towards zero gets less time where it would swing past.

    Raises:
        ValueError: a start that is not finite, a duration that is not positive.

    >>> import numpy as np
    >>> from motorcade.animation import Clip
    >>> from motorcade.animation.blend import Inertialized
    >>> from motorcade.ga import Motor
    >>> def swinging(name, reach_m, period_s):
    ...     time_s = np.linspace(0.0, period_s, 9)
    ...     x = reach_m * np.sin(2.0 * np.pi * time_s / period_s)
    ...     poses = Motor.from_translation(x[:, None, None] * [1.0, 0.0, 0.0])
    ...     return Clip(name, time_s, poses, looped=True)
    >>> walk, run = swinging("walk", 1.0, 1.2), swinging("run", 2.0, 0.8)

    >>> switch = Inertialized(walk, run, start_s=0.3)
    >>> bool(np.allclose(switch.at(0.3).translation_m, walk.at(0.3).translation_m))  # nothing jumps
    True
    >>> bool(np.allclose(switch.at(0.7).translation_m, run.at(0.7).translation_m))
    True
    """

    first: PoseSource
    second: PoseSource
    start_s: float
    duration_s: float = 0.3

    def __post_init__(self) -> None:
        _check("Inertialized", self.start_s, self.duration_s)

    @cached_property
    def _offset(self) -> tuple[FloatArray, FloatArray]:
        """Twists ``(J, 6 or 7)`` from the new motion to the old one at the switch, and rates.

        The old motion's velocity is the one that it arrives with, the new one's that with which it
        goes on: a clip that begins there, or ends there, is still on the other side.
        """
        before, at = (self.first.at(self.start_s - step) for step in (_STEP_S, 0.0))
        gone_on = added(at, additive(at, before))
        now = additive(at, self.second.at(self.start_s)).as_twist()
        later = additive(gone_on, self.second.at(self.start_s + _STEP_S)).as_twist()
        return now, (later - now) / _STEP_S

    def at(self, time_s: ArrayLike) -> Poses:
        """Local poses ``(*, J)``."""
        clock = checked_floats(time_s, "Inertialized.at(time_s)", ())
        passed = clock - self.start_s
        twist, rate = self._offset
        decayed = _decay(twist, rate, self.duration_s, np.maximum(passed, 0.0)[..., None, None])
        second = self.second.at(clock)
        kind = Motor if decayed.shape[-1] == 6 else Similarity
        after = added(second, kind.from_twist(decayed))
        before = passed < 0.0
        if not np.any(before):
            return after
        pair = stacked([self.first.at(clock), after]).coefficients
        chosen = np.where(before[..., None, None], pair[..., 0, :, :], pair[..., 1, :, :])
        return kind(chosen)


def _decay(
    start: FloatArray, rate: FloatArray, duration_s: float, passed: FloatArray
) -> FloatArray:
    """From `start` at `rate` to rest at zero within `duration_s`, without swinging past."""
    closing = start * rate < 0.0
    # The polynomial stays on its side of zero as long as rate * span >= -5/2 start.
    limit = np.where(closing, -2.5 * start / np.where(closing, rate, 1.0), np.inf)
    span = np.maximum(np.minimum(duration_s, limit), 1e-6)
    x = np.minimum(passed / span, 1.0)
    # Hermite's basis of fifth degree for a value and a rate at 0; all else is zero.
    value = 1.0 - x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    slope = x - x**3 * (6.0 - 8.0 * x + 3.0 * x**2)
    return start * value + rate * span * slope


def _check(name: str, start_s: float, positive: float, field: str = "duration_s") -> None:
    if not np.isfinite(start_s):
        raise ValueError(f"{name}.start_s: expected seconds, got {start_s}")
    checked_positive(positive, f"{name}.{field}")


MOST_SAMPLES = 100_000
"""Of a blended clip: half an hour at 60 Hz."""


def blend_clips(
    first: Clip,
    second: Clip,
    weight: float,
    method: BlendMethod = "motor",
    *,
    in_phase: bool = True,
    offset: float = 0.0,
    rate_hz: float = 60.0,
) -> Clip:
    """A clip between two of one skeleton.

    In phase both are stretched to the weighted mean of their lengths, as cycles of a walk and a
    run must be; by the clock both run at their own speed for as long as the longer one takes, the
    shorter repeating if it is looped and else holding its end. Weights of morph targets go along
    where both clips move them; what only one moves stays at rest.

    Args:
        first: clip of J joints.
        second: clip of the same joints.
        weight: share of the second, 0 to 1.
        method: see `motorcade.animation.blend.methods`.
        in_phase: blend by phase rather than by the clock.
        offset: phase of the second at which it is like the start of the first, see
            `phase_between`; only in phase.
        rate_hz: samples a second of the result.

    Raises:
        ValueError: another number of joints or morph targets, a weight outside 0 to 1, a rate that
            is not positive, more than 100,000 samples, or clips of no length.

    >>> import numpy as np
    >>> from motorcade.animation import Clip
    >>> from motorcade.animation.blend import blend_clips
    >>> from motorcade.ga import Motor
    >>> def swinging(name, reach_m, period_s):
    ...     time_s = np.linspace(0.0, period_s, 9)
    ...     x = reach_m * np.sin(2.0 * np.pi * time_s / period_s)
    ...     poses = Motor.from_translation(x[:, None, None] * [1.0, 0.0, 0.0])
    ...     return Clip(name, time_s, poses, looped=True)
    >>> walk, run = swinging("walk", 1.0, 1.2), swinging("run", 2.0, 0.8)

    >>> jog = blend_clips(walk, run, 0.5)
    >>> round(jog.duration_s, 3), jog.looped
    (1.0, True)
    """
    if first.poses.shape[1] != second.poses.shape[1]:
        raise ValueError(
            f"blend_clips: expected clips of one skeleton, got {first.poses.shape[1]} joints in "
            f"'{first.name}' and {second.poses.shape[1]} in '{second.name}'"
        )
    if not 0.0 <= weight <= 1.0:
        raise ValueError(f"blend_clips(weight): expected 0 to 1, got {weight}")
    checked_positive(rate_hz, "blend_clips(rate_hz)")
    lengths = np.array([first.duration_s, second.duration_s])
    length = float((1.0 - weight) * lengths[0] + weight * lengths[1] if in_phase else max(lengths))
    if length * rate_hz > MOST_SAMPLES:
        raise ValueError(
            f"blend_clips(rate_hz): expected at most {MOST_SAMPLES} samples, got "
            f"{rate_hz:g} Hz for {length:g} s"
        )
    if not length > 0.0:
        raise ValueError(f"blend_clips: '{first.name}' and '{second.name}' have no length")
    time_s = np.linspace(0.0, length, max(2, round(length * rate_hz) + 1))
    rates = lengths / length if in_phase else np.ones(2)
    starts = np.array([first.time_s[0], second.time_s[0]])
    starts[1] += offset * lengths[1] if in_phase else 0.0
    sampled = [
        clip.at(start + rate * time_s)
        for clip, start, rate in zip((first, second), starts, rates, strict=True)
    ]
    blended = blend_poses(stacked(sampled), [1.0 - weight, weight], method)
    looped = in_phase and first.looped and second.looped
    if looped:  # what a loop begins with it ends with, whatever rounding says
        coefficients = blended.coefficients.copy()
        coefficients[-1] = coefficients[0]
        blended = type(blended)(coefficients)
    name = f"{first.name} to {second.name} {weight:g} {method}"
    return Clip(
        name,
        time_s,
        blended,
        looped,
        morphs=_morphs((first, second), starts, rates, weight, time_s),
    )


def _morphs(
    clips: tuple[Clip, Clip],
    starts: FloatArray,
    rates: FloatArray,
    weight: float,
    time_s: FloatArray,
) -> MorphTrack | None:
    """Weights of morph targets between those of two clips of one character; None without any."""
    pair = [
        clip.morph_weights(start + rate * time_s)
        for clip, start, rate in zip(clips, starts, rates, strict=True)
    ]
    first, second = pair
    if first is None or second is None:
        return None
    if first.shape != second.shape:
        raise ValueError(
            f"blend_clips: expected morph targets of one character, got {first.shape[1]} in "
            f"'{clips[0].name}' and {second.shape[1]} in '{clips[1].name}'"
        )
    return MorphTrack(time_s, (1.0 - weight) * first + weight * second)


def differences_m(
    first: Clip,
    second: Clip,
    skeleton: Skeleton,
    weights: Iterable[float] = (0.25, 0.5, 0.75),
    points: FloatArray | None = None,
    methods: Iterable[BlendMethod] = BLEND_METHODS,
    offset: float = 0.0,
    in_phase: bool = True,
    joints: IntArray | None = None,
) -> dict[tuple[BlendMethod, BlendMethod], float]:
    """The farthest that a point of the body lies apart under two methods, in metres.

    Args:
        first: clip.
        second: clip of the same joints.
        skeleton: of the J joints.
        weights: shares of the second clip to look at.
        points: ``(J, 3)`` a point fixed to each joint, in its frame; by default its origin.
        methods: which to compare, each with each.
        offset: see `blend_clips`.
        in_phase: see `blend_clips`.
        joints: numbers of the joints to look at, such as those that carry vertices; all by default.
    """
    held = (
        np.zeros((len(skeleton), 3)) if points is None else checked_floats(points, "points", (3,))
    )
    seen = np.arange(len(skeleton)) if joints is None else joints
    apart: dict[tuple[BlendMethod, BlendMethod], float] = {}
    names = tuple(methods)
    for weight in weights:
        positions = {}
        for name in names:
            blended = blend_clips(first, second, weight, name, in_phase=in_phase, offset=offset)
            positions[name] = skeleton.world(blended.poses.rigid).apply(held)[..., seen, :]
        for a, b in combinations(names, 2):
            distance = float(np.linalg.norm(positions[a] - positions[b], axis=-1).max())
            apart[a, b] = max(apart.get((a, b), 0.0), distance)
    return apart
