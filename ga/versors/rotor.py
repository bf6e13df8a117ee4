"""Rotor: rotations as ``(*, 4)`` coefficients on ``1, e23, e31, e12``.

``R = exp(-½ φ I₃ u) = cos ½φ - sin ½φ (u_x e23 + u_y e31 + u_z e12)`` turns by the right-handed
angle ``φ`` about the unit axis ``u``; ``X' = R X ~R``. The quaternion wxyz of the same rotation
is ``(m0, -m1, -m2, -m3)``. Angles in radians.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import UNIT_TOLERANCE, FloatArray, checked_floats, given_floats
from motorcade.ga.kernels import ROTORS, parts
from motorcade.ga.kernels.backend import fast_path
from motorcade.ga.versors.euler_angles import sequence_operands
from motorcade.ga.versors.versor import Versor

MATRIX_TOLERANCE = 1e-5
"""How far R^T R of a given matrix may be from the identity: room for six printed digits."""


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
    _blades = ("1", "e2^e3", "e3^e1", "e1^e2")
    _kernels = ROTORS
    _unit = "norm 1"

    @classmethod
    @fast_path("normalize", "cx", "v", above=0.0)
    def normalize(cls, coefficients: ArrayLike) -> Rotor:
        """Divide even elements ``(*, 4)`` by their norm.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a zero element.
        """
        return cls._normalized(coefficients, parts.normalized_rotor)

    @classmethod
    def random(cls, rng: np.random.Generator, shape: tuple[int, ...] = ()) -> Rotor:
        """Rotations drawn uniformly from all orientations."""
        if not isinstance(rng, np.random.Generator):
            raise TypeError(
                f"random(rng): expected a numpy.random.Generator, got {type(rng).__name__}; "
                "numpy.random.default_rng(seed) makes one"
            )
        return cls.normalize(rng.standard_normal((*shape, 4)))

    def angle(self) -> FloatArray:
        """Angle of the rotation, ``(*)``, in [0, π] radians."""
        sine = np.sqrt(np.sum(self.coefficients[..., 1:] ** 2, axis=-1))
        half: FloatArray = np.arctan2(sine, np.abs(self.coefficients[..., 0]))
        return 2.0 * half

    # Conversions -------------------------------------------------------------------------------

    @classmethod
    @fast_path("of_quaternion", "cx", "v", UNIT_TOLERANCE)
    def from_quaternion(cls, wxyz: ArrayLike) -> Rotor:
        """Rotors from unit quaternions ``(*, 4)`` in the order w, x, y, z.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a norm more than 1e-6 (float32:
                1e-5) from 1.
        """
        quaternions = given_floats(wxyz, "Rotor.from_quaternion(wxyz)", (4,))
        rotors, off = parts.rotor_of_quaternion(quaternions)
        tolerance = cls._tolerance(quaternions)
        check_quaternions(quaternions, "Rotor.from_quaternion(wxyz)", tolerance, off)
        return cls._trusted(rotors)

    @fast_path("inverse", "v", "x")
    def as_quaternion(self) -> FloatArray:
        """Unit quaternions ``(*, 4)`` in the order w, x, y, z, with the rotor's own sign."""
        return ROTORS.inverse(self.coefficients)

    @classmethod
    @fast_path("of_twist", "cx", "v")
    def from_rotation_vector(cls, vector_rad: ArrayLike) -> Rotor:
        """Rotors from rotation vectors ``(*, 3)``: axis times right-handed angle in radians."""
        return cls._trusted(cls._of_twist(vector_rad, "Rotor.from_rotation_vector(vector_rad)"))

    @fast_path("as_twist", "v", "x")
    def as_rotation_vector(self) -> FloatArray:
        """Rotation vectors ``(*, 3)`` of length at most π; at π the sign of `self` decides."""
        return ROTORS.as_twist(self.coefficients)

    @classmethod
    @fast_path("of_matrix33", "cs", "v", MATRIX_TOLERANCE)
    def from_matrix(cls, matrix: ArrayLike) -> Rotor:
        """Rotors from rotation matrices ``(*, 3, 3)`` that act on columns.

        Raises:
            ValueError: wrong shape, NaN or infinity, or ``R^T R`` more than 1e-5 from the
                identity, or a reflection.
        """
        matrices = given_floats(matrix, "Rotor.from_matrix(matrix)", (3, 3))
        rotors, off = parts.rotor_of_matrix(matrices)
        if not off <= MATRIX_TOLERANCE:
            check_rotation(checked_floats(matrices, "Rotor.from_matrix(matrix)", (3, 3)))
        return cls._trusted(rotors)

    @classmethod
    def nearest(cls, matrix: ArrayLike) -> Rotor:
        """Rotors nearest to matrices ``(*, 3, 3)`` with noise, in the Frobenius norm.

        By the singular value decomposition (W. Kabsch, A solution for the best rotation to relate
        two sets of vectors, Acta Cryst. A32, 1976). What turned farther than noise would, or is
        scaled, comes out as some rotation all the same.

        Raises:
            ValueError: wrong shape, NaN or infinity, or a matrix of rank below 2, to which many
                rotations are equally near.

        Examples:
            >>> import numpy as np
            >>> from motorcade.ga import Rotor
            >>> noisy = np.eye(3) + 2.5e-4 * np.ones((3, 3))
            >>> Rotor.nearest(noisy).isclose(Rotor.identity())
            np.True_
        """
        name = "Rotor.nearest(matrix)"
        left, sizes, right = np.linalg.svd(checked_floats(matrix, name, (3, 3)))
        if not np.all(sizes[..., 1] > np.finfo(sizes.dtype).eps * sizes[..., 0]):
            raise ValueError(f"{name}: expected matrices of rank 2 or 3, got one of lower rank")
        left[..., 2] *= np.linalg.det(left @ right)[..., None]
        return cls.from_matrix(left @ right)

    @fast_path("matrix33", "v", "s")
    def as_matrix(self) -> FloatArray:
        """Rotation matrices ``(*, 3, 3)`` that act on columns."""
        return parts.rotor_matrix(self.coefficients)

    @classmethod
    @fast_path("of_euler", "cxe", "v")
    def from_euler(cls, angles_rad: ArrayLike, sequence: str = "xyz") -> Rotor:
        """Rotors from intrinsic Euler angles ``(*, 3)`` in the order of `sequence`.

        ``"xyz"`` is x-y′-z″: ``R = R_x(a) R_y(b) R_z(c)``.

        Raises:
            ValueError: an unknown sequence, wrong last dimension, NaN or infinity.
        """
        return cls._trusted(coefficients_of_euler(angles_rad, sequence))

    @fast_path("tait_bryan", "vo", "x")
    def as_euler(self, sequence: str = "xyz") -> FloatArray:
        """Intrinsic Euler angles ``(*, 3)`` in radians, first and third in [-π, π].

        The middle angle is in [-π/2, π/2], or in [0, π] where the sequence ends as it began. At
        gimbal lock only a combination of first and third is defined: the first is then 0.
        """
        return euler_of_coefficients(self.coefficients, sequence)


def coefficients_of_euler(angles_rad: ArrayLike, sequence: str) -> FloatArray:
    """Coefficients ``(*, 4)`` of `Rotor.from_euler`; see there."""
    operands = sequence_operands(sequence)
    values = given_floats(angles_rad, "angles_rad", (3,))
    coefficients, finite = parts.rotor_of_euler(values, operands.axes[values.dtype])
    if not finite:
        checked_floats(values, "angles_rad", (3,))
    return coefficients


def euler_of_coefficients(coefficients: FloatArray, sequence: str) -> FloatArray:
    """Angles ``(*, 3)`` of rotors' coefficients ``(*, 4)``; see `Rotor.as_euler`."""
    operands = sequence_operands(sequence)
    frame = operands.frame[coefficients.dtype]
    return parts.euler_of_rotor(coefficients, frame, proper=operands.proper)


def check_rotation(matrix: FloatArray) -> None:
    """Refuse what is no rotation matrix ``(*, 3, 3)``.

    Raises ValueError: ``R^T R`` more than 1e-5 from the identity, or a reflection.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        gram = np.swapaxes(matrix, -1, -2) @ matrix
        worst = float(np.max(np.abs(gram - np.eye(3)), initial=0.0))
    if not worst <= MATRIX_TOLERANCE:
        square = np.trace(gram, axis1=-2, axis2=-1)[..., None, None] / 3.0
        with np.errstate(invalid="ignore"):
            scaled = np.all(np.abs(gram - square * np.eye(3)) <= MATRIX_TOLERANCE * square)
        advice = (
            "it is a rotation times a scale, which Similarity.from_matrix reads"
            if scaled and np.all((square > 0.0) & (square < np.inf))
            else "Rotor.nearest gives the nearest rotation"
        )
        raise ValueError(
            f"Rotor.from_matrix(matrix): expected R^T R within {MATRIX_TOLERANCE:g} of the "
            f"identity, got a difference of {worst:.3g}; {advice}"
        )
    if np.any(np.linalg.det(matrix) < 0.0):
        raise ValueError("Rotor.from_matrix(matrix): expected determinant +1, got a reflection")


def check_quaternions(values: FloatArray, name: str, tolerance: float, off: float) -> None:
    """Refuse quaternions ``(*, 4)`` whose norms are off 1 by so much, NaN where not finite.

    Raises ValueError: NaN or infinity, or more than the tolerance.
    """
    if not off <= tolerance:
        checked_floats(values, name, (4,))
        raise ValueError(
            f"{name}: expected unit quaternions (norm within {tolerance:g} of 1), got a norm off "
            f"by {off:.3g}; divide by it first"
        )
