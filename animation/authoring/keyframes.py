"""Keyframes played: where an object is in its parent between the times that were written down."""

from __future__ import annotations

import numpy as np

from motorcade.animation.authoring.parts import Interpolation, ScenePart
from motorcade.animation.authoring.poses import EulerObjectPose, VersorObjectPose
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray, checked_floats


def between_keyframes(
    part: ScenePart, time_s: FloatArray, interpolation: Interpolation | None = None
) -> Similarity:
    """`parent_T_object` ``(T,)`` of a part with keyframes, at times ``(T,)``.

    Before the first keyframe it is as there, after the last as there. "motor" follows the screw
    from one to the next, or the spiral where the scale changes; "quaternion" turns along the
    geodesic, moves straight and grows evenly in the logarithm; "euler" joins angles (those that
    were written, else those of the turn), position and scale each straight, as editors on Euler
    angles do: near ±90° of the middle angle it spins.

    Args:
        part: with one keyframe or more.
        time_s: seconds from the first frame.
        interpolation: in place of the part's own.

    Raises:
        ValueError: a part without keyframes.

    >>> import numpy as np
    >>> from motorcade.animation.authoring import SceneKeyframe, ScenePart, between_keyframes
    >>> from motorcade.ga import Motor, Similarity
    >>> low, high = (
    ...     Similarity.from_motor_scale(Motor.from_translation([0.0, 0.0, z])) for z in (0.0, 1.0)
    ... )
    >>> keys = (SceneKeyframe(0.0, low), SceneKeyframe(2.0, high))
    >>> ball = ScenePart("prop", "ball.glb", keyframes=keys)
    >>> between_keyframes(ball, np.array([-1.0, 0.5, 9.0])).translation_m[:, 2]
    array([0.  , 0.25, 1.  ])
    """
    keys = part.keyframes
    if not keys:
        raise ValueError("between_keyframes(part): expected one keyframe or more, got none")
    clock = checked_floats(time_s, "between_keyframes(time_s)", ())
    at = np.array([one.time_s for one in keys])
    made = np.empty((len(clock), 12))
    row = np.clip(np.searchsorted(at, clock, side="right") - 1, 0, max(len(at) - 2, 0))
    for first in np.unique(row):
        rows = np.flatnonzero(row == first)
        last = min(first + 1, len(at) - 1)
        span = max(float(at[last] - at[first]), 1e-12)
        share = np.clip((clock[rows] - at[first]) / span, 0.0, 1.0)
        poses = _joined(part, int(first), int(last), share, interpolation or part.interpolation)
        made[rows] = poses.coefficients
    return Similarity.normalize(made)


def _joined(
    part: ScenePart, first: int, last: int, share: FloatArray, interpolation: Interpolation
) -> Similarity:
    """The poses ``(T,)`` at shares ``(T,)`` of the way from one keyframe to the next."""
    a, b = (part.keyframes[k].parent_T_object for k in (first, last))
    if interpolation == "motor":
        return a.reshape(1).interpolate(b.reshape(1), share)
    if interpolation == "quaternion":
        return VersorObjectPose(a).towards(VersorObjectPose(b), share)
    ends = [
        EulerObjectPose(part.angles_at(k), one.translation_m, float(one.scale))
        for k, one in ((first, a), (last, b))
    ]
    return ends[0].towards(ends[1], share)
