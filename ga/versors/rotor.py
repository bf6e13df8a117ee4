"""Rotor: rotations as ``(*, 4)`` coefficients on ``1, e23, e31, e12``.

``R = exp(-½ φ I₃ u) = cos ½φ - sin ½φ (u_x e23 + u_y e31 + u_z e12)`` turns by the right-handed
angle ``φ`` about the unit axis ``u``; ``X' = R X ~R``. The quaternion wxyz of the same rotation
is ``(m0, -m1, -m2, -m3)``. Angles in radians..
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, broadcast_batch, checked_floats
from motorcade.ga.kernels import ROTORS
from motorcade.ga.versors.euler_angles import euler_from_matrix, matrix_from_euler
from motorcade.ga.versors.versor import Versor

# How far R^T R of a given matrix may be from the identity: room for six printed digits.
_MATRIX_TOLERANCE = 1e-5
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


class Rotor(Versor):
    """Rotations about the origin, ``coefficients (*, 4)`` on ``1, e23, e31, e12``.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or a norm more than 1e-6 from 1.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Rotor
        >>> quarter = Rotor.from_rotation_vector([0.0, 0.0, np.pi / 2])
        >>> np.round(quarter.apply([1.0, 0.0, 0.0]), 6) + 0.0
        array([0., 1., 0.])
        >>> (quarter @ quarter).isclose(Rotor.from_euler([0.0, 0.0, np.pi]))
        np.True_
        >>> path = Rotor.identity().interpolate(quarter, [0.0, 0.5, 1.0])
        >>> np.round(np.degrees(path.angle()))
        array([ 0., 45., 90.])
    """

    _size = 4
    _log_size = 3
    _kernels = ROTORS

    @classmethod
    def normalize(cls, coefficients: ArrayLike) -> Rotor:
        """Divide even elements ``(*, 4)`` by their norm.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a zero element.
        """
        given = cls._checked(coefficients, "Rotor.normalize(coefficients)", (4,))
        size = np.max(np.abs(given), axis=-1, keepdims=True)
        if not np.all(size > 0.0):
            raise ValueError(
                "Rotor.normalize(coefficients): expected non-zero elements, got "
                f"{int(np.count_nonzero(size == 0.0))} zero ones"
            )
        scaled = given / size
        return cls._trusted(scaled / np.sqrt(np.sum(scaled**2, axis=-1, keepdims=True)))

    @classmethod
    def random(cls, rng: np.random.Generator, shape: tuple[int, ...] = ()) -> Rotor:
        """Rotations drawn uniformly from all orientations."""
        return cls.normalize(rng.standard_normal((*shape, 4)))

    def apply(self, points: ArrayLike) -> FloatArray:
        """Rotate points or vectors ``(*, 3)``; batch shapes broadcast.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, shapes that do not broadcast.
        """
        x = checked_floats(points, "Rotor.apply(points)", (3,)).astype(self.dtype, copy=False)
        broadcast_batch("Rotor.apply", self.shape, x.shape[:-1])
        w, v = self.coefficients[..., :1], self.coefficients[..., 1:]
        turned = np.cross(v, x)
        moved: FloatArray = x + 2.0 * (np.cross(v, turned) - w * turned)
        return moved

    def angle(self) -> FloatArray:
        """Angle of the rotation, ``(*)``, in [0, π] radians."""
        sine = np.sqrt(np.sum(self.coefficients[..., 1:] ** 2, axis=-1))
        half: FloatArray = np.arctan2(sine, np.abs(self.coefficients[..., 0]))
        return 2.0 * half

    # Conversions -------------------------------------------------------------------------------

    @classmethod
    def from_quaternion(cls, wxyz: ArrayLike) -> Rotor:
        """Rotors from unit quaternions ``(*, 4)`` in the order w, x, y, z.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a norm more than 1e-6 (float32:
                1e-5) from 1.
        """
        given = cls._checked(wxyz, "Rotor.from_quaternion(wxyz)", (4,))
        with np.errstate(over="ignore"):  # an infinite norm is refused like any other
            norm = np.sqrt(np.sum(given**2, axis=-1))
        worst = float(np.max(np.abs(norm - 1.0), initial=0.0))
        tolerance = cls._tolerance(given)
        if worst > tolerance:
            raise ValueError(
                "Rotor.from_quaternion(wxyz): expected unit quaternions (norm within "
                f"{tolerance:g} of 1), got a norm off by {worst:.3g}; divide by it first"
            )
        return cls._trusted(given * _CONJUGATE.astype(given.dtype))

    def as_quaternion(self) -> FloatArray:
        """Unit quaternions ``(*, 4)`` in the order w, x, y, z, with the rotor's own sign."""
        quaternion: FloatArray = self.coefficients * _CONJUGATE.astype(self.dtype)
        return quaternion

    @classmethod
    def from_rotation_vector(cls, vector_rad: ArrayLike) -> Rotor:
        """Rotors from rotation vectors ``(*, 3)``: axis times right-handed angle in radians."""
        vector = cls._checked(vector_rad, "Rotor.from_rotation_vector(vector_rad)", (3,))
        return cls._trusted(ROTORS.exp(-0.5 * vector))

    def as_rotation_vector(self) -> FloatArray:
        """Rotation vectors ``(*, 3)`` of length at most π; at π the sign of `self` decides."""
        return -2.0 * self.log()

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Rotor:
        """Rotors from rotation matrices ``(*, 3, 3)`` that act on columns.

        Raises:
            ValueError: wrong shape, NaN or infinity, or ``R^T R`` more than 1e-5 from the
                identity, or a reflection.
        """
        given = checked_floats(matrix, "Rotor.from_matrix(matrix)", (3, 3))
        _check_rotation(given)
        return cls._of(cls.normalize(_quaternion_column(given) * _CONJUGATE).coefficients, matrix)

    def as_matrix(self) -> FloatArray:
        """Rotation matrices ``(*, 3, 3)`` that act on columns."""
        w, x, y, z = np.ascontiguousarray(np.moveaxis(self.as_quaternion(), -1, 0))
        matrix = np.empty((*self.shape, 3, 3), self.dtype)
        matrix[..., 0, 0] = 1 - 2 * (y * y + z * z)
        matrix[..., 0, 1] = 2 * (x * y - w * z)
        matrix[..., 0, 2] = 2 * (x * z + w * y)
        matrix[..., 1, 0] = 2 * (x * y + w * z)
        matrix[..., 1, 1] = 1 - 2 * (x * x + z * z)
        matrix[..., 1, 2] = 2 * (y * z - w * x)
        matrix[..., 2, 0] = 2 * (x * z - w * y)
        matrix[..., 2, 1] = 2 * (y * z + w * x)
        matrix[..., 2, 2] = 1 - 2 * (x * x + y * y)
        return matrix

    @classmethod
    def from_euler(cls, angles_rad: ArrayLike, sequence: str = "xyz") -> Rotor:
        """Rotors from intrinsic Euler angles ``(*, 3)`` in the order of `sequence`.

        ``"xyz"`` is x-y′-z″: ``R = R_x(a) R_y(b) R_z(c)``.

        Raises:
            ValueError: an unknown sequence, wrong last dimension, NaN or infinity.
        """
        made = cls.from_matrix(matrix_from_euler(angles_rad, sequence))
        return cls._of(made.coefficients, angles_rad)

    def as_euler(self, sequence: str = "xyz") -> FloatArray:
        """Intrinsic Euler angles ``(*, 3)`` in radians, first and third in [-π, π].

        The middle angle is in [-π/2, π/2], or in [0, π] where the sequence ends as it began. At
        gimbal lock only a combination of first and third is defined: the first is then 0.
        """
        return euler_from_matrix(self.as_matrix(), sequence)


def _check_rotation(matrix: FloatArray) -> None:
    with np.errstate(over="ignore", invalid="ignore"):
        gram = np.swapaxes(matrix, -1, -2) @ matrix
        worst = float(np.max(np.abs(gram - np.eye(3)), initial=0.0))
    if not worst <= _MATRIX_TOLERANCE:
        raise ValueError(
            f"Rotor.from_matrix(matrix): expected R^T R within {_MATRIX_TOLERANCE:g} of the "
            f"identity, got a difference of {worst:.3g}; orthonormalise it first"
        )
    if np.any(np.linalg.det(matrix) < 0.0):
        raise ValueError("Rotor.from_matrix(matrix): expected determinant +1, got a reflection")


def _quaternion_column(m: FloatArray) -> FloatArray:
    """The longest column of ``4 q q^T``, wxyz: never near zero, so no angle is special."""
    d0, d1, d2 = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    difference, total = m - np.swapaxes(m, -1, -2), m + np.swapaxes(m, -1, -2)
    wx, wy, wz = difference[..., 2, 1], difference[..., 0, 2], difference[..., 1, 0]
    xy, xz, yz = total[..., 1, 0], total[..., 2, 0], total[..., 2, 1]
    columns = np.stack([
        np.stack([1 + d0 + d1 + d2, wx, wy, wz], axis=-1),
        np.stack([wx, 1 + d0 - d1 - d2, xy, xz], axis=-1),
        np.stack([wy, xy, 1 - d0 + d1 - d2, yz], axis=-1),
        np.stack([wz, xz, yz, 1 - d0 - d1 + d2], axis=-1),
    ], axis=-2)  # fmt: skip
    longest = np.argmax(np.diagonal(columns, axis1=-2, axis2=-1), axis=-1)
    return np.take_along_axis(columns, longest[..., None, None], axis=-2)[..., 0, :]
