"""Multivector: a sparse sum of basis blades with coefficients of any scalar kind.

Its type is its set of blades: a blade that is not there is zero by structure and costs nothing.
``a * b`` geometric, ``a ^ b`` outer, ``a | b`` Hestenes' inner product (zero where either is a
scalar), ``a & b`` regressive, ``~a`` reverse, ``a ** n`` powers, ``a["e1^e2"]`` a coefficient,
``a[2]`` a grade. Python's ``^``, ``|`` and ``&`` bind looser than ``+``: write the brackets.
Coefficients may be NumPy batches, which broadcast. Values are frozen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from motorcade.ga.algebra import exponential, logarithm
from motorcade.ga.algebra.blade_sum import BladeSum
from motorcade.ga.algebra.inverse import inverse
from motorcade.ga.algebra.scalars import checked_scalar, is_zero_somewhere


class Multivector(BladeSum):
    """A sum of basis blades of one algebra; see `Algebra.multivector`.

    Raises:
        ValueError: a blade that is not in the algebra, a coefficient that is no real scalar, NaN
            or infinity.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import EGA3
        >>> e1, e2 = EGA3.blade("e1"), EGA3.blade("e2")
        >>> quarter = (-np.pi / 4 * (e1 ^ e2)).exp()
        >>> quarter.sandwich(e1).isclose(e2)
        True
        >>> (quarter**4).isclose(-1)
        True
        >>> (2 * e1 + 3 * (e1 ^ e2))["e2^e1"]
        -3
    """

    __slots__ = ()

    def __truediv__(self, other: Any) -> Multivector:
        """``a / b`` is ``a * b.inverse()``."""
        if isinstance(other, Multivector):
            self._same_algebra(other)
            return self * other.inverse()
        divisor = checked_scalar(other, "divisor")
        if is_zero_somewhere(divisor):
            raise ValueError("divisor: expected a number that is not zero, got zero")
        return self._divided(divisor)

    def __rtruediv__(self, other: Any) -> Multivector:
        return self.inverse()._scaled(other)

    def __pow__(self, exponent: int) -> Multivector:
        """``x x … x`` for whole exponents; negative ones multiply inverses.

        Raises:
            ValueError: an exponent that is not whole, or a negative one of what has no inverse.
        """
        if isinstance(exponent, bool) or not isinstance(exponent, int | np.integer):
            raise ValueError(f"**: expected a whole exponent, got {exponent!r}; see exp and sqrt")
        factor, left = (self if exponent >= 0 else self.inverse()), abs(int(exponent))
        multivector: Multivector | None = None
        while left:
            if left & 1:
                multivector = factor if multivector is None else multivector * factor
            left >>= 1
            factor = factor.square() if left else factor
        return self._lifted(1) if multivector is None else multivector

    def inverse(self) -> Multivector:
        """The multivector ``y`` with ``x y = y x = 1``; see `algebra.inverse`.

        Raises:
            ValueError: not invertible, or one of a batch is not.
        """
        return self._function(inverse)

    def exp(self) -> Multivector:
        """``1 + x + x²/2! + …``; see `algebra.exponential`; `algebra.logarithm` has the others."""
        return self._function(exponential.exp)

    def log(self) -> Multivector:
        """The ``y`` with ``exp y = x`` whose angles are at most π."""
        return self._function(logarithm.log)

    def sqrt(self) -> Multivector:
        """The ``y`` with ``y y = x`` whose angles are at most π/2."""
        return self._function(logarithm.sqrt)

    def normalize(self) -> Multivector:
        """``x / √|⟨x ~x⟩₀|``."""
        return self._function(logarithm.normalize)

    def versor(self) -> Multivector:
        """The unit versor that `x` is a disturbed multiple of."""
        return self._function(logarithm.versor)

    def _function(self, function: Callable[[Any], Any]) -> Multivector:
        multivector: Multivector = function(self)
        return multivector
