"""The kernels on twists: adjoint, Jacobians of exp, retract and local, on arrays ``(*, n)``.

A twist is ``-2 log``: rotation vector (rad), then translational part (m), then, of similarities,
logarithm of the scale; ``(*, 3)``, ``(*, 6)``, ``(*, 7)``. Precision and layout as in `batches`.
"""

from __future__ import annotations

from motorcade.ga.kernels.backend import function
from motorcade.ga.kernels.batches import Array, of_one, of_two

__all__ = ["MOTOR_TANGENTS", "ROTOR_TANGENTS", "SIMILARITY_TANGENTS", "TangentKernels"]


class TangentKernels:
    """The kernels of one kind of versor, found by the prefix of their names."""

    def __init__(self, prefix: str, versor_size: int, twist_size: int) -> None:
        self.versor_size = versor_size
        self.twist_size = twist_size
        self._adjoint = function(f"{prefix}adjoint")
        self._transform_twist = function(f"{prefix}transform_twist")
        self._left_jacobian = function(f"{prefix}left_jacobian")
        self._left_jacobian_inverse = function(f"{prefix}left_jacobian_inverse")
        self._retract = function(f"{prefix}retract")
        self._local = function(f"{prefix}local")

    def adjoint(self, m: Array) -> Array:
        """Matrices ``(*, d, d)`` with ``m exp(x) ~m = exp(Ad x)``."""
        return self._square(of_one(self._adjoint, m, self.twist_size**2))

    def transform_twist(self, m: Array, twist: Array) -> Array:
        """Twists ``Ad x``, without the matrix."""
        return of_two(self._transform_twist, m, twist, self.twist_size)

    def left_jacobian(self, twist: Array) -> Array:
        """Matrices with ``exp(x + y) ≈ exp(J y) exp(x)``; the right one is that of ``-x``."""
        return self._square(of_one(self._left_jacobian, twist, self.twist_size**2))

    def left_jacobian_inverse(self, twist: Array) -> Array:
        """The inverse of `left_jacobian`; not finite or huge at full turns."""
        return self._square(of_one(self._left_jacobian_inverse, twist, self.twist_size**2))

    def retract(self, m: Array, twist: Array) -> Array:
        """Versors ``m exp(x)``."""
        return of_two(self._retract, m, twist, self.versor_size)

    def local(self, a: Array, b: Array) -> Array:
        """Twists from ``a`` to ``b``, seen from ``a``, which turn by at most π."""
        return of_two(self._local, a, b, self.twist_size)

    def _square(self, rows: Array) -> Array:
        return rows.reshape(*rows.shape[:-1], self.twist_size, self.twist_size)


ROTOR_TANGENTS = TangentKernels("rotor_", 4, 3)
MOTOR_TANGENTS = TangentKernels("", 8, 6)
SIMILARITY_TANGENTS = TangentKernels("similarity_", 12, 7)
