"""How far poses are from those they should be: distance, rotation, tilt, scale; and their summary.

Errors are in metres and radians, and both poses must describe the same moving frame in worlds that
agree (`alignment`).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray


def log_scales(poses: Motor | Similarity) -> FloatArray:
    """Logarithms of the scales ``(*)``; zero for rigid poses.

    Examples:
        >>> from motorcade.fusion.metrics import log_scales
        >>> from motorcade.ga import Motor, Similarity
        >>> log_scales(Similarity.from_motor_scale(Motor.identity((2,)), [1.0, 2.0])).round(6)
        array([0.      , 0.693147])
    """
    if isinstance(poses, Motor):
        return np.zeros(poses.shape)
    return np.log(poses.scale)


@dataclass(frozen=True)
class Statistics:
    """Summary of one error over all pairs, in the unit of the error.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics.poses.pose_error import Statistics
        >>> Statistics.of(np.array([0.0, 3.0, 4.0])).median
        3.0
    """

    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of the statistics, in order."""
        return tuple(field.name for field in fields(cls))

    @classmethod
    def of(cls, errors: FloatArray) -> Statistics:
        """Summarise errors ``(N,)``, N at least 1; `std` is that of the population."""
        if errors.ndim != 1 or errors.size == 0:
            raise ValueError(f"errors: expected shape (N,) with N >= 1, got {errors.shape}")
        return cls(
            rmse=float(np.sqrt(np.mean(errors**2))),
            mean=float(np.mean(errors)),
            median=float(np.median(errors)),
            std=float(np.std(errors)),
            min=float(np.min(errors)),
            max=float(np.max(errors)),
        )


def absolute_translation_m(estimate: Motor, reference: Motor) -> FloatArray:
    """Distances ``(P,)`` between paired positions (evo: APE, translation part).

    Examples:
        >>> from motorcade.fusion.metrics import absolute_translation_m
        >>> from motorcade.ga import Motor
        >>> off = Motor.from_translation([3.0, 4.0, 0.0])
        >>> float(absolute_translation_m(off, Motor.identity()))
        5.0
    """
    distance: FloatArray = np.linalg.norm(estimate.translation_m - reference.translation_m, axis=-1)
    return distance


def rotation_rad(estimate: Motor, reference: Motor) -> FloatArray:
    """Angles ``(P,)`` between paired orientations, in [0, π] (evo: APE, rotation angle).

    Examples:
        >>> from motorcade.fusion.metrics import rotation_rad
        >>> from motorcade.ga import Motor
        >>> turned = Motor.from_euler_translation([0.0, 0.0, 0.25], [0.0, 0.0, 0.0])
        >>> round(float(rotation_rad(turned, Motor.identity())), 6)
        0.25
    """
    return (reference.rotor.inverse() @ estimate.rotor).angle()


def tilt_rad(estimate: Motor, reference: Motor) -> FloatArray:
    """Angles ``(P,)`` between the two directions of "up" that paired poses give the moving frame.

    Unlike the rotation error it does not see a turn about the vertical (the worlds' z axis).

    Examples:
        >>> from motorcade.fusion.metrics import tilt_rad
        >>> from motorcade.ga import Motor
        >>> turned = Motor.from_euler_translation([[0, 0, 0.25], [0.25, 0, 0]], [0, 0, 0])
        >>> tilt_rad(turned, Motor.identity((2,))).round(6)  # a turn about the vertical is no tilt
        array([0.  , 0.25])
    """
    up = np.array([0.0, 0.0, 1.0])
    ours, theirs = estimate.rotor.inverse().apply(up), reference.rotor.inverse().apply(up)
    sine = np.linalg.norm(np.cross(ours, theirs), axis=-1)
    angle: FloatArray = np.arctan2(sine, np.sum(ours * theirs, axis=-1))
    return angle


def constant_rotation(estimate: Motor, reference: Motor) -> tuple[float, FloatArray]:
    """How far one turn takes orientations to the reference's, and what it leaves of each pose.

    The turn is of the world (an alignment by few positions turns it at will) or of the moving frame
    (wrong extrinsics), whichever leaves less: the mean of rotations in the sense of least squares.

    Returns:
        its angle, and the angles ``(P,)`` that are left, in radians.

    Source: Moakher 2002 (means of rotations).

    Examples:
        >>> from motorcade.fusion.metrics.poses.pose_error import constant_rotation
        >>> from motorcade.ga import Motor
        >>> true = Motor.from_euler_translation([[0.0, 0, 0], [1.0, 0, 0], [0, 0, 1.0]], [0, 0, 0])
        >>> tilted_world = Motor.from_euler_translation([0.01, 0, 0], [0, 0, 0])
        >>> constant_rad, rest_rad = constant_rotation(tilted_world @ true, true)
        >>> round(constant_rad, 6), bool(rest_rad.max() < 1e-9)
        (0.01, True)
    """
    back, theirs = estimate.rotor.inverse(), reference.rotor
    candidates = []
    for apart in (theirs @ back, back @ theirs):  # of the world, of the moving frame
        left, _, right = np.linalg.svd(apart.as_matrix().sum(axis=0))
        sign = np.linalg.det(left @ right)
        turn = Rotor.from_matrix(left @ np.diag([1.0, 1.0, sign]) @ right)
        candidates.append((float(turn.angle()), (apart @ turn.inverse()).angle()))
    constant, rest_rad = min(candidates, key=lambda candidate: float(np.sum(candidate[1] ** 2)))
    return constant, rest_rad
