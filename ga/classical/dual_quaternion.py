"""Unit dual quaternions ``(*, 8)``: real part w, x, y, z, then dual part w, x, y, z.

``q = r + ½ ε t r`` turns by ``r``, then moves by ``t`` (metres). Blends after Kavan, Collins,
Zara, O'Sullivan, "Skinning with dual quaternions" (2007). Batch in front; shapes broadcast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.classical.quaternion import (
    nearest_sign,
    quaternion_apply,
    quaternion_conjugate,
    quaternion_multiply,
    size_exponent,
)

# Below this sine of half the angle a screw has no axis left and is a plain translation.
_NO_AXIS = 1e-12
_MEAN_STEPS = 100


def dual_quaternion_from_quaternion_translation(
    wxyz: ArrayLike, translation_m: ArrayLike
) -> FloatArray:
    """Dual quaternions ``(*, 8)`` from unit quaternions ``(*, 4)`` and translations ``(*, 3)``.

    Examples:
        >>> from motorcade.ga.classical import dual_quaternion_from_quaternion_translation
        >>> dual_quaternion_from_quaternion_translation([1, 0, 0, 0], [2, 0, 0])  # 2 m along x
        array([1., 0., 0., 0., 0., 1., 0., 0.])
    """
    real = checked_floats(wxyz, "wxyz", (4,))
    t = checked_floats(translation_m, "translation_m", (3,))
    pure = np.concatenate([np.zeros((*t.shape[:-1], 1)), t], axis=-1)
    dual = 0.5 * quaternion_multiply(pure, real)
    return np.concatenate([np.broadcast_to(real, dual.shape), dual], axis=-1)


def dual_quaternion_as_quaternion_translation(q: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Unit quaternions ``(*, 4)`` and translations ``(*, 3)`` in metres.

    Examples:
        >>> from motorcade.ga.classical import dual_quaternion_as_quaternion_translation
        >>> world_T_camera = [1, 0, 0, 0, 0, 1, 0, 0]
        >>> dual_quaternion_as_quaternion_translation(world_T_camera)
        (array([1., 0., 0., 0.]), array([2., 0., 0.]))
    """
    values = checked_floats(q, "q", (8,))
    translation = 2.0 * quaternion_multiply(values[..., 4:], quaternion_conjugate(values[..., :4]))
    return values[..., :4].copy(), translation[..., 1:]


def dual_quaternion_multiply(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """The product ``a b``, ``(*, 8)``: as motions, ``b`` first.

    Raises:
        ValueError: wrong last dimension, NaN or infinity.

    Examples:
        >>> from motorcade.ga.classical import dual_quaternion_multiply
        >>> ahead = [1, 0, 0, 0, 0, 0.5, 0, 0]  # 1 m along x
        >>> dual_quaternion_multiply(ahead, ahead)
        array([1., 0., 0., 0., 0., 1., 0., 0.])
    """
    first, second = checked_floats(a, "a", (8,)), checked_floats(b, "b", (8,))
    real = quaternion_multiply(first[..., :4], second[..., :4])
    dual = quaternion_multiply(first[..., :4], second[..., 4:]) + quaternion_multiply(
        first[..., 4:], second[..., :4]
    )
    return np.concatenate([real, dual], axis=-1)


def dual_quaternion_conjugate(q: ArrayLike) -> FloatArray:
    """Both parts conjugated, ``(*, 8)``: the inverse of a unit dual quaternion.

    Examples:
        >>> from motorcade.ga.classical import dual_quaternion_conjugate
        >>> dual_quaternion_conjugate([1, 0, 0, 0, 0, 0.5, 0, 0])
        array([ 1. , -0. , -0. , -0. ,  0. , -0.5, -0. , -0. ])
    """
    values = checked_floats(q, "q", (8,))
    return np.concatenate(
        [quaternion_conjugate(values[..., :4]), quaternion_conjugate(values[..., 4:])], axis=-1
    )


def dual_quaternion_normalize(q: ArrayLike) -> FloatArray:
    """Divide by the dual norm, ``(*, 8)``: unit real part, dual part at right angles to it.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or a zero real part.

    Examples:
        >>> from motorcade.ga.classical import dual_quaternion_normalize
        >>> dual_quaternion_normalize([2, 0, 0, 0, 1, 1, 0, 0])
        array([1. , 0. , 0. , 0. , 0. , 0.5, 0. , 0. ])
    """
    values = checked_floats(q, "q", (8,))
    if not np.all(np.any(values[..., :4] != 0.0, axis=-1)):
        raise ValueError("q: expected a non-zero real part, got a zero one")
    near_one = np.ldexp(values, -size_exponent(values[..., :4]))
    norm = np.linalg.norm(near_one[..., :4], axis=-1, keepdims=True)
    real, dual = near_one[..., :4] / norm, near_one[..., 4:] / norm
    dual = dual - np.sum(real * dual, axis=-1, keepdims=True) * real
    return np.concatenate([real, dual], axis=-1)


def dual_quaternion_apply(q: ArrayLike, points: ArrayLike) -> FloatArray:
    """Move points ``(*, 3)`` in metres.

    Examples:
        >>> from motorcade.ga.classical import (
        ...     dual_quaternion_apply,
        ...     dual_quaternion_from_quaternion_translation,
        ... )
        >>> world_T_camera = dual_quaternion_from_quaternion_translation([0, 0, 0, 1], [1, 0, 0])
        >>> dual_quaternion_apply(world_T_camera, [2, 0, 0])
        array([-1.,  0.,  0.])
    """
    rotation, translation = dual_quaternion_as_quaternion_translation(q)
    return quaternion_apply(rotation, points) + translation


def dual_quaternion_blend(q: ArrayLike, weights: ArrayLike) -> FloatArray:
    """Dual quaternion linear blending of ``(*, K, 8)`` with weights ``(*, K)``, to ``(*, 8)``.

    Signs are taken from the first of the K, so each is blended the short way from it. The path
    between two is the screw's, its speed only nearly constant.

    Raises:
        ValueError: wrong dimensions, NaN or infinity, or weights that cancel to zero.

    Examples:
        >>> from motorcade.ga.classical import (
        ...     dual_quaternion_blend,
        ...     dual_quaternion_from_quaternion_translation,
        ... )
        >>> wxyz = [[1, 0, 0, 0], [0, 0, 0, 1]]
        >>> ends = dual_quaternion_from_quaternion_translation(wxyz, [2, 0, 0])
        >>> dual_quaternion_blend(ends, [0.5, 0.5]).round(4)
        array([ 0.7071,  0.    ,  0.    ,  0.7071,  0.    ,  0.7071, -0.7071,
                0.    ])
    """
    values = checked_floats(q, "q", (8,))
    share = checked_floats(weights, "weights", ())
    if values.ndim < 2 or share.ndim < 1 or share.shape[-1] != values.shape[-2]:
        raise ValueError(
            f"weights: expected (*, K) for q of shape (*, K, 8) = {values.shape}, got {share.shape}"
        )
    signed = nearest_sign(values, values[..., :1, :])
    return dual_quaternion_normalize(np.sum(share[..., None] * signed, axis=-2))


def dual_quaternion_exp(log: ArrayLike) -> FloatArray:
    """Dual quaternions ``(*, 8)`` from pure ones ``(*, 6)``: real x, y, z, then dual x, y, z.

    The real part is half the angle times the screw's axis ``l``; the dual part is half the slide
    times ``l`` and half the angle times the moment. Half-angles below 1e-12 count as none.

    Examples:
        >>> from motorcade.ga.classical import dual_quaternion_exp
        >>> dual_quaternion_exp([0, 0, 0, 1, 0, 0])  # 2 m along x
        array([ 1.,  0.,  0.,  0., -0.,  1.,  0.,  0.])
    """
    values = checked_floats(log, "log", (6,))
    real, dual = values[..., :3], values[..., 3:]
    half = np.linalg.norm(real, axis=-1, keepdims=True)
    turns = half > _NO_AXIS
    safe = np.where(turns, half, 1.0)
    axis = real / safe
    push = np.sum(axis * dual, axis=-1, keepdims=True)
    moment = (dual - push * axis) / safe
    cosine, sine = np.cos(half), np.sin(half)
    parts = [cosine, sine * axis, -push * sine, sine * moment + push * cosine * axis]
    screw = np.concatenate(parts, axis=-1)
    ones = np.ones_like(half)
    slide = np.concatenate([ones, real, -np.sum(real * dual, -1, keepdims=True), dual], axis=-1)
    return np.where(turns, screw, slide)


def dual_quaternion_log(q: ArrayLike) -> FloatArray:
    """Pure dual quaternions ``(*, 6)`` of unit ones, the mirror of `dual_quaternion_exp`.

    The sign that turns by at most π is taken.

    Examples:
        >>> from motorcade.ga.classical import dual_quaternion_log
        >>> dual_quaternion_log([1, 0, 0, 0, 0, 1, 0, 0])
        array([0., 0., 0., 1., 0., 0.])
    """
    values = checked_floats(q, "q", (8,))
    return _log(np.where(values[..., :1] < 0.0, -values, values))


def _log(values: FloatArray) -> FloatArray:
    """The logarithm of the sign that is given: turns by up to 2π."""
    cosine, vector, dual = values[..., :1], values[..., 1:4], values[..., 5:]
    sine = np.linalg.norm(vector, axis=-1, keepdims=True)
    turns = sine > _NO_AXIS
    safe = np.where(turns, sine, 1.0)
    axis, half = vector / safe, np.arctan2(sine, cosine)
    push = -values[..., 4:5] / safe
    moment = (dual - push * cosine * axis) / safe
    screw = np.concatenate([half * axis, push * axis + half * moment], axis=-1)
    return np.where(turns, screw, np.concatenate([vector, dual], axis=-1))


def dual_quaternion_screw(
    a: ArrayLike, b: ArrayLike, fraction: ArrayLike, short_way: bool = True
) -> FloatArray:
    """Screw interpolation (ScLERP), ``(*, 8)``: ``a (a* b)^fraction``; ``fraction (*)`` broadcasts.

    A motion that turns by less than 2e-12 rad is treated as a translation.

    Examples:
        >>> from motorcade.ga.classical import (
        ...     dual_quaternion_from_quaternion_translation,
        ...     dual_quaternion_screw,
        ... )
        >>> start = dual_quaternion_from_quaternion_translation([1, 0, 0, 0], [0, 0, 0])
        >>> end = dual_quaternion_from_quaternion_translation([0, 0, 0, 1], [0, 0, 3])
        >>> dual_quaternion_screw(start, end, 1 / 3).round(4)  # 60° about z, 1 m along it
        array([ 0.866,  0.   ,  0.   ,  0.5  , -0.25 ,  0.   ,  0.   ,  0.433])
    """
    steps = checked_floats(fraction, "fraction", ())[..., None]
    between = dual_quaternion_multiply(dual_quaternion_conjugate(a), b)
    if short_way:
        between = np.where(between[..., :1] < 0.0, -between, between)
    return dual_quaternion_multiply(a, dual_quaternion_exp(steps * _log(between)))


def dual_quaternion_mean(q: ArrayLike, weights: ArrayLike) -> FloatArray:
    """The mean of ``(*, K, 8)`` with shares ``(*, K)`` that sum to one, to ``(*, 8)``.

    Dual quaternion iterative blending: from the linear blend, steps by the weighted logarithm
    until none is left (1e-12 half radians or half metres). Of two it is the screw interpolation.

    Raises:
        ValueError: as `dual_quaternion_blend`, or rotations so far apart that the steps do not
            settle within 100.

    Examples:
        >>> from motorcade.ga.classical import (
        ...     dual_quaternion_from_quaternion_translation,
        ...     dual_quaternion_mean,
        ... )
        >>> wxyz, translation_m = [[1, 0, 0, 0], [0, 0, 0, 1]], [[0, 0, 0], [0, 0, 3]]
        >>> ends = dual_quaternion_from_quaternion_translation(wxyz, translation_m)
        >>> dual_quaternion_mean(ends, [2 / 3, 1 / 3]).round(4)
        array([ 0.866,  0.   ,  0.   ,  0.5  , -0.25 ,  0.   ,  0.   ,  0.433])
    """
    values, share = checked_floats(q, "q", (8,)), checked_floats(weights, "weights", ())
    if values.shape[-2:-1] == (2,):
        return dual_quaternion_screw(values[..., 0, :], values[..., 1, :], share[..., 1])
    middle = dual_quaternion_blend(values, share)
    for _ in range(_MEAN_STEPS):
        away = dual_quaternion_multiply(dual_quaternion_conjugate(middle)[..., None, :], values)
        step = np.sum(share[..., None] * dual_quaternion_log(away), axis=-2)
        middle = dual_quaternion_multiply(middle, dual_quaternion_exp(step))
        if np.max(np.abs(step), initial=0.0) <= 1e-12:
            return middle
    raise ValueError(
        "q: expected rotations close enough to have one mean, got steps of "
        f"{float(np.max(np.abs(step))):.3g} after {_MEAN_STEPS} rounds"
    )
