"""Euler angles to and from rotation matrices, in any of the twelve sequences.

A sequence is three lower-case letters in the order of the angles, and intrinsic: ``"xyz"`` is
x-y′-z″, ``R = R_x(a) R_y(b) R_z(c)`` acting on columns. With ``extrinsic`` the axes stay fixed, and
the same letters mean ``R_z(c) R_y(b) R_x(a)``. All twelve sequences work. Capitals are refused:
scipy writes intrinsic sequences with them, and others extrinsic ones. Angles in radians, batch in
front.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats, sealed

__all__ = [
    "LOCKED",
    "SEQUENCES",
    "SequenceOperands",
    "axes_of",
    "euler_from_matrix",
    "lock_levers",
    "matrix_from_euler",
    "sequence_operands",
]

SEQUENCES = (
    "xyz", "yzx", "zxy", "xzy", "yxz", "zyx",
    "xyx", "xzx", "yxy", "yzy", "zxz", "zyz",
)  # fmt: skip
LOCKED = 4e-15
"""Where the lever arm of the first angle is below this, the angle is noise: gimbal lock."""


def axes_of(sequence: str) -> tuple[int, int, int, float]:
    """First, second and remaining axis by number, and +1 where they are in cyclic order, else -1.

    Raises:
        ValueError: an unknown sequence.

    Examples:
        >>> from motorcade.ga.versors.euler_angles import axes_of
        >>> axes_of("zxz")
        (2, 0, 1, 1.0)
    """
    if sequence not in SEQUENCES:
        raise ValueError(f"sequence: expected one of {', '.join(SEQUENCES)}, got {sequence!r}")
    i, j = "xyz".index(sequence[0]), "xyz".index(sequence[1])
    return i, j, 3 - i - j, 1.0 if (j - i) % 3 == 1 else -1.0


class SequenceOperands(NamedTuple):
    """A sequence as the kernels take it, by precision.

    `axes` are its three axes as unit vectors ``(9,)``; `frame` has the first, the second and the
    remaining axis, and their handedness ``(10,)``. With `proper` the third axis is the first one.
    """

    axes: dict[np.dtype[Any], FloatArray]
    frame: dict[np.dtype[Any], FloatArray]
    proper: bool


def sequence_operands(sequence: str) -> SequenceOperands:
    """What the kernels take for a sequence.

    Raises:
        ValueError: an unknown sequence.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.versors.euler_angles import sequence_operands
        >>> sequence_operands("zyx").frame[np.dtype(float)]
        array([ 0.,  0.,  1.,  0.,  1.,  0.,  1.,  0.,  0., -1.])
    """
    if sequence not in SEQUENCES:
        axes_of(sequence)
    return _OPERANDS[sequence]


def _operands(sequence: str) -> SequenceOperands:
    i, j, k, cyclic = axes_of(sequence)
    unit = np.eye(3)
    axes = unit[["xyz".index(letter) for letter in sequence]].ravel()
    frame = np.append(unit[[i, j, k]], cyclic)
    kinds = np.dtype(np.float32), np.dtype(np.float64)
    return SequenceOperands(
        {kind: sealed(axes.astype(kind)) for kind in kinds},
        {kind: sealed(frame.astype(kind)) for kind in kinds},
        sequence[0] == sequence[2],
    )


_OPERANDS = {sequence: _operands(sequence) for sequence in SEQUENCES}


def _turn(axis: int, angle: FloatArray) -> FloatArray:
    j, k = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((*angle.shape, 3, 3))
    matrix[..., axis, axis] = 1.0
    matrix[..., j, j] = matrix[..., k, k] = np.cos(angle)
    matrix[..., k, j] = np.sin(angle)
    matrix[..., j, k] = -matrix[..., k, j]
    return matrix


def matrix_from_euler(
    angles_rad: ArrayLike, sequence: str = "xyz", extrinsic: bool = False
) -> FloatArray:
    """Rotation matrices ``(*, 3, 3)`` from angles ``(*, 3)``.

    Raises:
        ValueError: an unknown sequence, wrong last dimension, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.versors.euler_angles import matrix_from_euler
        >>> yawed = matrix_from_euler([0.0, 0.0, np.pi / 2])
        >>> np.round(yawed @ [1.0, 0.0, 0.0], 6) + 0.0
        array([0., 1., 0.])
    """
    i, j, _, _ = axes_of(sequence)
    angles = checked_floats(angles_rad, "angles_rad", (3,))
    if extrinsic:
        return matrix_from_euler(angles[..., ::-1], sequence[::-1])
    last = "xyz".index(sequence[2])
    return _turn(i, angles[..., 0]) @ _turn(j, angles[..., 1]) @ _turn(last, angles[..., 2])


def euler_from_matrix(
    matrix: ArrayLike, sequence: str = "xyz", extrinsic: bool = False
) -> FloatArray:
    """Angles ``(*, 3)`` of rotation matrices ``(*, 3, 3)``.

    The third angle is read from what the first leaves over, so the angles give back the matrix to
    rounding even at gimbal lock, where the first (extrinsic: the third) is set to 0. First and
    third are in [-π, π], the middle one in [-π/2, π/2], or in [0, π] where the sequence ends as it
    began.

    Raises:
        ValueError: an unknown sequence, wrong shape, NaN or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga.versors.euler_angles import euler_from_matrix, matrix_from_euler
        >>> np.round(euler_from_matrix(matrix_from_euler([0.3, -0.2, 0.1]), "zyx"), 4)
        array([ 0.0379, -0.2201,  0.2858])
    """
    if extrinsic:
        axes_of(sequence)
        return euler_from_matrix(matrix, sequence[::-1])[..., ::-1]
    i, j, k, cyclic = axes_of(sequence)
    m = checked_floats(matrix, "matrix", (3, 3))
    if sequence[0] == sequence[2]:
        lever = np.hypot(m[..., j, i], m[..., k, i])
        first = np.arctan2(m[..., j, i], -cyclic * m[..., k, i])
        middle = np.arctan2(lever, m[..., i, i])
    else:
        lever = np.hypot(m[..., j, k], m[..., k, k])
        first = np.arctan2(-cyclic * m[..., j, k], m[..., k, k])
        middle = np.arctan2(cyclic * m[..., i, k], lever)
    first = np.where(lever > LOCKED, first, 0.0)
    cosine, sine = np.cos(first)[..., None], cyclic * np.sin(first)[..., None]
    rest = cosine * m[..., j, :] + sine * m[..., k, :]
    other = k if sequence[0] == sequence[2] else i
    sign = -cyclic if other == k else cyclic
    third = np.arctan2(sign * rest[..., other], rest[..., j])
    return np.stack([first, middle, third], axis=-1)


def lock_levers(matrix: ArrayLike, sequence: str = "xyz") -> FloatArray:
    """How far rotations ``(*, 3, 3)`` are from the gimbal lock of an intrinsic sequence, ``(*)``.

    It is the sine of the angle between the first and the last axis: 1 where the three axes stand
    square on each other, 0 at gimbal lock. Noise of the rotation reaches the first and the last
    angle divided by it. The sequences ``xyx`` and ``xzx`` have the same (so for y and z): their
    first and last angles differ by a quarter turn, and nothing else.

    Raises:
        ValueError: an unknown sequence, wrong shape, NaN or infinity.

    Examples:
        >>> from motorcade.ga.versors.euler_angles import lock_levers, matrix_from_euler
        >>> up = matrix_from_euler([0.3, 1.5, 0.2])  # pitched by 86 degrees
        >>> print(f"{lock_levers(up):.2f} as x-y'-z'', {lock_levers(up, 'zyz'):.2f} as z-y'-z''")
        0.07 as x-y'-z'', 1.00 as z-y'-z''
    """
    axes_of(sequence)
    m = checked_floats(matrix, "matrix", (3, 3))
    row, column = "xyz".index(sequence[0]), "xyz".index(sequence[2])
    # The other entries of the row, since 1 - m² loses the lever's digits near 0.
    others = [m[..., row, k] for k in range(3) if k != column]
    return np.hypot(*others)
