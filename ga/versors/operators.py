"""What Python's operators mean on versors: comparison, products, powers, formats.

Two types compose as the one that holds more: a rotor beside a motor is the motor that turns alone.
"""

from __future__ import annotations

import operator
from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import CoefficientBatch, FloatArray
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
