"""Similarity: rigid motions with dilation, ``(*, 12)`` on ``1, e23, e31, e12, E, e23E, e31E, e12E,
e1∞, e2∞, e3∞, e123∞`` with ``E = e0∧e∞``.

``S = T R D`` with ``T = 1 - ½ t∞`` and ``D = exp(½ ln ρ E)``: first everything grows by the scale
``ρ > 0`` about the origin, then the rotor turns, then the translator moves by ``t`` (m), so that
``x' = ρ R x ~R + t``; ``X' = S X ~S`` on conformal points. The logarithm is ``(*, 7)`` on ``e23,
e31, e12, E, e1∞, e2∞, e3∞``: with rotation vector ``θ l`` it is ``-½ θ I₃ l + ½ ln ρ E - ½ u∞``,
where translation, rotation and growth are coupled: ``t = ((e^z - 1) / z) u`` across the axis, with
``z = ln ρ + iθ``. Accuracy is that of the numbers stored: a large or small scale leaves the
difference of the first two quadruples with a relative error of ``max(ρ, 1/ρ)`` roundings. Scales
are meant to lie in 1e-12 … 1e12, in float32 in 1e-5 … 1e5; `exp` and `log` keep their precision
beyond, products and paths do not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import kernels
from motorcade.ga.arrays import (
    FloatArray,
    broadcast_batch,
    checked_floats,
    common_precision,
    given_floats,
)
from motorcade.ga.kernels import SIMILARITIES, parts
from motorcade.ga.kernels.backend import fast_path
from motorcade.ga.versors.motor import Motor, check_bottom_row
from motorcade.ga.versors.rotor import MATRIX_TOLERANCE, Rotor, check_rotation
from motorcade.ga.versors.versor import Operators, Versor

# Less defined than this, an element in float64 is as near to one versor as to another far from it.
_VAGUE = float(np.sqrt(np.finfo(np.float64).eps))


class Similarity(Versor):
    """Rigid motions with dilation, ``coefficients (*, 12)`` in the order of the module.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or not unit: ``S ~S`` differs from 1 by
            more than 1e-6 of the squares in it.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Similarity
        >>> world_T_map = Similarity.from_motor_scale(Motor.from_translation([1.0, 0.0, 0.0]), 2.0)
        >>> np.round(world_T_map.apply([0.0, 0.0, 3.0]), 6)
        array([1., 0., 6.])
        >>> float(np.round(world_T_map.inverse().scale, 6))
        0.5
        >>> world_T_map.rigid.translation_m
        array([1., 0., 0.])
    """

    _size = 12
    _log_size = 7
    _blades = (
        *("1", "e2^e3", "e3^e1", "e1^e2"),
        *("e0^einf", "e2^e3^e0^einf", "e3^e1^e0^einf", "e1^e2^e0^einf"),
        *("e1^einf", "e2^einf", "e3^einf", "e1^e2^e3^einf"),
    )
    _kernels = SIMILARITIES
    _unit = "S ~S = 1"

    @classmethod
    @fast_path("exp", "cx", "v")
    def exp(cls, log: ArrayLike) -> Similarity:
        """Similarities from bivectors ``(*, 7)``, the mirror of `log`.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or a scale too large or too small
                for the precision.
        """
        twists = cls._checked(log, "Similarity.exp(log)", (7,))
        with np.errstate(over="ignore", invalid="ignore"):  # as the NumPy kernels would warn
            similarities = SIMILARITIES.exp(twists)
        if not np.isfinite(similarities).all():
            raise ValueError(
                f"Similarity.exp(log): expected scales that {twists.dtype} can hold, got E up to "
                f"{float(np.max(np.abs(twists[..., 3]))):.3g}"
            )
        return cls._trusted(similarities)

    @classmethod
    @fast_path("normalize", "cx", "v", above=_VAGUE)
    def normalize(cls, coefficients: ArrayLike) -> Similarity:
        """Project even elements ``(*, 12)`` onto similarities, as after a linear blend.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, or an element that is near no
                similarity: zero, or without a scale, or turned inside out (``S ~S`` a negative
                number).
        """
        elements = cls._checked(coefficients, "Similarity.normalize(coefficients)", (12,))
        size = np.max(np.abs(elements[..., :8]), axis=-1, keepdims=True)
        if not np.all(size > 0.0):
            raise ValueError(
                "Similarity.normalize(coefficients): expected non-zero elements with a rotor part, "
                f"got {int(np.count_nonzero(size == 0.0))} zero ones"
            )
        with np.errstate(over="ignore", invalid="ignore"):
            similarities, defined = kernels.similarity_normalize(elements)
        # Less than this and an element is as near to one versor as to another far from it.
        least = np.sqrt(np.finfo(elements.dtype).eps)
        vague = (defined < least) | ~np.isfinite(similarities).all(axis=-1)
        lost = int(np.count_nonzero(vague))
        if lost:
            raise ValueError(
                "Similarity.normalize(coefficients): expected elements near a similarity, got "
                f"{lost} without a scale or turned inside out"
            )
        return cls._trusted(similarities)

    @classmethod
    def random(
        cls,
        rng: np.random.Generator,
        shape: tuple[int, ...] = (),
        extent_m: float = 1.0,
        log_scale: float = 0.5,
    ) -> Similarity:
        """Uniform orientations, normal translations and logarithms of scales, with deviations
        `extent_m` an axis and `log_scale`.
        """
        motor = Motor.random(rng, shape, extent_m)
        return cls.from_motor_scale(motor, np.exp(log_scale * rng.standard_normal(shape)))

    @classmethod
    def _promoted(cls, versor: Operators) -> Similarity:
        motor = versor if isinstance(versor, Motor) else Motor._promoted(versor)
        return cls.from_motor_scale(motor)

    def _parts(self) -> tuple[Rotor, FloatArray, FloatArray]:
        rotor, translation_m, scale = kernels.rotor_translation_scale(self.coefficients)
        return Rotor._trusted(rotor), translation_m + 0.0, scale  # no -0.0

    @property
    def rotor(self) -> Rotor:
        """The rotation, ``R`` of ``S = T R D``."""
        return self._parts()[0]

    @property
    def translation_m(self) -> FloatArray:
        """The translation ``(*, 3)`` in metres, ``t`` of ``S = T R D``: where the origin goes."""
        return self._parts()[1]

    @property
    def scale(self) -> FloatArray:
        """How much lengths grow, ``ρ (*)``."""
        return self._parts()[2]

    # Conversions -------------------------------------------------------------------------------

    @classmethod
    @fast_path("similarity_of", "crxp", "v")
    def from_rotor_translation_scale(
        cls, rotor: Rotor, translation_m: ArrayLike, scale: ArrayLike
    ) -> Similarity:
        """Grow by `scale` ``(*)``, turn by `rotor`, move by `translation_m` ``(*, 3)``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, a scale that is not positive, shapes
                that do not broadcast.
        """
        t = given_floats(translation_m, "Motor translation_m", (3,))
        rho = _scales(scale)
        r = rotor.coefficients
        shape = broadcast_batch("Motor rotor and translation_m", rotor.shape, t.shape[:-1])
        broadcast_batch("Similarity motor and scale", shape, rho.shape)
        kind = common_precision(rotor, translation_m, scale)
        r, t, rho = (x.astype(kind, copy=False) for x in (r, t, rho))
        similarities, finite = parts.similarity_of(r, t, rho[..., None])
        if not finite:
            checked_floats(translation_m, "Motor translation_m", (3,))
        return cls._trusted(similarities)

    def as_rotor_translation_scale(self) -> tuple[Rotor, FloatArray, FloatArray]:
        """Rotor, translation ``(*, 3)`` in metres and scale ``(*)``."""
        return self._parts()

    @classmethod
    @fast_path("similarity_of_motor", "cmp", "v")
    def from_motor_scale(cls, motor: Motor, scale: ArrayLike = 1.0) -> Similarity:
        """``M D``: grow by `scale` ``(*)`` about the origin, then move by `motor`.

        Raises:
            ValueError: NaN or infinity, a scale that is not positive, shapes that do not
                broadcast.
        """
        rho = _scales(scale)
        broadcast_batch("Similarity motor and scale", motor.shape, rho.shape)
        kind = common_precision(motor, scale)
        m, rho = motor.coefficients.astype(kind, copy=False), rho.astype(kind, copy=False)
        return cls._trusted(parts.similarity_of_motor(m, rho[..., None])[0])

    @property
    def rigid(self) -> Motor:
        """The rigid motion ``T R`` of ``S = T R D``: the same turn and shift at scale 1."""
        return self.as_motor_scale()[0]

    def as_motor_scale(self) -> tuple[Motor, FloatArray]:
        """The rigid motion ``T R`` and the scale ``(*)`` of ``S = T R D``."""
        motor, scale = parts.motor_scale(self.coefficients)
        return Motor._trusted(motor), scale

    @classmethod
    @fast_path("similarity_of_matrix44", "cs", "v", MATRIX_TOLERANCE)
    def from_matrix(cls, matrix: ArrayLike) -> Similarity:
        """Similarities from homogeneous matrices ``(*, 4, 4)`` that act on columns.

        Raises:
            ValueError: wrong shape, NaN or infinity, a last row that is not 0 0 0 1, or an upper
                left block that is no positive multiple of a rotation (see `Rotor.from_matrix`).
        """
        name = "Similarity.from_matrix(matrix)"
        matrices = given_floats(matrix, name, (4, 4))
        similarities, off = parts.similarity_of_matrix(matrices)
        if not off <= MATRIX_TOLERANCE:
            _check_matrices(checked_floats(matrices, name, (4, 4)), name)
        return cls._trusted(similarities)

    @fast_path("matrix44", "v", "s")
    def as_matrix(self) -> FloatArray:
        """Homogeneous matrices ``(*, 4, 4)`` that act on columns."""
        return SIMILARITIES.matrix44(self.coefficients)

    @classmethod
    @fast_path("of_twist", "cx", "v")
    def from_twist(cls, twist: ArrayLike) -> Similarity:
        """Similarities from sim(3) coordinates ``(*, 7)``: rotation vector (rad), translational
        part (m), logarithm of the scale.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, a scale beyond float64.
        """
        name = "Similarity.from_twist(twist)"
        similarities = cls._of_twist(twist, name)
        if not np.isfinite(similarities).all():
            raise ValueError(
                f"{name}: expected scales that {similarities.dtype} holds, got a log of up to "
                f"{float(np.max(np.abs(np.asarray(twist)[..., 6]))):.3g}"
            )
        return cls._trusted(similarities)

    @fast_path("as_twist", "v", "x")
    def as_twist(self) -> FloatArray:
        """sim(3) coordinates ``(*, 7)``: rotation vector (rad), translational part (m), log scale.

        With ``Ω`` the cross product matrix of the first three, it is the logarithm of `as_matrix`:
        ``Ω + λ`` in the upper left block, the translational part beside it.
        """
        return SIMILARITIES.as_twist(self.coefficients)


def _scales(scale: ArrayLike) -> FloatArray:
    """Scales ``(*)``, positive and finite."""
    rho = given_floats(scale, "Similarity scale", ())
    if not np.all((rho > 0.0) & (rho < np.inf)):
        checked_floats(rho, "Similarity scale", ())
        raise ValueError(f"Similarity scale: expected positive numbers, got {float(np.min(rho)):g}")
    return rho


def _check_matrices(matrix: FloatArray, name: str) -> None:
    """Refuse matrices ``(*, 4, 4)`` that are no similarities."""
    check_bottom_row(matrix, name)
    block = matrix[..., :3, :3]
    scale = np.cbrt(np.linalg.det(block))
    if not np.all(scale > 0.0):
        raise ValueError(
            f"{name}: expected a positive determinant, got a scale of {float(np.min(scale)):.3g}"
        )
    check_rotation(block / scale[..., None, None])
