"""Motor: rigid motions as ``(*, 8)`` on ``1, e23, e31, e12, e1∞, e2∞, e3∞, e123∞``.

``M = T R`` with ``T = 1 - ½ t∞``: first the rotor turns, then the translator moves by ``t`` (m).
``X' = M X ~M``. Its logarithm is ``(*, 6)`` on ``e23, e31, e12, e1∞, e2∞, e3∞``, and the twist
(rotation vector in radians, then the translational part in metres) is ``-2 log``, the element of
se(3) in the order that gtsam and others use. As a Hamilton dual quaternion the motor is
``(m0, -m1, -m2, -m3)`` and ``(-m7, -m4, -m5, -m6)``. Rigid motors only: no scale, no reflection.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import kernels
from motorcade.ga.arrays import (
    UNIT_TOLERANCE,
    FloatArray,
    broadcast_batch,
    checked_floats,
    common_precision,
    given_floats,
)
from motorcade.ga.kernels import MOTORS, ROTORS, parts
from motorcade.ga.kernels.backend import fast_path
from motorcade.ga.versors.euler_angles import sequence_operands
from motorcade.ga.versors.rotor import (
    MATRIX_TOLERANCE,
    Rotor,
    check_quaternions,
    check_rotation,
    euler_of_coefficients,
)
from motorcade.ga.versors.versor import Operators, Versor

_BOTTOM_ROW = np.array([0.0, 0.0, 0.0, 1.0])


class Motor(Versor):
    """Rigid motions, ``coefficients (*, 8)`` on ``1, e23, e31, e12, e1∞, e2∞, e3∞, e123∞``.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or not unit: a norm more than 1e-6
            from 1, or a part ``e123∞`` that does not fit the others.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor
        >>> world_T_rig = Motor.from_translation([0.0, 0.0, 2.0])
        >>> rig_T_camera = Motor.from_twist([0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0])
        >>> world_T_camera = world_T_rig @ rig_T_camera
        >>> np.round(world_T_camera.apply([0.0, 0.0, 1.0]), 6) + 0.0
        array([1., 0., 2.])
        >>> world_T_rig.retract(rig_T_camera.as_twist()).isclose(world_T_camera)
        np.True_
        >>> np.round(world_T_rig.local(world_T_camera), 4) + 0.0
        array([0. , 1.5708, 0. , 0. , 0. , 0. ])
    """

    _size = 8
    _log_size = 6
    _blades = (*Rotor._blades, "e1^einf", "e2^einf", "e3^einf", "e1^e2^e3^einf")
    _kernels = MOTORS
    _unit = "norm 1 and m0 m7 = m1 m4 + m2 m5 + m3 m6"

    @classmethod
    @fast_path("project", "cx", "v", above=0.0)
    def normalize(cls, coefficients: ArrayLike) -> Motor:
        """Project even elements ``(*, 8)`` onto rigid motors, as after a linear blend.

        With ``m ~m = α + β J`` the motor is ``m α^(-½) (1 - β J / 2α)``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a zero rotor part, which stands
                for no motion.
        """
        return cls._normalized(coefficients, parts.normalized_motor)

    @classmethod
    def random(
        cls, rng: np.random.Generator, shape: tuple[int, ...] = (), extent_m: float = 1.0
    ) -> Motor:
        """Orientations drawn uniformly, translations normal with deviation `extent_m` an axis."""
        rotor = Rotor.random(rng, shape)
        return cls.from_rotor_translation(rotor, extent_m * rng.standard_normal((*shape, 3)))

    @classmethod
    def _promoted(cls, versor: Operators) -> Motor:
        if isinstance(versor, Rotor):
            return cls._trusted(
                np.pad(versor.coefficients, [*[(0, 0)] * len(versor.shape), (0, 4)])
            )
        return super()._promoted(versor)

    @property
    def rigid(self) -> Motor:
        """The motion itself, as `Similarity.rigid` is the motion without its scale."""
        return self

    @property
    def rotor(self) -> Rotor:
        """The rotation, ``R`` of ``M = T R``."""
        return Rotor._trusted(self.coefficients[..., :4])

    @property
    @fast_path("translation", "v", "z")
    def translation_m(self) -> FloatArray:
        """The translation ``(*, 3)`` in metres, ``t`` of ``M = T R``: where the origin goes."""
        translation = parts.translation(self.coefficients)
        translation += 0.0  # no -0.0
        return translation

    # Conversions -------------------------------------------------------------------------------

    @classmethod
    @fast_path("motor_of", "crx", "v")
    def from_rotor_translation(cls, rotor: Rotor, translation_m: ArrayLike) -> Motor:
        """Motors that turn by `rotor`, then move by `translation_m` ``(*, 3)``; batches broadcast.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, shapes that do not broadcast.
        """
        r, t = _of_one_precision(rotor.coefficients, translation_m)
        motors, finite = parts.motor_of(r, t)
        if not finite:
            checked_floats(translation_m, "Motor translation_m", (3,))
        return cls._trusted(motors)

    @classmethod
    @fast_path("of_translation", "cx", "v")
    def from_translation(cls, translation_m: ArrayLike) -> Motor:
        """Translators: motions ``(*)`` by vectors ``(*, 3)`` in metres that turn nothing."""
        shift = given_floats(translation_m, "translation_m", (3,))
        motors, finite = parts.motor_of_translation(shift)
        if not finite:
            checked_floats(shift, "translation_m", (3,))
        return cls._trusted(motors)

    @classmethod
    @fast_path("motor_of_matrix44", "cs", "v", MATRIX_TOLERANCE)
    def from_matrix(cls, matrix: ArrayLike) -> Motor:
        """Motors from homogeneous matrices ``(*, 4, 4)`` that act on columns.

        Raises:
            ValueError: wrong shape, NaN or infinity, a last row that is not 0 0 0 1, or an upper
                left block that is no rotation (see `Rotor.from_matrix`).
        """
        matrices = given_floats(matrix, "Motor.from_matrix(matrix)", (4, 4))
        motors, off = parts.motor_of_matrix(matrices)
        if not off <= MATRIX_TOLERANCE:
            whole = checked_floats(matrices, "Motor.from_matrix(matrix)", (4, 4))
            check_bottom_row(whole, "Motor.from_matrix(matrix)")
            check_rotation(whole[..., :3, :3])
        return cls._trusted(motors)

    @classmethod
    def nearest(cls, matrix: ArrayLike) -> Motor:
        """Motors of homogeneous matrices ``(*, 4, 4)`` with noise: the nearest rotations, see
        `Rotor.nearest`, and the translations as they are.

        Raises:
            ValueError: as `Rotor.nearest`, or a last row that is not 0 0 0 1.
        """
        whole = checked_floats(matrix, "Motor.nearest(matrix)", (4, 4))
        check_bottom_row(whole, "Motor.nearest(matrix)")
        rotor = Rotor.nearest(whole[..., :3, :3])
        return cls.from_rotor_translation(rotor, whole[..., :3, 3])

    @fast_path("matrix44", "v", "s")
    def as_matrix(self) -> FloatArray:
        """Homogeneous matrices ``(*, 4, 4)`` that act on columns."""
        return MOTORS.matrix44(self.coefficients)

    @classmethod
    @fast_path("motor_of_quaternion", "cxx", "v", UNIT_TOLERANCE)
    def from_quaternion_translation(cls, wxyz: ArrayLike, translation_m: ArrayLike) -> Motor:
        """Motors from unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, a quaternion whose norm is more
                than 1e-6 from 1, shapes that do not broadcast.
        """
        q = given_floats(wxyz, "Rotor.from_quaternion(wxyz)", (4,))
        q, t = _of_one_precision(q, translation_m)
        motors, off = parts.motor_of_quaternion(q, t)
        if np.isnan(off):
            checked_floats(q, "Rotor.from_quaternion(wxyz)", (4,))
            checked_floats(translation_m, "Motor translation_m", (3,))
        check_quaternions(q, "Rotor.from_quaternion(wxyz)", cls._tolerance(q), off)
        return cls._trusted(motors)

    def as_quaternion_translation(self) -> tuple[FloatArray, FloatArray]:
        """Unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)`` in metres."""
        return ROTORS.inverse(self.coefficients[..., :4]), self.translation_m

    @classmethod
    @fast_path("motor_of_dual_quaternion", "cx", "v", UNIT_TOLERANCE)
    def from_dual_quaternion(cls, dual_quaternion: ArrayLike) -> Motor:
        """Motors from unit Hamilton dual quaternions ``(*, 8)``: real wxyz, then dual wxyz.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or not unit within 1e-6.
        """
        values = given_floats(dual_quaternion, "Motor.from_dual_quaternion", (8,))
        motors, off = parts.motor_of_dual_quaternion(values)
        if not off <= cls._tolerance(values):
            checked_floats(values, "Motor.from_dual_quaternion", (8,))
            cls._check_unit(motors)
        return cls._trusted(motors)

    @fast_path("dual_quaternion", "v", "x")
    def as_dual_quaternion(self) -> FloatArray:
        """Unit Hamilton dual quaternions ``(*, 8)``: real wxyz, then dual wxyz."""
        return kernels.dual_quaternion(self.coefficients)

    @classmethod
    def from_euler_translation(
        cls, angles_rad: ArrayLike, translation_m: ArrayLike, sequence: str = "xyz"
    ) -> Motor:
        """Motors from intrinsic Euler angles ``(*, 3)`` and translations ``(*, 3)``.

        Raises:
            ValueError: an unknown sequence, wrong last dimension, NaN or infinity.
        """
        operands = sequence_operands(sequence)
        values = given_floats(angles_rad, "angles_rad", (3,))
        angles, t = _of_one_precision(values, translation_m)
        motors, finite = parts.motor_of_euler(angles, operands.axes[angles.dtype], t)
        if not finite:
            checked_floats(angles_rad, "angles_rad", (3,))
            checked_floats(translation_m, "Motor translation_m", (3,))
        return cls._trusted(motors)

    def as_euler_translation(self, sequence: str = "xyz") -> tuple[FloatArray, FloatArray]:
        """Intrinsic Euler angles ``(*, 3)`` (see `Rotor.as_euler`) and translations ``(*, 3)``."""
        return euler_of_coefficients(self.coefficients[..., :4], sequence), self.translation_m

    @classmethod
    @fast_path("of_twist", "cx", "v")
    def from_twist(cls, twist: ArrayLike) -> Motor:
        """Motors from se(3) coordinates ``(*, 6)``: rotation vector (rad), translational part (m).

        The translational part is the velocity of the screw over unit time, not the translation
        that results, unless there is no rotation.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        return cls._trusted(cls._of_twist(twist, "Motor.from_twist(twist)"))

    @fast_path("as_twist", "v", "x")
    def as_twist(self) -> FloatArray:
        """se(3) coordinates ``(*, 6)``: rotation vector (rad), translational part (m)."""
        return MOTORS.as_twist(self.coefficients)


def _of_one_precision(rotor: FloatArray, translation_m: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Rotors, quaternions or angles ``(*, n)``, and translations whose batch goes with them."""
    t = given_floats(translation_m, "Motor translation_m", (3,))
    broadcast_batch("Motor rotor and translation_m", rotor.shape[:-1], t.shape[:-1])
    kind = common_precision(rotor, translation_m)
    return rotor.astype(kind, copy=False), t.astype(kind, copy=False)


def check_bottom_row(matrix: FloatArray, name: str) -> None:
    """Refuse homogeneous matrices ``(*, 4, 4)`` that are none.

    Raises ValueError: a last row more than 1e-6 from 0 0 0 1.
    """
    worst = float(np.max(np.abs(matrix[..., 3, :] - _BOTTOM_ROW), initial=0.0))
    if worst > UNIT_TOLERANCE:
        raise ValueError(f"{name}: expected the last row 0 0 0 1, got a difference of {worst:.3g}")
