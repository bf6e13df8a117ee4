"""Unit quaternions ``(*, 4)`` in the order w, x, y, z, as practitioners write them.

Hamilton's product, active rotations: ``q x q*`` rotates the vector ``x``. ``q`` and ``-q`` are the
same rotation. A pose is a quaternion beside a translation, and the two are interpolated apart.
Angles in radians, batch in front; shapes broadcast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga.arrays import FloatArray, checked_floats

# Below this angle between two quaternions the sines of slerp cancel, and the chord is the arc.
_PARALLEL_RAD = 1e-8
_MEAN_STEPS = 100


def quaternion_multiply(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Hamilton's product ``a b``, ``(*, 4)``: as rotations, ``b`` first.

    Raises:
        ValueError: wrong last dimension, NaN or infinity.

    Examples:
        >>> from motorcade.ga.classical import quaternion_multiply
        >>> quaternion_multiply([0, 1, 0, 0], [0, 0, 1, 0])  # i j = k
        array([0., 0., 0., 1.])
    """
    aw, ax, ay, az = np.moveaxis(checked_floats(a, "a", (4,)), -1, 0)
    bw, bx, by, bz = np.moveaxis(checked_floats(b, "b", (4,)), -1, 0)
    return np.stack([
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ], axis=-1)  # fmt: skip


def nearest_sign(components: ArrayLike, reference: ArrayLike) -> FloatArray:
    """Quaternions ``(*, 4)`` or dual quaternions ``(*, 8)``, negated where they oppose a reference.

    What decides is the dot product of the first four components; where it is 0 nothing changes.

    Raises:
        ValueError: NaN or infinity.

    Examples:
        >>> from motorcade.ga.classical import nearest_sign
        >>> nearest_sign([-0.8, 0.0, 0.0, -0.6], [1.0, 0.0, 0.0, 0.0])
        array([ 0.8, -0. , -0. ,  0.6])
    """
    values = checked_floats(components, "components", ())
    near = checked_floats(reference, "reference", ())
    dot = np.sum(values[..., :4] * near[..., :4], axis=-1, keepdims=True)
    return np.where(dot < 0.0, -values, values)


def quaternion_conjugate(q: ArrayLike) -> FloatArray:
    """The rotation undone, ``(*, 4)``.

    Examples:
        >>> from motorcade.ga.classical import quaternion_conjugate
        >>> quaternion_conjugate([0.5, 0.5, 0.5, 0.5])
        array([ 0.5, -0.5, -0.5, -0.5])
    """
    values = checked_floats(q, "q", (4,))
    return np.concatenate([values[..., :1], -values[..., 1:]], axis=-1)


def quaternion_normalize(q: ArrayLike) -> FloatArray:
    """Divide by the norm, ``(*, 4)``.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or a zero quaternion.

    Examples:
        >>> from motorcade.ga.classical import quaternion_normalize
        >>> quaternion_normalize([3, 0, 0, 4])
        array([0.6, 0. , 0. , 0.8])
    """
    values = checked_floats(q, "q", (4,))
    if not np.all(np.any(values != 0.0, axis=-1)):
        raise ValueError("q: expected non-zero quaternions, got a zero one")
    near_one = np.ldexp(values, -size_exponent(values))
    unit: FloatArray = near_one / np.linalg.norm(near_one, axis=-1, keepdims=True)
    return unit


def size_exponent(numbers: FloatArray) -> NDArray[np.int32]:
    """The power of two ``(*, 1)`` just above the largest of numbers ``(*, n)``.

    Divided by it, which rounds nothing, their squares neither overflow nor vanish.
    """
    exponent: NDArray[np.int32] = np.frexp(np.max(np.abs(numbers), axis=-1, keepdims=True))[1]
    return exponent


def quaternion_apply(q: ArrayLike, points: ArrayLike) -> FloatArray:
    """Rotate points ``(*, 3)`` by ``q x q*``.

    Examples:
        >>> from motorcade.ga.classical import quaternion_apply
        >>> quaternion_apply([0, 0, 0, 1], [1, 2, 3])  # half a turn about z
        array([-1., -2.,  3.])
    """
    x = checked_floats(points, "points", (3,))
    pure = np.concatenate([np.zeros((*x.shape[:-1], 1)), x], axis=-1)
    return quaternion_multiply(quaternion_multiply(q, pure), quaternion_conjugate(q))[..., 1:]


def quaternion_from_rotation_vector(vector_rad: ArrayLike) -> FloatArray:
    """Quaternions ``(*, 4)`` from axis times angle ``(*, 3)`` in radians.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.classical import quaternion_from_rotation_vector
        >>> quaternion_from_rotation_vector([0, 0, np.pi]).round(6)
        array([0., 0., 0., 1.])
    """
    vector = checked_floats(vector_rad, "vector_rad", (3,))
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * vector], axis=-1)


def quaternion_as_rotation_vector(q: ArrayLike) -> FloatArray:
    """Axis times angle ``(*, 3)`` in radians, of length at most π.

    Examples:
        >>> from motorcade.ga.classical import quaternion_as_rotation_vector
        >>> quaternion_as_rotation_vector([0, 0, 0, 1])
        array([0.        , 0.        , 3.14159265])
    """
    values = checked_floats(q, "q", (4,))
    values = np.where(values[..., :1] < 0.0, -values, values)
    sine = np.linalg.norm(values[..., 1:], axis=-1, keepdims=True)
    ratio = np.arctan2(sine, values[..., :1]) / np.where(sine > 0.0, sine, 1.0)
    return np.where(sine > 0.0, 2.0 * ratio, 2.0) * values[..., 1:]


def quaternion_as_matrix(q: ArrayLike) -> FloatArray:
    """Rotation matrices ``(*, 3, 3)`` that act on columns.

    Examples:
        >>> from motorcade.ga.classical import quaternion_as_matrix
        >>> quaternion_as_matrix([0, 0, 0, 1])
        array([[-1.,  0.,  0.],
               [ 0., -1.,  0.],
               [ 0.,  0.,  1.]])
    """
    w, x, y, z = np.moveaxis(checked_floats(q, "q", (4,)), -1, 0)
    entries = [
        w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z,
    ]  # fmt: skip
    return np.stack(entries, axis=-1).reshape(*w.shape, 3, 3)


def quaternion_from_matrix(matrix: ArrayLike) -> FloatArray:
    """Quaternions ``(*, 4)`` of rotation matrices ``(*, 3, 3)``, by Shepperd's four cases.

    The sign is that of the largest component: positive. The matrix is taken for a rotation.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.classical import quaternion_from_matrix
        >>> quaternion_from_matrix(np.diag([-1, -1, 1]))
        array([0., 0., 0., 1.])
    """
    m = checked_floats(matrix, "matrix", (3, 3))
    d = np.diagonal(m, axis1=-2, axis2=-1)
    trace = d.sum(axis=-1)
    largest = np.argmax(np.concatenate([trace[..., None], d], axis=-1), axis=-1)
    x, y, z = (m[..., k, j] - m[..., j, k] for j, k in ((1, 2), (2, 0), (0, 1)))
    yz, zx, xy = (m[..., k, j] + m[..., j, k] for j, k in ((1, 2), (2, 0), (0, 1)))
    w2, (x2, y2, z2) = 1 + trace, np.moveaxis(1 - trace[..., None] + 2 * d, -1, 0)
    cases = ([w2, x, y, z], [x, x2, xy, zx], [y, xy, y2, yz], [z, zx, yz, z2])
    picked = [np.choose(largest, [case[component] for case in cases]) for component in range(4)]
    return quaternion_normalize(np.stack(picked, axis=-1))


def quaternion_slerp(
    a: ArrayLike, b: ArrayLike, fraction: ArrayLike, short_way: bool = True
) -> FloatArray:
    """Spherical interpolation ``(*, 4)`` (Shoemake, 1985); ``fraction (*)`` broadcasts.

    With ``short_way`` the second quaternion is negated where the dot product is negative. Between
    opposite quaternions (the long way round from a rotation to itself) the path is undefined.

    Examples:
        >>> from motorcade.ga.classical import quaternion_slerp
        >>> quaternion_slerp([1, 0, 0, 0], [0, 0, 0, 1], 1 / 3).round(4)  # 60° about z
        array([0.866, 0.   , 0.   , 0.5  ])
    """
    first, second, steps = _pair(a, b, fraction, short_way)
    angle = 2.0 * np.arctan2(
        np.linalg.norm(second - first, axis=-1, keepdims=True),
        np.linalg.norm(second + first, axis=-1, keepdims=True),
    )
    close = angle < _PARALLEL_RAD
    safe = np.where(close, 1.0, angle)
    left = np.where(close, 1.0 - steps, np.sin((1.0 - steps) * safe) / np.sin(safe))
    right = np.where(close, steps, np.sin(steps * safe) / np.sin(safe))
    return quaternion_normalize(left * first + right * second)


def quaternion_nlerp(
    a: ArrayLike, b: ArrayLike, fraction: ArrayLike, short_way: bool = True
) -> FloatArray:
    """Linear interpolation and division by the norm, ``(*, 4)``: same path, uneven speed.

    Examples:
        >>> from motorcade.ga.classical import quaternion_nlerp
        >>> quaternion_nlerp([1, 0, 0, 0], [0, 0, 0, 1], 1 / 3).round(4)  # 53° about z
        array([0.8944, 0.    , 0.    , 0.4472])
    """
    first, second, steps = _pair(a, b, fraction, short_way)
    return quaternion_normalize((1.0 - steps) * first + steps * second)


def quaternion_mean(q: ArrayLike, weights: ArrayLike) -> FloatArray:
    """The mean rotation of ``(*, K, 4)`` with shares ``(*, K)`` that sum to one, to ``(*, 4)``.

    Of two it is slerp. Of more it is found by steps of the weighted rotation vectors (Buss and
    Fillmore, 2001) from the first of the K, until none is longer than 1e-12 rad.

    Raises:
        ValueError: wrong dimensions, NaN or infinity, or rotations so far apart that the steps do
            not settle within 100.

    Examples:
        >>> from motorcade.ga.classical import quaternion_mean
        >>> quaternion_mean([[1, 0, 0, 0], [0, 0, 0, 1]], [0.75, 0.25]).round(4)  # 45° about z
        array([0.9239, 0.    , 0.    , 0.3827])
    """
    values, share = checked_floats(q, "q", (4,)), checked_floats(weights, "weights", ())
    if values.shape[-2:-1] == (2,):
        return quaternion_slerp(values[..., 0, :], values[..., 1, :], share[..., 1])
    middle = values[..., 0, :]
    for _ in range(_MEAN_STEPS):
        away = quaternion_multiply(quaternion_conjugate(middle)[..., None, :], values)
        step = np.sum(share[..., None] * quaternion_as_rotation_vector(away), axis=-2)
        middle = quaternion_multiply(middle, quaternion_from_rotation_vector(step))
        if np.max(np.abs(step), initial=0.0) <= 1e-12:
            return quaternion_normalize(middle)
    raise ValueError(
        "q: expected rotations close enough to have one mean, got steps of "
        f"{float(np.max(np.abs(step))):.3g} rad after {_MEAN_STEPS} rounds"
    )


def _pair(
    a: ArrayLike, b: ArrayLike, fraction: ArrayLike, short_way: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    first, second = checked_floats(a, "a", (4,)), checked_floats(b, "b", (4,))
    steps = checked_floats(fraction, "fraction", ())[..., None]
    return first, nearest_sign(second, first) if short_way else second, steps
