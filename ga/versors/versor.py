"""The verbs that every versor type shares: compose, invert, exp and log, interpolate, and those of
Lie groups.

A versor acts by ``X' = S X ~S``; ``a @ b`` applies ``b`` first. ``S`` and ``-S`` are one motion.

A tangent is a twist, ``-2 log``: rotation vector (rad), then the translational part (m), then the
logarithm of the scale, as many of these as the type has. Small moves act in the versor's own frame,
on the right: ``a.retract(x) = a @ exp(x)``, ``a.local(b)`` is the twist that takes ``a`` to ``b``.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from math import isfinite
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.ga.kernels.batches import TangentKernels
from motorcade.ga.versors.batch import VersorBatch, broadcast_batch

__all__ = ["Versor", "VersorKernels"]

# Below this sine of half the angle the long way round has lost its axis.
_LONG_WAY_SINE = 1e-7


class VersorKernels(NamedTuple):
    """What a versor type computes with, on coefficient arrays whose batches broadcast."""

    compose: Callable[[FloatArray, FloatArray], FloatArray]
    inverse: Callable[[FloatArray], FloatArray]
    exp: Callable[[FloatArray], FloatArray]
    log: Callable[[FloatArray], FloatArray]
    interpolate: Callable[[FloatArray, FloatArray, FloatArray, bool], FloatArray]
    tangents: TangentKernels


class Versor(VersorBatch):
    """Unit versors, batch in the leading dimensions of `coefficients`.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or a norm more than 1e-6 from 1.
    """

    _log_size: ClassVar[int]
    _kernels: ClassVar[VersorKernels]

    @classmethod
    def exp(cls, log: ArrayLike) -> Self:
        """Versors from bivectors, the mirror of `log`.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        given = cls._checked(log, cls._field("exp(log)"), (cls._log_size,))
        return cls._trusted(cls._kernels.exp(given))

    @classmethod
    @abstractmethod
    def normalize(cls, coefficients: ArrayLike) -> Self:
        """Project even elements onto unit versors; zero is refused with ValueError."""

    # Algebra -----------------------------------------------------------------------------------

    def __matmul__(self, other: Self) -> Self:
        """Compose: ``(a @ b).apply(x) == a.apply(b.apply(x))``. Batches broadcast."""
        if type(other) is not type(self):
            return NotImplemented
        name = f"{type(self).__name__} @ {type(self).__name__}"
        broadcast_batch(name, self.shape, other.shape)
        if other.coefficients.dtype != self.coefficients.dtype:
            self._check_precision(name, self, other)
        return self._trusted(self._kernels.compose(self.coefficients, other.coefficients))

    def inverse(self) -> Self:
        """The motion undone: ``m @ m.inverse()`` is the identity."""
        return self._trusted(self._kernels.inverse(self.coefficients))

    def log(self) -> FloatArray:
        """Bivector whose `exp` is this versor or its negative, the one that turns by at most π.

        Near zero and near π it keeps full precision. A turn by exactly π has two logarithms of
        equal length; the sign of the stored coefficients then says which one is returned.
        """
        return self._kernels.log(self.coefficients)

    @abstractmethod
    def apply(self, points: ArrayLike) -> FloatArray:
        """Move points ``(*, 3)``; batch shapes broadcast."""

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

    def _fractions(self, fraction: Any, name: str) -> FloatArray:
        """Checked fractions in this precision."""
        if isinstance(fraction, float) and isfinite(fraction):  # most often, and much faster
            return np.asarray(fraction, dtype=self.coefficients.dtype)
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

    def retract(self, twist: ArrayLike) -> Self:
        """Move by a twist ``(*, d)`` in the frame of this versor: ``S exp(x)``.

        The twist is taken in this versor's precision; batches broadcast.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, batches that do not broadcast.
        """
        given = self._twists(twist, "retract(twist)")
        return self._trusted(self._kernels.tangents.retract(self.coefficients, given))

    def local(self, other: Self) -> FloatArray:
        """Twist ``(*, d)`` that takes this versor to `other`, which turns by at most π.

        ``a.retract(a.local(b))`` is ``b``, up to its sign.

        Raises:
            TypeError: another type of versor, or of another precision.
            ValueError: batches that do not broadcast.
        """
        name = f"{type(self).__name__}.local"
        self._check_partner(other, name)
        return self._kernels.tangents.local(self.coefficients, other.coefficients)

    def adjoint(self) -> FloatArray:
        """Matrices ``(*, d, d)`` on twists with ``S exp(x) ~S = exp(Ad x)``.

        ``world_T_body.adjoint()`` takes a body's twist in its own frame to that in the world's.
        """
        return self._kernels.tangents.adjoint(self.coefficients)

    def transform_twist(self, twist: ArrayLike) -> FloatArray:
        """Twists ``(*, d)`` from the frame on the right to the one on the left: `adjoint` of them.

        Raises:
            ValueError: wrong last dimension, NaN or infinity, batches that do not broadcast.
        """
        given = self._twists(twist, "transform_twist(twist)")
        return self._kernels.tangents.transform_twist(self.coefficients, given)

    @classmethod
    def left_jacobian(cls, twist: ArrayLike) -> FloatArray:
        """Matrices ``(*, d, d)`` with ``exp(x + y) ≈ exp(J y) exp(x)`` for small ``y``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        return cls._kernels.tangents.left_jacobian(cls._checked_twist(twist, "left_jacobian"))

    @classmethod
    def right_jacobian(cls, twist: ArrayLike) -> FloatArray:
        """Matrices ``(*, d, d)`` with ``exp(x + y) ≈ exp(x) exp(J y)`` for small ``y``.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        return cls._kernels.tangents.left_jacobian(-cls._checked_twist(twist, "right_jacobian"))

    @classmethod
    def left_jacobian_inverse(cls, twist: ArrayLike) -> FloatArray:
        """Matrices ``(*, d, d)``: how ``log(exp(y) exp(x))`` grows with a small ``y``.

        Near full turns the entries grow without bound.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        given = cls._checked_twist(twist, "left_jacobian_inverse")
        return cls._kernels.tangents.left_jacobian_inverse(given)

    @classmethod
    def right_jacobian_inverse(cls, twist: ArrayLike) -> FloatArray:
        """Matrices ``(*, d, d)``: how ``log(exp(x) exp(y))`` grows with a small ``y``.

        Near full turns the entries grow without bound.

        Raises:
            ValueError: wrong last dimension, NaN or infinity.
        """
        given = cls._checked_twist(twist, "right_jacobian_inverse")
        return cls._kernels.tangents.left_jacobian_inverse(-given)

    @classmethod
    def _checked_twist(cls, twist: ArrayLike, verb: str) -> FloatArray:
        return cls._checked(twist, cls._field(f"{verb}(twist)"), (cls._log_size,))

    def _twists(self, twist: ArrayLike, name: str) -> FloatArray:
        """Checked twists in this precision, whose batch goes with this one."""
        given = checked_floats(twist, self._field(name), (self._log_size,))
        broadcast_batch(self._field(name), self.shape, given.shape[:-1])
        return given.astype(self.dtype, copy=False)
