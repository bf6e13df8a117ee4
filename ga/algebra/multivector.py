"""Multivector: a sparse sum of basis blades with coefficients of any scalar kind.

Its type is its set of blades: a blade that is not there is zero by structure and costs nothing.
``a * b`` geometric, ``a ^ b`` outer, ``a | b`` Hestenes' inner product (zero where either is a
scalar), ``a & b`` regressive, ``~a`` reverse. Python's ``^``, ``|`` and ``&`` bind looser than
``+``: write the brackets. Coefficients may be NumPy batches, which broadcast. Values are frozen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from motorcade.ga.algebra.basis import Terms, grade_of, order_of, reorder_sign
from motorcade.ga.algebra.products import Masks, Plan, apply_plan
from motorcade.ga.algebra.scalars import checked_scalar, is_zero_somewhere, magnitude, square_root
from motorcade.ga.algebra.value import Value
from motorcade.ga.arrays import sealed

if TYPE_CHECKING:
    from motorcade.ga.algebra.signature import Algebra

__all__ = ["Multivector"]


class Multivector(Value):
    """A sum of basis blades of one algebra; see `Algebra.multivector`.

    Raises:
        ValueError: a blade that is not in the algebra, a coefficient that is no real scalar, NaN
            or infinity.
    """

    __slots__ = ("algebra", "masks", "values")

    algebra: Algebra
    masks: Masks
    values: tuple[Any, ...]

    # NumPy arrays must not try to broadcast over a multivector: array * x is x with a batch.
    __array_ufunc__: ClassVar[None] = None

    def __init__(self, algebra: Algebra, coefficients: Mapping[str, Any]) -> None:
        total: dict[int, Any] = {}
        for name, given in coefficients.items():
            terms = algebra.masks_of(name)
            if isinstance(given, Multivector):
                raise ValueError(f"coefficient of {name}: expected a real scalar, got {given!r}")
            value = checked_scalar(given, f"coefficient of {name}")
            for mask, factor in terms:
                part = value if factor == 1.0 else -value if factor == -1.0 else value * factor
                total[mask] = total[mask] + part if mask in total else part
        masks = tuple(sorted(total, key=order_of))
        self._set(algebra, masks, (total[mask] for mask in masks))

    @classmethod
    def _trusted(cls, algebra: Algebra, masks: Masks, values: Iterable[Any]) -> Multivector:
        """Wrap coefficients that a product has just made, blades in their order."""
        made = object.__new__(cls)
        made._set(algebra, masks, values)
        return made

    def _set(self, algebra: Algebra, masks: Masks, values: Iterable[Any]) -> None:
        frozen = tuple(sealed(v) if isinstance(v, np.ndarray) else v for v in values)
        object.__setattr__(self, "algebra", algebra)
        object.__setattr__(self, "masks", masks)
        object.__setattr__(self, "values", frozen)

    def __reduce__(self) -> tuple[Any, ...]:
        return Multivector._trusted, (self.algebra, self.masks, self.values)

    # Reading -----------------------------------------------------------------------------------

    @property
    def blades(self) -> tuple[str, ...]:
        """Names of the blades that it has, by grade, then in the order of the basis."""
        return tuple(self.algebra.blade_name(mask) for mask in self.masks)

    @property
    def grades(self) -> tuple[int, ...]:
        """The grades that it has, ascending."""
        return tuple(sorted({grade_of(mask) for mask in self.masks}))

    def items(self) -> tuple[tuple[str, Any], ...]:
        """Pairs of blade name and coefficient, in the order of `blades`."""
        return tuple(zip(self.blades, self.values, strict=True))

    def coefficient(self, blade: str) -> Any:
        """The coefficient of a basis blade, 0.0 where it has none; ``e3^e1`` negates ``e1^e3``.

        Raises:
            ValueError: a name that is not in the algebra or stands for no single basis blade.
        """
        terms = self.algebra.masks_of(blade)
        if len(terms) != 1 or abs(terms[0][1]) != 1.0:
            raise ValueError(
                f"{self.algebra}: expected a blade of {' '.join(self.algebra.names)}, "
                f"got {blade!r}; as_orthogonal gives coefficients on ep and em"
            )
        mask, sign = terms[0]
        if mask not in self.masks:
            return 0.0
        value = self.values[self.masks.index(mask)]
        return value if sign > 0 else -value

    def scalar_part(self) -> Any:
        """The coefficient of ``1``."""
        return self.values[0] if self.masks and self.masks[0] == 0 else 0.0

    def __repr__(self) -> str:
        return " + ".join(f"({value})*{name}" for name, value in self.items()) or "0"

    # Sums and scalars --------------------------------------------------------------------------

    def _with(self, values: Iterable[Any]) -> Multivector:
        return Multivector._trusted(self.algebra, self.masks, values)

    def _same_algebra(self, other: Multivector) -> None:
        if self.algebra is not other.algebra and self.algebra != other.algebra:
            raise ValueError(
                f"expected two multivectors of one algebra, got {self.algebra} and {other.algebra}"
            )

    def _lifted(self, other: Any) -> Multivector:
        """A multivector of this algebra: the other one itself, or a scalar."""
        if isinstance(other, Multivector):
            self._same_algebra(other)
            return other
        return Multivector._trusted(self.algebra, (0,), (checked_scalar(other, "scalar"),))

    def __add__(self, other: Any) -> Multivector:
        right = self._lifted(other)
        total = dict(zip(self.masks, self.values, strict=True))
        for mask, value in zip(right.masks, right.values, strict=True):
            total[mask] = total[mask] + value if mask in total else value
        masks = tuple(sorted(total, key=order_of))
        return Multivector._trusted(self.algebra, masks, (total[mask] for mask in masks))

    def __sub__(self, other: Any) -> Multivector:
        right = self._lifted(other)
        total = dict(zip(self.masks, self.values, strict=True))
        for mask, value in zip(right.masks, right.values, strict=True):
            total[mask] = total[mask] - value if mask in total else -value
        masks = tuple(sorted(total, key=order_of))
        return Multivector._trusted(self.algebra, masks, (total[mask] for mask in masks))

    def __radd__(self, other: Any) -> Multivector:
        return self._lifted(other) + self

    def __rsub__(self, other: Any) -> Multivector:
        return self._lifted(other) - self

    def __neg__(self) -> Multivector:
        return self._with(-value for value in self.values)

    def __pos__(self) -> Multivector:
        return self

    def _scaled(self, scalar: Any) -> Multivector:
        factor = checked_scalar(scalar, "scalar")
        return self._with(value * factor for value in self.values)

    def _divided(self, divisor: Any) -> Multivector:
        return self._with(value / divisor for value in self.values)

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

    # Products ----------------------------------------------------------------------------------

    def _product(
        self, kind: str, other: Multivector, grades: frozenset[int] | None = None
    ) -> Multivector:
        self._same_algebra(other)
        plan = self.algebra.plan(kind, self.masks, other.masks, grades)
        values = apply_plan(plan, self.values, other.values)
        return Multivector._trusted(self.algebra, plan.masks, values)

    def __mul__(self, other: Any) -> Multivector:
        if isinstance(other, Multivector):
            return self._product("geometric", other)
        return self._scaled(other)

    def __rmul__(self, other: Any) -> Multivector:
        return self._scaled(other)

    def __xor__(self, other: Any) -> Multivector:
        return self._product("outer", self._lifted(other))

    def __rxor__(self, other: Any) -> Multivector:
        return self._lifted(other) ^ self

    def __or__(self, other: Any) -> Multivector:
        return self._product("inner", self._lifted(other))

    def __ror__(self, other: Any) -> Multivector:
        return self._lifted(other) | self

    def __and__(self, other: Multivector) -> Multivector:
        """Regressive product: the complements' outer product, back from the complement."""
        return (self.complement() ^ self._lifted(other).complement()).uncomplement()

    def commutator(self, other: Multivector) -> Multivector:
        """``½ (a b - b a)``, without the terms that commute."""
        return self._product("commutator", self._lifted(other))

    def sandwich(self, other: Multivector) -> Multivector:
        """``s x ~s`` on the grades of `other`: all of it where `self` is a versor.

        The other grades, which cancel for a versor, are not computed.
        """
        self._same_algebra(other)
        return (self * other)._product("geometric", ~self, frozenset(other.grades))

    def _reverse_plan(self) -> Plan:
        """The terms of ``x ~x`` on the blades of `self`."""
        signs = tuple(_reverse_sign(grade_of(mask)) for mask in self.masks)
        return self.algebra.symmetric_plan(self.masks, signs)

    def reverse_product(self) -> Multivector:
        """``x ~x``, without the terms that cancel by symmetry."""
        plan = self._reverse_plan()
        return Multivector._trusted(
            self.algebra, plan.masks, apply_plan(plan, self.values, self.values)
        )

    def square(self) -> Multivector:
        """``x x``, without the terms that cancel by symmetry."""
        plan = self.algebra.symmetric_plan(self.masks, (1,) * len(self.masks))
        return Multivector._trusted(
            self.algebra, plan.masks, apply_plan(plan, self.values, self.values)
        )

    # Involutions, grades, duals ----------------------------------------------------------------

    def _signed(self, sign: Callable[[int], int]) -> Multivector:
        signs = (sign(grade_of(mask)) for mask in self.masks)
        return self._with(v if s > 0 else -v for s, v in zip(signs, self.values, strict=True))

    def __invert__(self) -> Multivector:
        """Reverse: the order of all vector factors turned round."""
        return self._signed(_reverse_sign)

    def involute(self) -> Multivector:
        """Grade involution: all vectors negated, so odd grades change their sign."""
        return self._signed(lambda grade: -1 if grade & 1 else 1)

    def conjugate(self) -> Multivector:
        """Clifford conjugate: reverse and grade involution."""
        return self._signed(lambda grade: -1 if grade % 4 in (1, 2) else 1)

    def grade(self, *grades: int) -> Multivector:
        """The part of the given grades."""
        return self._selected(lambda mask: grade_of(mask) in grades)

    def _selected(self, wanted: Callable[[int], bool]) -> Multivector:
        kept = [pair for pair in zip(self.masks, self.values, strict=True) if wanted(pair[0])]
        return Multivector._trusted(
            self.algebra, tuple(mask for mask, _ in kept), (value for _, value in kept)
        )

    def dual(self) -> Multivector:
        """``x I⁻¹`` with the algebra's pseudoscalar ``I``.

        Raises:
            ValueError: ``I² = 0``; `complement` needs no metric.
        """
        whole = self.algebra.pseudoscalar
        return self * (whole._scaled(self._pseudoscalar_square()))

    def undual(self) -> Multivector:
        """``x I``, the mirror of `dual`.

        Raises:
            ValueError: ``I² = 0``.
        """
        self._pseudoscalar_square()
        return self * self.algebra.pseudoscalar

    def _pseudoscalar_square(self) -> float:
        square = self.algebra.pseudoscalar.square().scalar_part()
        if square == 0.0:
            raise ValueError(
                f"{self.algebra}: expected an invertible pseudoscalar for a dual, got I² = 0; "
                "complement and uncomplement need no metric"
            )
        return float(square)

    def complement(self) -> Multivector:
        """The right complement: basis blade ``b`` becomes ``c`` with ``b ∧ c = I``."""
        return self._complemented(left=False)

    def uncomplement(self) -> Multivector:
        """The mirror of `complement`: basis blade ``c`` becomes ``b`` with ``b ∧ c = I``."""
        return self._complemented(left=True)

    def _complemented(self, left: bool) -> Multivector:
        whole = (1 << self.algebra.dimension) - 1
        orientation = float(self.algebra.pseudoscalar.values[0])
        made = {}
        for mask, value in zip(self.masks, self.values, strict=True):
            rest = whole ^ mask
            sign = reorder_sign(rest, mask) if left else reorder_sign(mask, rest)
            made[rest] = value if sign * orientation > 0 else -value
        masks = tuple(sorted(made, key=order_of))
        return Multivector._trusted(self.algebra, masks, (made[mask] for mask in masks))

    def as_orthogonal(self) -> Multivector:
        """The same multivector on the orthogonal basis, in `Algebra.orthogonal`."""
        return self._exchanged(self.algebra.orthogonal, self.algebra.basis.to_orthogonal)

    def from_orthogonal(self, algebra: Algebra) -> Multivector:
        """The mirror of `as_orthogonal`: the same multivector on the basis of `algebra`.

        Raises:
            ValueError: `algebra` is not on this basis when written orthogonally.
        """
        if algebra.orthogonal != self.algebra:
            raise ValueError(
                f"from_orthogonal: expected a multivector of {algebra.orthogonal}, "
                f"got one of {self.algebra}"
            )
        return self._exchanged(algebra, algebra.basis.from_orthogonal)

    def _exchanged(self, algebra: Algebra, written: Callable[[int], Terms]) -> Multivector:
        total: dict[int, Any] = {}
        for mask, value in zip(self.masks, self.values, strict=True):
            for other, factor in written(mask):
                part = value * factor
                total[other] = total[other] + part if other in total else part
        masks = tuple(sorted(total, key=order_of))
        return Multivector._trusted(algebra, masks, (total[mask] for mask in masks))

    # Size, inverse and functions ---------------------------------------------------------------

    def norm_squared(self) -> Any:
        """``⟨x ~x⟩₀``; negative or zero for some x where the signature is mixed or degenerate."""
        return self.reverse_product().scalar_part()

    def norm(self) -> Any:
        """``√|⟨x ~x⟩₀|``."""
        return square_root(magnitude(self.norm_squared()))

    def inverse(self) -> Multivector:
        """The multivector ``y`` with ``x y = y x = 1``; see `algebra.inverse`.

        Raises:
            ValueError: not invertible, or one of a batch is not.
        """
        from motorcade.ga.algebra.inverse import inverse

        return inverse(self)

    def exp(self) -> Multivector:
        """``1 + x + x²/2! + …``; see `algebra.functions`, as for the four below."""
        return self._function("exp")

    def log(self) -> Multivector:
        """The ``y`` with ``exp y = x`` whose angles are at most π."""
        return self._function("log")

    def sqrt(self) -> Multivector:
        """The ``y`` with ``y y = x`` whose angles are at most π/2."""
        return self._function("sqrt")

    def normalize(self) -> Multivector:
        """``x / √|⟨x ~x⟩₀|``."""
        return self._function("normalize")

    def versor(self) -> Multivector:
        """The unit versor that `x` is a disturbed multiple of."""
        return self._function("versor")

    def _function(self, name: str) -> Multivector:
        from motorcade.ga.algebra import functions

        made: Multivector = getattr(functions, name)(self)
        return made


def _reverse_sign(grade: int) -> int:
    return -1 if grade % 4 in (2, 3) else 1
