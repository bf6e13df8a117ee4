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
)
from motorcade.ga.kernels import MOTORS
from motorcade.ga.versors.rotor import Rotor
from motorcade.ga.versors.versor import Versor

_TO_DUAL_QUATERNION = np.array([1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0])
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
    _kernels = MOTORS

    @classmethod
    def _check_unit(cls, coefficients: FloatArray) -> None:
        super()._check_unit(coefficients)
        length = np.max(np.abs(coefficients[..., 4:]), axis=-1)
        study = np.abs(_study(coefficients)) / np.maximum(1.0, length)
        worst = float(np.max(study, initial=0.0))
        tolerance = cls._tolerance(coefficients)
        if worst > tolerance:
            raise ValueError(
                f"{cls._field('coefficients')}: expected m0 m7 = m1 m4 + m2 m5 + m3 m6 within "
                f"{tolerance:g}, got a difference of {worst:.3g}; "
                "Motor.normalize projects other even elements"
            )

    @classmethod
    def normalize(cls, coefficients: ArrayLike) -> Motor:
        """Project even elements ``(*, 8)`` onto rigid motors, as after a linear blend.

        With ``m ~m = α + β J`` the motor is ``m α^(-½) (1 - β J / 2α)``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a zero rotor part, which stands
                for no motion.
        """
        given = cls._checked(coefficients, "Motor.normalize(coefficients)", (8,))
        size = np.max(np.abs(given[..., :4]), axis=-1, keepdims=True)
        if not np.all(size > 0.0):
            raise ValueError(
                "Motor.normalize(coefficients): expected a non-zero rotor part m0..m3, got "
                f"{int(np.count_nonzero(size == 0.0))} zero ones"
            )
        scaled = given / size
        scaled = scaled / np.sqrt(np.sum(scaled[..., :4] ** 2, axis=-1, keepdims=True))
        excess = _study(scaled)[..., None]
        scaled[..., 4:7] += excess * scaled[..., 1:4]
        scaled[..., 7:] -= excess * scaled[..., :1]
        return cls._trusted(scaled)

    @classmethod
    def random(
        cls, rng: np.random.Generator, shape: tuple[int, ...] = (), extent_m: float = 1.0
    ) -> Motor:
        """Orientations drawn uniformly, translations normal with deviation `extent_m` an axis."""
        rotor = Rotor.random(rng, shape)
        return cls.from_rotor_translation(rotor, extent_m * rng.standard_normal((*shape, 3)))

    @property
    def rigid(self) -> Motor:
        """The motion itself, as `Similarity.rigid` is the motion without its scale."""
        return self

    @property
    def rotor(self) -> Rotor:
        """The rotation, ``R`` of ``M = T R``."""
        return Rotor._trusted(self.coefficients[..., :4])

    @property
    def translation_m(self) -> FloatArray:
        """The translation ``(*, 3)`` in metres, ``t`` of ``M = T R``: where the origin goes."""
        w, v = self.coefficients[..., :1], self.coefficients[..., 1:4]
        n, last = self.coefficients[..., 4:7], self.coefficients[..., 7:]
        translation: FloatArray = -2.0 * (last * v + w * n + np.cross(n, v)) + 0.0  # no -0.0
        return translation

    def apply(self, points: ArrayLike) -> FloatArray:
        """Move points ``(*, 3)`` in metres; batch shapes broadcast.

        Directions turn with ``motor.rotor.apply``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, shapes that do not broadcast.
        """
        x = checked_floats(points, "Motor.apply(points)", (3,)).astype(self.dtype, copy=False)
        broadcast_batch("Motor.apply", self.shape, x.shape[:-1])
        return MOTORS.apply(self.coefficients, x)

    # Conversions -------------------------------------------------------------------------------

    @classmethod
    def from_rotor_translation(cls, rotor: Rotor, translation_m: ArrayLike) -> Motor:
        """Motors that turn by `rotor`, then move by `translation_m` ``(*, 3)``; batches broadcast.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, shapes that do not broadcast.
        """
        t = checked_floats(translation_m, "Motor translation_m", (3,))
        shape = broadcast_batch("Motor rotor and translation_m", rotor.shape, t.shape[:-1])
        w, v = rotor.coefficients[..., :1], rotor.coefficients[..., 1:]
        made = np.empty((*shape, 8))
        made[..., :4] = rotor.coefficients
        made[..., 4:7] = -0.5 * (w * t + np.cross(v, t))
        made[..., 7] = -0.5 * np.sum(v * t, axis=-1)
        return cls._of(made, rotor, translation_m)

    @classmethod
    def from_translation(cls, translation_m: ArrayLike) -> Motor:
        """Translators: motions ``(*)`` by vectors ``(*, 3)`` in metres that turn nothing."""
        shift = checked_floats(translation_m, "translation_m", (3,))
        still = Rotor.identity(shift.shape[:-1], common_precision(translation_m))
        return cls.from_rotor_translation(still, shift.astype(still.dtype, copy=False))

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Motor:
        """Motors from homogeneous matrices ``(*, 4, 4)`` that act on columns.

        Raises:
            ValueError: wrong shape, NaN or infinity, a last row that is not 0 0 0 1, or an upper
                left block that is no rotation (see `Rotor.from_matrix`).
        """
        given = checked_floats(matrix, "Motor.from_matrix(matrix)", (4, 4))
        worst = float(np.max(np.abs(given[..., 3, :] - _BOTTOM_ROW), initial=0.0))
        if worst > UNIT_TOLERANCE:
            raise ValueError(
                "Motor.from_matrix(matrix): expected the last row 0 0 0 1, got a difference of "
                f"{worst:.3g}"
            )
        made = cls.from_rotor_translation(Rotor.from_matrix(given[..., :3, :3]), given[..., :3, 3])
        return cls._of(made.coefficients, matrix)

    def as_matrix(self) -> FloatArray:
        """Homogeneous matrices ``(*, 4, 4)`` that act on columns."""
        return MOTORS.matrix44(self.coefficients)

    @classmethod
    def from_quaternion_translation(cls, wxyz: ArrayLike, translation_m: ArrayLike) -> Motor:
        """Motors from unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, a quaternion whose norm is more
                than 1e-6 from 1, shapes that do not broadcast.
        """
        return cls.from_rotor_translation(Rotor.from_quaternion(wxyz), translation_m)

    def as_quaternion_translation(self) -> tuple[FloatArray, FloatArray]:
        """Unit quaternions ``(*, 4)`` wxyz and translations ``(*, 3)`` in metres."""
        return self.rotor.as_quaternion(), self.translation_m

    @classmethod
    def from_dual_quaternion(cls, dual_quaternion: ArrayLike) -> Motor:
        """Motors from unit Hamilton dual quaternions ``(*, 8)``: real wxyz, then dual wxyz.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or not unit within 1e-6.
        """
        given = cls._checked(dual_quaternion, "Motor.from_dual_quaternion", (8,))
        return cls(given[..., [0, 1, 2, 3, 5, 6, 7, 4]] * _TO_DUAL_QUATERNION.astype(given.dtype))

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
        return cls.from_rotor_translation(Rotor.from_euler(angles_rad, sequence), translation_m)

    def as_euler_translation(self, sequence: str = "xyz") -> tuple[FloatArray, FloatArray]:
        """Intrinsic Euler angles ``(*, 3)`` (see `Rotor.as_euler`) and translations ``(*, 3)``."""
        return self.rotor.as_euler(sequence), self.translation_m

    @classmethod
    def from_twist(cls, twist: ArrayLike) -> Motor:
        """Motors from se(3) coordinates ``(*, 6)``: rotation vector (rad), translational part (m).

        The translational part is the velocity of the screw over unit time, not the translation
        that results, unless there is no rotation.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        return cls.exp(-0.5 * cls._checked(twist, "Motor.from_twist(twist)", (6,)))

    def as_twist(self) -> FloatArray:
        """se(3) coordinates ``(*, 6)``: rotation vector (rad), translational part (m)."""
        return -2.0 * self.log()


def _study(coefficients: FloatArray) -> FloatArray:
    """``β / 2`` of ``m ~m = α + β J``; zero for a rigid motor."""
    products: FloatArray = coefficients[..., 0] * coefficients[..., 7] - np.sum(
        coefficients[..., 1:4] * coefficients[..., 4:7], axis=-1
    )
    return products
