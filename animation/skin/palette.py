"""Palettes: what every joint does to the vertices bound to it, written down as a method wants it.

========================  =====  =================================================================
``linear``                12     3×4 matrices by rows
``dual_quaternion``       8      Hamilton's dual quaternions, real wxyz, dual wxyz
``motor``                 8      CGA motors
``similarity``            12     CGA similarities, which grow as well
========================  =====  =================================================================
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray

__all__ = ["SKIN_METHODS", "SkinMethod", "checked_method", "palette"]

SkinMethod = Literal["linear", "dual_quaternion", "motor", "similarity"]
SKIN_METHODS: tuple[SkinMethod, ...] = get_args(SkinMethod)


def checked_method(method: str) -> SkinMethod:
    """The method, if it is one.

    Raises:
        ValueError: an unknown method.
    """
    for known in SKIN_METHODS:
        if method == known:
            return known
    raise ValueError(f"skin(method): expected one of {', '.join(SKIN_METHODS)}, got {method!r}")


def palette(
    skeleton: Skeleton, local_pose: Motor | Similarity, method: SkinMethod
) -> tuple[FloatArray, FloatArray | None]:
    """What each joint does to points in character space.

    Args:
        skeleton: with J joints.
        local_pose: ``(*, J)``, poses `parent_T_joint`.
        method: how it is written.

    Returns:
        entries ``(*, J, 8 or 12)``; and, where joints grow under a rigid method, their scales
        ``(*, J)``: a vertex is first grown about the character's origin, then carried rigidly.

    Raises:
        ValueError: an unknown method, a last dimension other than the number of joints.
    """
    checked_method(method)
    world, back = skeleton.world(local_pose), skeleton.rest_world_inverse
    if isinstance(world, Motor):
        motion = world @ back
        if method == "similarity":
            return Similarity.from_motor_scale(motion).coefficients, None
        return _rigid(motion, method), None
    grown = world @ Similarity.from_motor_scale(back)
    if method == "similarity":
        return grown.coefficients, None
    if method == "linear":
        return _rows(grown.as_matrix()), None
    rigid, scale = grown.as_motor_scale()
    return _rigid(rigid, method), scale


def _rigid(motion: Motor, method: SkinMethod) -> FloatArray:
    if method == "linear":
        return _rows(motion.as_matrix())
    if method == "dual_quaternion":
        return motion.as_dual_quaternion()
    return np.asarray(motion.coefficients, dtype=np.float64)


def _rows(matrices: FloatArray) -> FloatArray:
    return matrices[..., :3, :].reshape(*matrices.shape[:-2], 12)
