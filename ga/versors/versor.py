"""The verbs that every versor type shares: compose, invert, exp and log, interpolate, and those of
Lie groups.

A versor acts by ``X' = S X ~S``; ``a @ b`` applies ``b`` first. ``S`` and ``-S`` are one motion.

A tangent is a twist, ``-2 log``: rotation vector (rad), then the translational part (m), then the
logarithm of the scale, as many of these as the type has. Small moves act in the versor's own frame,
on the right: ``a.retract(x) = a @ exp(x)``, ``a.local(b)`` is the twist that takes ``a`` to ``b``.

Two types compose as the one that holds more: a rotor beside a motor is the motor that turns alone.

Leading dimensions are batch and broadcast as those of NumPy arrays do. One rule for precision:
Arrays and versors are float32 or float64; Python's numbers and lists have
no precision of their own.

- Whatever makes versors (the constructor, ``from_…``, `exp`, `normalize`) makes float32 ones where
  all arrays and versors that it is given are float32, float64 ones otherwise.
- Verbs keep the versor's precision: arrays handed to them (points, twists, fractions) are taken in
  it, and what they return is in it.
- Verbs between versors of different precision raise TypeError; `astype` converts.
"""

from __future__ import annotations

import operator
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from motorcade.ga.arrays import (
    UNIT_TOLERANCE,
    CoefficientBatch,
    FloatArray,
    broadcast_batch,
    checked_floats,
    common_precision,
    given_floats,
    sealed,
)
from motorcade.ga.kernels.backend import fast_path, register_versor
from motorcade.ga.kernels.batches import VersorKernels
from motorcade.ga.notation import ShownAsSum


@dataclass(frozen=True, eq=False, repr=False)
class Operators(CoefficientBatch, ShownAsSum):
    """Operators in terms of the verbs, which `Versor` brings.

    >>> from motorcade.ga import Motor, Rotor
    >>> half = Rotor.from_rotation_vector([0.0, 0.0, 1.0]) ** 0.5
    >>> half == ~(half**-1), half in [None, half]
    (True, True)
    >>> type(half @ Motor.from_translation([1.0, 0.0, 0.0])).__name__
    'Motor'
    """

    @classmethod
    @abstractmethod
    def _trusted(cls, coefficients: FloatArray) -> Self: ...

    @abstractmethod
    def __matmul__(self, other: Self) -> Self: ...

    @abstractmethod
    def inverse(self) -> Self:
        """The motion undone."""

    @abstractmethod
    def _power(self, fraction: ArrayLike) -> Self: ...

    def __eq__(self, other: object) -> bool:
        """Whether both are the same value: of one type, precision and shape, coefficient by
        coefficient. ``S`` and ``-S`` are one motion and numbers round: `isclose` compares motions.
        """
        if not isinstance(other, Operators):
            return NotImplemented
        a, b = self.coefficients, other.coefficients
        return type(self) is type(other) and a.dtype == b.dtype and np.array_equal(a, b)

    def __hash__(self) -> int:
        numbers = self.coefficients + 0.0  # -0 and 0 are equal
        return hash((type(self), numbers.shape, numbers.dtype.str, numbers.tobytes()))

    def __rmatmul__(self, other: Operators) -> Any:
        """Compose with another type: both are taken as the one that holds more."""
        if not isinstance(other, Operators):
            return NotImplemented
        if self._size > other._size:
            return self._promoted(other) @ self
        return other @ other._promoted(self)

    @classmethod
    def _promoted(cls, versor: Operators) -> Self:
        """A versor of a type that holds less as one of this type."""
        raise TypeError(f"{cls.__name__}: holds no {type(versor).__name__}")

    def __mul__(self, other: Operators) -> Any:
        """The geometric product, which composes: the same as ``@``."""
        return operator.matmul(self, other) if isinstance(other, Operators) else NotImplemented

    def __invert__(self) -> Self:
        """The reverse, which of unit versors is the inverse."""
        return self.inverse()

    def __neg__(self) -> Self:
        """The same motion by coefficients of the other sign."""
        return self._trusted(-self.coefficients)

    def __pow__(self, fraction: ArrayLike) -> Self:
        """A part of the motion: ``S ** 0.5`` twice is ``S``, ``S ** -1`` its inverse."""
        return self._power(fraction)

    def __format__(self, spec: str) -> str:
        """The sum of blades, its coefficients written by `spec`, as ``.3f``."""
        shown = self._shown()
        if not spec or shown is None:
            return repr(self)
        return " ".join(
            f"{value:+{spec}}" + ("" if blade == "1" else f" {blade}") for blade, value in shown
        )


# Below this sine of half the angle the long way round has lost its axis.
_LONG_WAY_SINE = 1e-7
_UNIT_TOLERANCE_SINGLE = 1e-5


@dataclass(frozen=True, eq=False, repr=False)
class Versor(Operators):
    """Unit versors, batch in the leading dimensions of `coefficients`.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or a norm more than 1e-6 from 1.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Rotor, Similarity, Versor
        >>> def halfway(start: Versor, end: Versor) -> Versor:
        ...     return start.retract(0.5 * start.local(end))
        >>> rng = np.random.default_rng(0)
        >>> for kind in (Rotor, Motor, Similarity):
        ...     a, b = kind.random(rng), kind.random(rng)
        ...     print(halfway(a, b).isclose(a.interpolate(b, 0.5)))
        True
        True
        True
    """

    _log_size: ClassVar[int]
    _blades: ClassVar[tuple[str, ...]]
    _unit: ClassVar[str]
    _kernels: ClassVar[VersorKernels]

    def __init_subclass__(cls) -> None:
        if "_kernels" in cls.__dict__:
            register_versor(cls, cls._size)

    @fast_path("of_coefficients", "ix", "i", UNIT_TOLERANCE)
    def __init__(self, coefficients: ArrayLike) -> None:
        values = self._checked(coefficients, self._field("coefficients"), (self._size,))
        self._check_unit(values)
        own = np.array(values, order="C", copy=True)
        object.__setattr__(self, "coefficients", sealed(own))

    @classmethod
    def _checked(cls, value: ArrayLike, name: str, trailing: tuple[int, ...]) -> FloatArray:
        """Checked numbers in the precision that they were given in."""
        checked = checked_floats(value, name, trailing)
        return checked.astype(common_precision(value), copy=False)

    @classmethod
    def _tolerance(cls, coefficients: FloatArray) -> float:
        """How far from unit given coefficients may be in their precision."""
        return UNIT_TOLERANCE if coefficients.dtype == np.float64 else _UNIT_TOLERANCE_SINGLE

    @classmethod
    def _check_unit(cls, coefficients: FloatArray) -> None:
        off, tolerance = cls._kernels.off(coefficients), cls._tolerance(coefficients)
        if not off <= tolerance:
            raise ValueError(
                f"{cls._field('coefficients')}: expected unit versors ({cls._unit} within "
                f"{tolerance:g}), got some off by {off:.3g}; {cls.__name__}.normalize projects "
                "other even elements"
            )

    @classmethod
    def _trusted(cls, coefficients: FloatArray) -> Self:
        """Wrap coefficients that a kernel has just made; they are frozen in place, not copied."""
        trusted = object.__new__(cls)
        object.__setattr__(trusted, "coefficients", sealed(coefficients))
        return trusted

    @classmethod
    def _of(cls, coefficients: FloatArray, *inputs: Any) -> Self:
        """Wrap what has just been computed from some inputs, in their common precision."""
        return cls._trusted(coefficients.astype(common_precision(*inputs), copy=False))

    @classmethod
    def identity(cls, shape: tuple[int, ...] = (), dtype: DTypeLike = np.float64) -> Self:
        """The motion that leaves everything where it is, repeated over the batch `shape`.

        Raises:
            ValueError: a dtype that is neither float32 nor float64.
        """
        precision = cls._precision(dtype, "identity")
        coefficients = np.zeros((*shape, cls._size), dtype=precision)
        coefficients[..., 0] = 1.0
        return cls._trusted(coefficients)

    @property
    def dtype(self) -> np.dtype[Any]:
        """The precision of the coefficients, float32 or float64."""
        return self.coefficients.dtype

    def astype(self, dtype: DTypeLike) -> Self:
        """The same versors in float32 or float64.

        Raises:
            ValueError: another type.
        """
        return self._trusted(self.coefficients.astype(self._precision(dtype, "astype")))

    @classmethod
    def _precision(cls, dtype: DTypeLike, verb: str) -> np.dtype[Any]:
        wanted = np.dtype(dtype)
        if wanted not in (np.float32, np.float64):
            raise ValueError(f"{cls._field(verb)}: expected float32 or float64, got {wanted}")
        return wanted

    def isclose(self, other: Self, rtol: float = 1e-5, atol: float = 1e-8) -> NDArray[np.bool_]:
        """Whether versors are the same motion to a tolerance, ``(*)`` bools; batches broadcast.

        As ``np.isclose``, on the largest difference of coefficients against the largest
        coefficient of `other`, whose sign is chosen: ``S`` and ``-S`` are one motion.

        Raises:
            TypeError: another type of versor, or of another precision.
            ValueError: batches that do not broadcast.
        """
        name = self._field("isclose")
        self._check_partner(other, name)
        a, b = self.coefficients, other.coefficients
        apart = np.minimum(*(np.max(np.abs(a - sign * b), axis=-1) for sign in (1, -1)))
        close: NDArray[np.bool_] = apart <= atol + rtol * np.max(np.abs(b), axis=-1)
        return close

    def _check_partner(self, other: Self, name: str) -> None:
        """Another versor of this type and precision, whose batch goes with this one."""
        if type(other) is not type(self):
            raise TypeError(
                f"{name}(other): expected a {type(self).__name__}, got {type(other).__name__}"
            )
        broadcast_batch(name, self.shape, other.shape)
        self._check_alike(name, self, other)

    @classmethod
    def _check_alike(cls, what: str, *values: Self) -> None:
        names = {one.coefficients.dtype.name for one in values}
        if len(names) > 1:
            raise TypeError(
                f"{what}: expected versors of one precision, got {' and '.join(sorted(names))}; "
                "astype converts"
            )

    @classmethod
    @fast_path("exp", "cx", "v")
    def exp(cls, log: ArrayLike) -> Self:
        """Versors from bivectors, the mirror of `log`.

        The formulas of both are in `ga/kernels/definitions`, `motors.py` and `similarities.py`.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        twists = cls._checked(log, cls._field("exp(log)"), (cls._log_size,))
        return cls._trusted(cls._kernels.exp(twists))

    @classmethod
    @abstractmethod
    def normalize(cls, coefficients: ArrayLike) -> Self:
        """Project even elements onto unit versors; zero is refused with ValueError."""

    @classmethod
    def _normalized(
        cls, coefficients: ArrayLike, nearest: Callable[..., tuple[FloatArray, float]]
    ) -> Self:
        name = cls._field("normalize(coefficients)")
        elements = given_floats(coefficients, name, (cls._size,))
        versors, least = nearest(elements)
        if not least > 0.0:
            checked_floats(elements, name, (cls._size,))
            raise ValueError(
                f"{name}: expected a non-zero rotor part m0..m3, got "
                f"{int(np.count_nonzero(~np.any(elements[..., :4], axis=-1)))} zero ones"
            )
        return cls._trusted(versors)

    # Algebra -----------------------------------------------------------------------------------

    @fast_path("compose", "vv", "v")
    def __matmul__(self, other: Self) -> Self:
        """Compose: ``(a @ b).apply(x) == a.apply(b.apply(x))``. Batches broadcast."""
        if type(other) is not type(self):
            return NotImplemented
        name = f"{type(self).__name__} @ {type(self).__name__}"
        broadcast_batch(name, self.shape, other.shape)
        self._check_alike(name, self, other)
        return self._trusted(self._kernels.compose(self.coefficients, other.coefficients))

    @fast_path("inverse", "v", "v")
    def inverse(self) -> Self:
        """The motion undone: ``m @ m.inverse()`` is the identity."""
        return self._trusted(self._kernels.inverse(self.coefficients))

    @fast_path("log", "v", "x")
    def log(self) -> FloatArray:
        """Bivector whose `exp` is this versor or its negative, the one that turns by at most π.

        Near zero and near π it keeps full precision. A turn by exactly π has two logarithms of
        equal length; the sign of the stored coefficients then says which one is returned.
        """
        return self._kernels.log(self.coefficients)

    @fast_path("apply", "vx", "x")
    def apply(self, points: ArrayLike) -> FloatArray:
        """Move points ``(*, 3)`` in metres: scaled where the type scales, turned, then moved.

        Directions turn with the `rotor`. Batches broadcast.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, batches that do not broadcast.
        """
        name = f"{type(self).__name__}.apply"
        positions = given_floats(points, f"{name}(points)", (3,))
        x = positions.astype(self.dtype, copy=False)
        broadcast_batch(name, self.shape, x.shape[:-1])
        moved, finite = self._kernels.checked_apply(self.coefficients, x)
        if not finite:
            checked_floats(positions, f"{name}(points)", (3,))
        return moved

    @classmethod
    def _of_twist(cls, twist: ArrayLike, name: str) -> FloatArray:
        """Coefficients of twists; where these are not finite they are refused."""
        twists = given_floats(twist, name, (cls._log_size,))
        motor, finite = cls._kernels.checked_of_twist(twists)
        if not finite:
            checked_floats(twists, name, (cls._log_size,))
        return motor

    @fast_path("interpolate", "vvf", "v")
    def interpolate(self, other: Self, fraction: ArrayLike, short_way: bool = True) -> Self:
        """Constant-speed path ``self exp(fraction log(~self other))``, the screw between the two.

        Args:
            other: where fraction 1 arrives (up to the versor's sign).
            fraction: any real number; it broadcasts with both batches, values outside [0, 1]
                extrapolate.
            short_way: turn by at most π. Otherwise the path follows the sign of the coefficients
                as they stand and may turn by up to 2π.

        Raises:
            TypeError: another type of versor, or of another precision.
            ValueError: NaN or infinite fraction, batches that do not broadcast, or the long way
                between two equal orientations of opposite sign, which has no axis.
        """
        name = f"{type(self).__name__}.interpolate"
        self._check_partner(other, name)
        steps = self._fractions(fraction, f"{name}(fraction)")
        broadcast_batch(name, self.shape, other.shape, steps.shape)
        if not short_way:
            self._check_long_way(other, name)
        return self._trusted(
            self._kernels.interpolate(self.coefficients, other.coefficients, steps, short_way)
        )

    def _power(self, fraction: ArrayLike) -> Self:
        still: Self = _identity(type(self), self.dtype)
        return still.interpolate(self, fraction)

    def _fractions(self, fraction: Any, name: str) -> FloatArray:
        """Checked fractions in this precision."""
        return checked_floats(fraction, name, ()).astype(self.coefficients.dtype, copy=False)

    def _check_long_way(self, other: Self, name: str) -> None:
        between = (self.inverse() @ other).coefficients
        sine = np.sqrt(np.sum(between[..., 1:4] ** 2, axis=-1))
        lost = int(np.count_nonzero((between[..., 0] < 0.0) & (sine < _LONG_WAY_SINE)))
        if lost:
            raise ValueError(
                f"{name}(short_way=False): expected a defined axis, got {lost} pairs of equal "
                "orientation and opposite sign"
            )

    # Tangents ----------------------------------------------------------------------------------

    @fast_path("retract", "vx", "v")
    def retract(self, twist: ArrayLike) -> Self:
        """Move by a twist ``(*, d)`` in the frame of this versor: ``S exp(x)``.

        The twist is taken in this versor's precision; batches broadcast.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, batches that do not broadcast.
        """
        step = self._twists(twist, "retract(twist)")
        return self._trusted(self._kernels.retract(self.coefficients, step))

    @fast_path("local", "vv", "x")
    def local(self, other: Self) -> FloatArray:
        """Twist ``(*, d)`` that takes this versor to `other`, which turns by at most π.

        ``a.retract(a.local(b))`` is ``b``, up to its sign.

        Raises:
            TypeError: another type of versor, or of another precision.
            ValueError: batches that do not broadcast.
        """
        name = f"{type(self).__name__}.local"
        self._check_partner(other, name)
        return self._kernels.local(self.coefficients, other.coefficients)

    @fast_path("adjoint", "v", "s")
    def adjoint(self) -> FloatArray:
        """Matrices ``(*, d, d)`` on twists with ``S exp(x) ~S = exp(Ad x)``.

        ``world_T_body.adjoint()`` takes a body's twist in its own frame to that in the world's.
        """
        return self._kernels.adjoint(self.coefficients)

    @fast_path("transform_twist", "vx", "x")
    def transform_twist(self, twist: ArrayLike) -> FloatArray:
        """Twists ``(*, d)`` from the frame on the right to the one on the left: `adjoint` of them.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, batches that do not broadcast.
        """
        twists = self._twists(twist, "transform_twist(twist)")
        return self._kernels.transform_twist(self.coefficients, twists)

    @classmethod
    @fast_path("left_jacobian", "cx", "s")
    def left_jacobian(cls, twist: ArrayLike) -> FloatArray:
        """Matrices ``(*, d, d)`` with ``exp(x + y) ≈ exp(J y) exp(x)`` for small ``y``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        return cls._kernels.left_jacobian(cls._checked_twist(twist, "left_jacobian"))

    @classmethod
    def right_jacobian(cls, twist: ArrayLike) -> FloatArray:
        """Matrices ``(*, d, d)`` with ``exp(x + y) ≈ exp(x) exp(J y)`` for small ``y``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        return cls._kernels.left_jacobian(-cls._checked_twist(twist, "right_jacobian"))

    @classmethod
    def left_jacobian_inverse(cls, twist: ArrayLike) -> FloatArray:
        """Matrices ``(*, d, d)``: how ``log(exp(y) exp(x))`` grows with a small ``y``.

        Near full turns the entries grow without bound.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        twists = cls._checked_twist(twist, "left_jacobian_inverse")
        return cls._kernels.left_jacobian_inverse(twists)

    @classmethod
    def right_jacobian_inverse(cls, twist: ArrayLike) -> FloatArray:
        """Matrices ``(*, d, d)``: how ``log(exp(x) exp(y))`` grows with a small ``y``.

        Near full turns the entries grow without bound.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        twists = cls._checked_twist(twist, "right_jacobian_inverse")
        return cls._kernels.left_jacobian_inverse(-twists)

    @classmethod
    def _checked_twist(cls, twist: ArrayLike, verb: str) -> FloatArray:
        return cls._checked(twist, cls._field(f"{verb}(twist)"), (cls._log_size,))

    def _twists(self, twist: ArrayLike, name: str) -> FloatArray:
        """Checked twists in this precision, whose batch goes with this one."""
        twists = checked_floats(twist, self._field(name), (self._log_size,))
        broadcast_batch(self._field(name), self.shape, twists.shape[:-1])
        return twists.astype(self.dtype, copy=False)

    def _shown(self) -> list[tuple[str, Any]] | None:
        single = not self.shape
        return list(zip(self._blades, self.coefficients.tolist(), strict=True)) if single else None


@cache
def _identity(kind: type[Versor], dtype: np.dtype[Any]) -> Any:
    return kind.identity(dtype=dtype)
