"""What of an error between poses is measured: evo's pose relations, absolute and relative.

==============================  =====================================================  ====
relation                        of the error pose E with rotation R and translation t  unit
==============================  =====================================================  ====
``full``                        ‖E − 1‖ (Frobenius): metres and radians mixed           none
``trans_part``                  ‖t‖                                                    m
``rot_part``                    ‖R − 1‖ (Frobenius) = 2 √2 sin(angle / 2)              none
``angle_deg``, ``angle_rad``    angle of R, from 0 to half a turn                      °
``point_distance``              relative: difference of the two distances travelled    m
``point_distance_error_ratio``  relative: the same, as a share of the true distance    %
==============================  =====================================================  ====
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from motorcade.fusion.metrics.poses.deltas import Delta
from motorcade.fusion.metrics.poses.pose_error import absolute_translation_m
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray

Relation = Literal[
    "full",
    "trans_part",
    "rot_part",
    "angle_deg",
    "angle_rad",
    "point_distance",
    "point_distance_error_ratio",
]

_BLOCK = 1 << 18
_ROTATION_PART = 2.0 * np.sqrt(2.0)


def absolute_errors(
    estimate: Motor, reference: Motor, relation: Relation = "trans_part"
) -> FloatArray:
    """Errors ``(P,)`` between paired poses in one world (evo: APE with a pose relation).

    Raises:
        ValueError: another relation, or a share of a distance, which absolute errors do not have.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import absolute_errors
        >>> from motorcade.ga import Motor
        >>> off = Motor.from_euler_translation([[0.0, 0.0, np.pi / 2]], [3.0, 4.0, 0.0])
        >>> for relation in ("trans_part", "angle_deg", "rot_part", "full"):
        ...     print(absolute_errors(off, Motor.identity((1,)), relation).round(6))
        [5.]
        [90.]
        [2.]
        [5.385165]
    """
    _check(relation)
    if relation == "point_distance_error_ratio":
        raise ValueError(f"relation: absolute errors have no {relation}")
    if relation in ("trans_part", "point_distance"):
        return absolute_translation_m(estimate, reference)
    return _measured(estimate.inverse() @ reference, relation)


def relative_errors(
    estimate: Motor,
    reference: Motor,
    delta: Delta | None = None,
    relations: Sequence[Relation] = ("trans_part", "angle_rad"),
) -> tuple[FloatArray, ...]:
    """Errors of the motion between poses a delta apart, ``(S,)`` for each relation (evo: RPE).

    Args:
        estimate: poses ``(P,)``.
        reference: the true poses that belong to them ``(P,)``.
        delta: how far apart, one frame unless said otherwise.
        relations: what to measure; metres and radians unless said otherwise. A share of the true
            distance leaves out pairs where that is zero.

    Raises:
        ValueError: another relation.
        NotObservableError: no two poses so far apart.

    Examples:
        >>> from motorcade.fusion.metrics import Delta, relative_errors
        >>> from motorcade.ga import Motor
        >>> true = Motor.from_translation([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
        >>> drifting = Motor.from_translation([[5.0, 0.0, 0.0], [6.1, 0.0, 0.0], [7.2, 0.0, 0.0]])
        >>> metres, radians = relative_errors(drifting, true)
        >>> metres.round(6)
        array([0.1, 0.1])
        >>> (share,) = relative_errors(drifting, true, Delta(2), ["point_distance_error_ratio"])
        >>> share.round(6)
        array([10.])
    """
    for relation in relations:
        _check(relation)
    first, last = (Delta() if delta is None else delta).ends(estimate, reference)
    blocks = [
        errors_between(estimate, reference, first[start:end], last[start:end], relations)
        for start, end in _blocks(first.size)
    ]
    return tuple(np.concatenate(parts) for parts in zip(*blocks, strict=True))


def _check(relation: str) -> None:
    if relation not in get_args(Relation):
        known = ", ".join(get_args(Relation))
        raise ValueError(f"relation: expected one of {known}, got {relation!r}")


def _blocks(count: int) -> list[tuple[int, int]]:
    return [(start, min(start + _BLOCK, count)) for start in range(0, count, _BLOCK)]


def errors_between(
    estimate: Motor,
    reference: Motor,
    first: IntArray,
    last: IntArray,
    relations: Sequence[Relation],
) -> tuple[FloatArray, ...]:
    """Errors of the motion between poses with these indices ``(S,)``; see `relative_errors`."""
    sides = [(poses[first], poses[last]) for poses in (reference, estimate)]
    true, ours = (before.inverse() @ after for before, after in sides)
    error = true.inverse() @ ours
    true_m, ours_m = (
        _travelled_m(before.translation_m, after.translation_m) for before, after in sides
    )
    return tuple(
        _of_distances(true_m, ours_m, relation)
        if relation.startswith("point_distance")
        else _measured(error, relation)
        for relation in relations
    )


def _travelled_m(before_m: FloatArray, after_m: FloatArray) -> FloatArray:
    """Distances ``(S,)``; zero where they are no more than the rounding of positions in motors."""
    distance: FloatArray = np.linalg.norm(after_m - before_m, axis=-1)
    rounding = 16.0 * np.finfo(np.float64).eps * np.abs(before_m).sum(axis=-1)
    return np.where(distance > rounding, distance, 0.0)


def _of_distances(true_m: FloatArray, ours_m: FloatArray, relation: Relation) -> FloatArray:
    error = np.abs(ours_m - true_m)
    if relation == "point_distance":
        return error
    moving = true_m > 0.0
    share: FloatArray = 100.0 * error[moving] / true_m[moving]
    return share


def _measured(error: Motor, relation: Relation) -> FloatArray:
    if relation in ("trans_part", "point_distance"):
        distance: FloatArray = np.linalg.norm(error.translation_m, axis=-1)
        return distance
    angle_rad = error.rotor.angle()
    if relation == "angle_rad":
        return angle_rad
    if relation == "angle_deg":
        return np.rad2deg(angle_rad)
    rotation: FloatArray = _ROTATION_PART * np.sin(0.5 * angle_rad)
    if relation == "rot_part":
        return rotation
    full: FloatArray = np.hypot(rotation, np.linalg.norm(error.translation_m, axis=-1))
    return full
