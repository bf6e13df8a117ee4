"""Keyframes played: where an object is in its parent between the times that were written down.

What joining the same keyframes along screws, by quaternions and by Euler angles costs.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motorcade.animation.authoring.parts import INTERPOLATIONS, Interpolation, ScenePart
from motorcade.animation.authoring.poses import EulerObjectPose, VersorObjectPose
from motorcade.ga import Rotor, Similarity
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
    coefficients = np.empty((len(clock), 12))
    row = np.clip(np.searchsorted(at, clock, side="right") - 1, 0, max(len(at) - 2, 0))
    for first in np.unique(row):
        rows = np.flatnonzero(row == first)
        last = min(first + 1, len(at) - 1)
        span = max(float(at[last] - at[first]), 1e-12)
        share = np.clip((clock[rows] - at[first]) / span, 0.0, 1.0)
        poses = _joined(part, int(first), int(last), share, interpolation or part.interpolation)
        coefficients[rows] = poses.coefficients
    return Similarity.normalize(coefficients)


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
        EulerObjectPose(part.angles_at(k), end.translation_m, float(end.scale))
        for k, end in ((first, a), (last, b))
    ]
    return ends[0].towards(ends[1], share)


FEWEST = 2


@dataclass(frozen=True)
class InterpolationFigures:
    """How an object goes through its keyframes.

    Fields:
        turned_over_geodesic: how far it turns in all, over the least that the keyframes need.
        peak_rad_s, mean_rad_s: its fastest and its mean rate of rotation.
        off_screw_m, off_screw_rad: how far it is from the motors' path at the same time, at most.
    """

    turned_over_geodesic: float
    peak_rad_s: float
    mean_rad_s: float
    off_screw_m: float
    off_screw_rad: float


def compare_interpolations(
    part: ScenePart, samples: int = 1000
) -> dict[Interpolation, InterpolationFigures]:
    """The same keyframes joined in each way, in figures.

    Args:
        part: with two keyframes or more.
        samples: steps from one keyframe to the next.

    Raises:
        ValueError: fewer than two keyframes, or fewer than one step.

    >>> import numpy as np
    >>> from motorcade.animation.authoring import compare_interpolations, scene_of
    >>> keys = [
    ...     {"time_s": 0, "euler_deg": [0, 89.9, 0]}, {"time_s": 1, "euler_deg": [170, 89.9, 170]}
    ... ]
    >>> thing = {"name": "a", "kind": "prop", "file": "a.glb", "keyframes": keys}
    >>> found = compare_interpolations(scene_of({"objects": [thing]}, "scene").part("a"))
    >>> [round(found[way].turned_over_geodesic, 1) for way in ("motor", "quaternion", "euler")]
    [1.0, 1.0, 17.0]
    """
    keys = part.keyframes
    if len(keys) < FEWEST or samples < 1:
        raise ValueError(
            f"compare_interpolations: expected {FEWEST} keyframes and a step or more, got "
            f"{len(keys)} and {samples}"
        )
    at = np.array([one.time_s for one in keys])
    ends = pairwise(at)
    steps = [np.linspace(a, b, samples, endpoint=False) for a, b in ends]
    time_s = np.append(np.concatenate(steps), at[-1])
    screw = between_keyframes(part, time_s, "motor")
    least = float(np.sum(_turns(Rotor.stack([one.parent_T_object.rotor for one in keys]))))
    figures: dict[Interpolation, InterpolationFigures] = {}
    for way in INTERPOLATIONS:
        poses = between_keyframes(part, time_s, way)
        turns = _turns(poses.rotor)
        rates = turns / np.diff(time_s)
        off_m = np.linalg.norm(poses.translation_m - screw.translation_m, axis=-1)
        off_rad = (screw.rotor.inverse() @ poses.rotor).angle()
        figures[way] = InterpolationFigures(
            float(np.sum(turns)) / least if least > 0.0 else 1.0,
            float(rates.max()),
            float(np.sum(turns) / (at[-1] - at[0])),
            float(off_m.max()),
            float(np.max(np.minimum(off_rad, 2.0 * np.pi - off_rad))),
        )
    return figures


def _turns(rotors: Rotor) -> FloatArray:
    """Angles from one rotor to the next."""
    angle = (rotors[:-1].inverse() @ rotors[1:]).angle()
    return np.asarray(np.minimum(angle, 2.0 * np.pi - angle))
