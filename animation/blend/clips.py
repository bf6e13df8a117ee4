"""Two clips made one, and how far the methods of blending lie apart on them."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations

import numpy as np

from motorcade.animation.blend.methods import BLEND_METHODS, BlendMethod, blend_poses, stacked
from motorcade.animation.clip import Clip
from motorcade.animation.morphs import MorphTrack
from motorcade.animation.skeleton import Skeleton
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive

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
    >>> from motorcade.animation import Clip, blend_clips
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
