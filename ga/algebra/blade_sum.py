"""What a sum of basis blades is: coefficients, sums and products, grades and duals.

`BladeSum` has all that needs no function of the coefficients beyond the square root; `Multivector`
adds inverses, powers, exponentials and their like, which are written over elements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, ClassVar, Self

import numpy as np

from motorcade.ga.algebra.basis import Terms, grade_of, order_of, reorder_sign
from motorcade.ga.algebra.products import Masks, Plan, apply_plan
from motorcade.ga.algebra.scalars import checked_scalar, is_numeric, magnitude, scaled, square_root
from motorcade.ga.algebra.signature import Signature
from motorcade.ga.arrays import sealed
from motorcade.ga.notation import ShownAsSum, sum_text


class Value:
    """Attributes are set once, by ``object.__setattr__``; only coefficients can be compared.

    Without that ``if x:`` and ``x == 0`` would pass unseen over symbols, and mean little over
    batches.
    """

    __slots__ = ()

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a multivector is frozen: {name} cannot be set")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a multivector is frozen: {name} cannot be deleted")

    def __bool__(self) -> bool:
        raise TypeError("a multivector has no truth value: test its coefficients")

    def __eq__(self, other: object) -> bool:
        raise TypeError(
            "multivectors: == is not defined; isclose compares numbers, coefficients compare alone"
        )

    def __hash__(self) -> int:
        raise TypeError(f"unhashable type: {type(self).__name__}")


class BladeSum(Value, ShownAsSum):
    """A sum of basis blades of one algebra, the base of `Multivector`.

    Raises ValueError: a blade that is not in the algebra, a coefficient that is no real scalar, NaN
    or infinity.
    """

    __slots__ = ("algebra", "masks", "values")

    algebra: Signature
    masks: Masks
    values: tuple[Any, ...]

    # NumPy arrays must not try to broadcast over a multivector: array * x is x with a batch.
    __array_ufunc__: ClassVar[None] = None

    def __init__(self, algebra: Signature, coefficients: Mapping[str, Any]) -> None:
        total: dict[int, Any] = {}
        for name, coefficient in coefficients.items():
            terms = algebra.masks_of(name)
            if isinstance(coefficient, BladeSum):
                raise ValueError(
                    f"coefficient of {name}: expected a real scalar, got {coefficient!r}"
                )
            value = checked_scalar(coefficient, f"coefficient of {name}")
            for mask, factor in terms:
                part = scaled(factor, value)
                total[mask] = total[mask] + part if mask in total else part
        masks = tuple(sorted(total, key=order_of))
        self._set(algebra, masks, (total[mask] for mask in masks))

    @classmethod
    def _trusted(cls, algebra: Signature, masks: Masks, values: Iterable[Any]) -> Self:
        """Wrap coefficients that a product has just made, blades in their order."""
        trusted = object.__new__(cls)
        trusted._set(algebra, masks, values)
        return trusted

    def _wrap(self, masks: Masks, values: Iterable[Any], algebra: Signature | None = None) -> Self:
        """Wrap coefficients made from these, in this algebra unless another is given."""
        return self._trusted(self.algebra if algebra is None else algebra, masks, values)

    def _set(self, algebra: Signature, masks: Masks, values: Iterable[Any]) -> None:
        frozen = tuple(sealed(v) if isinstance(v, np.ndarray) else v for v in values)
        object.__setattr__(self, "algebra", algebra)
        object.__setattr__(self, "masks", masks)
        object.__setattr__(self, "values", frozen)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self)._trusted, (self.algebra, self.masks, self.values)

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

    def __getitem__(self, part: str | int) -> Any:
        """``x["e1^e2"]`` is the `coefficient` of a blade, ``x[2]`` the `grade` of that number."""
        if isinstance(part, str):
            return self.coefficient(part)
        if isinstance(part, int | np.integer) and 0 <= part <= self.algebra.dimension:
            return self.grade(int(part))
        raise ValueError(
            f"{self.algebra}: expected the name of a blade or a grade from 0 to "
            f"{self.algebra.dimension}, got {part!r}"
        )

    # Without this Python would take grades for items.
    __iter__ = None

    def coefficient(self, blade: str) -> Any:
        """The coefficient of a basis blade, 0.0 where it has none; ``e3^e1`` negates ``e1^e3``.

        Raises ValueError: a name that is not in the algebra or stands for no single basis blade.
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
        return sum_text(self.items())

    def _shown(self) -> tuple[tuple[str, Any], ...]:
        return self.items()

    # Sums and scalars --------------------------------------------------------------------------

    def _with(self, values: Iterable[Any]) -> Self:
        return self._wrap(self.masks, values)

    def _same_algebra(self, other: BladeSum) -> None:
        if self.algebra is not other.algebra and self.algebra != other.algebra:
            raise ValueError(
                f"expected two multivectors of one algebra, got {self.algebra} and {other.algebra}"
            )

    def _lifted(self, other: Any) -> Self:
        """A multivector of this algebra: the other one itself, or a scalar."""
        if isinstance(other, BladeSum):
            self._same_algebra(other)
            same: Any = other
            return same  # type: ignore[no-any-return]
        return self._wrap((0,), (checked_scalar(other, "scalar"),))

    def __add__(self, other: Any) -> Self:
        right = self._lifted(other)
        total = dict(zip(self.masks, self.values, strict=True))
        for mask, value in zip(right.masks, right.values, strict=True):
            total[mask] = total[mask] + value if mask in total else value
        masks = tuple(sorted(total, key=order_of))
        return self._wrap(masks, (total[mask] for mask in masks))

    def __sub__(self, other: Any) -> Self:
        right = self._lifted(other)
        total = dict(zip(self.masks, self.values, strict=True))
        for mask, value in zip(right.masks, right.values, strict=True):
            total[mask] = total[mask] - value if mask in total else -value
        masks = tuple(sorted(total, key=order_of))
        return self._wrap(masks, (total[mask] for mask in masks))

    def __radd__(self, other: Any) -> Self:
        return self._lifted(other) + self

    def __rsub__(self, other: Any) -> Self:
        return self._lifted(other) - self

    def __neg__(self) -> Self:
        return self._with(-value for value in self.values)

    def __pos__(self) -> Self:
        return self

    def _scaled(self, scalar: Any) -> Self:
        factor = checked_scalar(scalar, "scalar")
        return self._with(value * factor for value in self.values)

    def _divided(self, divisor: Any) -> Self:
        return self._with(value / divisor for value in self.values)

    # Products ----------------------------------------------------------------------------------

    def _product(self, kind: str, other: BladeSum, grades: frozenset[int] | None = None) -> Self:
        self._same_algebra(other)
        plan = self.algebra.plan(kind, self.masks, other.masks, grades)
        values = apply_plan(plan, self.values, other.values)
        return self._wrap(plan.masks, values)

    def __mul__(self, other: Any) -> Self:
        if isinstance(other, BladeSum):
            return self._product("geometric", other)
        return self._scaled(other)

    def __rmul__(self, other: Any) -> Self:
        return self._scaled(other)

    def __xor__(self, other: Any) -> Self:
        return self._product("outer", self._lifted(other))

    def __rxor__(self, other: Any) -> Self:
        return self._lifted(other) ^ self

    def __or__(self, other: Any) -> Self:
        return self._product("inner", self._lifted(other))

    def __ror__(self, other: Any) -> Self:
        return self._lifted(other) | self

    def left_contraction(self, other: Any) -> Self:
        """``a ⌋ b``: of blades the grade ``s - r``, zero where the left grade r is the higher."""
        return self._product("left", self._lifted(other))

    def right_contraction(self, other: Any) -> Self:
        """``a ⌊ b``: of blades the grade ``r - s``, zero where the right grade s is the higher."""
        return self._product("right", self._lifted(other))

    def __and__(self, other: BladeSum) -> Self:
        """Regressive product: the complements' outer product, back from the complement."""
        return (self.complement() ^ self._lifted(other).complement()).uncomplement()

    def commutator(self, other: BladeSum) -> Self:
        """``½ (a b - b a)``, without the terms that commute."""
        return self._product("commutator", self._lifted(other))

    def sandwich(self, other: BladeSum) -> Self:
        """``s x ~s`` on the grades of `other`: all of it where `self` is a versor.

        The other grades, which cancel for a versor, are not computed.
        """
        self._same_algebra(other)
        return (self * other)._product("geometric", ~self, frozenset(other.grades))

    def _reverse_plan(self) -> Plan:
        """The terms of ``x ~x`` on the blades of `self`."""
        signs = tuple(_reverse_sign(grade_of(mask)) for mask in self.masks)
        return self.algebra.symmetric_plan(self.masks, signs)

    def reverse_product(self) -> Self:
        """``x ~x``, without the terms that cancel by symmetry."""
        plan = self._reverse_plan()
        return self._wrap(plan.masks, apply_plan(plan, self.values, self.values))

    def square(self) -> Self:
        """``x x``, without the terms that cancel by symmetry."""
        plan = self.algebra.symmetric_plan(self.masks, (1,) * len(self.masks))
        return self._wrap(plan.masks, apply_plan(plan, self.values, self.values))

    # Involutions, grades, duals ----------------------------------------------------------------

    def _signed(self, sign: Callable[[int], int]) -> Self:
        signs = (sign(grade_of(mask)) for mask in self.masks)
        return self._with(v if s > 0 else -v for s, v in zip(signs, self.values, strict=True))

    def __invert__(self) -> Self:
        """Reverse: the order of all vector factors turned round."""
        return self._signed(_reverse_sign)

    def involute(self) -> Self:
        """Grade involution: all vectors negated, so odd grades change their sign."""
        return self._signed(lambda grade: -1 if grade & 1 else 1)

    def conjugate(self) -> Self:
        """Clifford conjugate: reverse and grade involution."""
        return self._signed(lambda grade: -1 if grade % 4 in (1, 2) else 1)

    def grade(self, *grades: int) -> Self:
        """The part of the given grades."""
        return self._selected(lambda mask: grade_of(mask) in grades)

    def _selected(self, wanted: Callable[[int], bool]) -> Self:
        kept = [pair for pair in zip(self.masks, self.values, strict=True) if wanted(pair[0])]
        return self._wrap(tuple(mask for mask, _ in kept), (value for _, value in kept))

    def dual(self) -> Self:
        """``x I⁻¹`` with the algebra's pseudoscalar ``I``.

        Raises ValueError: ``I² = 0``; `complement` needs no metric.
        """
        return self * self._whole(self._pseudoscalar_square())

    def undual(self) -> Self:
        """``x I``, the mirror of `dual`. Raises ValueError: ``I² = 0``."""
        self._pseudoscalar_square()
        return self * self._whole(1)

    def _whole(self, factor: int) -> Self:
        """The pseudoscalar times a whole number, as one: fractions stay fractions."""
        sign = self.algebra.pseudoscalar_sign
        return self._wrap(((1 << self.algebra.dimension) - 1,), (sign * factor,))

    def _pseudoscalar_square(self) -> int:
        square: int = self._whole(1).square().scalar_part()
        if square == 0:
            raise ValueError(
                f"{self.algebra}: expected an invertible pseudoscalar for a dual, got I² = 0; "
                "complement and uncomplement need no metric"
            )
        return square

    def complement(self) -> Self:
        """The right complement: basis blade ``b`` becomes ``c`` with ``b ∧ c = I``."""
        return self._complemented(left=False)

    def uncomplement(self) -> Self:
        """The mirror of `complement`: basis blade ``c`` becomes ``b`` with ``b ∧ c = I``."""
        return self._complemented(left=True)

    def _complemented(self, left: bool) -> Self:
        whole = (1 << self.algebra.dimension) - 1
        orientation = self.algebra.pseudoscalar_sign
        complement = {}
        for mask, value in zip(self.masks, self.values, strict=True):
            rest = whole ^ mask
            sign = reorder_sign(rest, mask) if left else reorder_sign(mask, rest)
            complement[rest] = value if sign * orientation > 0 else -value
        masks = tuple(sorted(complement, key=order_of))
        return self._wrap(masks, (complement[mask] for mask in masks))

    def as_orthogonal(self) -> Self:
        """The same multivector on the orthogonal basis, in `Algebra.orthogonal`."""
        return self._exchanged(self.algebra.orthogonal, self.algebra.basis.to_orthogonal)

    def from_orthogonal(self, algebra: Signature) -> Self:
        """The mirror of `as_orthogonal`: the same multivector on the basis of `algebra`.

        Raises ValueError: `algebra` is not on this basis when written orthogonally.
        """
        if algebra.orthogonal != self.algebra:
            raise ValueError(
                f"from_orthogonal: expected a multivector of {algebra.orthogonal}, "
                f"got one of {self.algebra}"
            )
        return self._exchanged(algebra, algebra.basis.from_orthogonal)

    def _exchanged(self, algebra: Signature, written: Callable[[int], Terms]) -> Self:
        total: dict[int, Any] = {}
        for mask, value in zip(self.masks, self.values, strict=True):
            for other, factor in written(mask):
                part = scaled(factor, value)
                total[other] = total[other] + part if other in total else part
        masks = tuple(sorted(total, key=order_of))
        return self._wrap(masks, (total[mask] for mask in masks), algebra)

    # Size --------------------------------------------------------------------------------------

    def norm_squared(self) -> Any:
        """``⟨x ~x⟩₀``; negative or zero for some x where the signature is mixed or degenerate."""
        return self.reverse_product().scalar_part()

    def norm(self) -> Any:
        """``√|⟨x ~x⟩₀|``."""
        return square_root(magnitude(self.norm_squared()))

    def isclose(self, other: Any, rtol: float = 1e-5, atol: float = 1e-8) -> Any:
        """Whether all coefficients are close, as ``np.isclose`` says; blades not there are zero.

        Returns:
            A bool, or an array of bools over the batch.

        Raises:
            ValueError: another algebra, or coefficients that are no numbers.
        """
        apart, right = self - other, self._lifted(other)
        if not (apart._is_numeric() and right._is_numeric()):
            raise ValueError("isclose: expected numbers as coefficients, got symbols")
        size = dict(zip(right.masks, right.values, strict=True))
        close: Any = True
        for mask, value in zip(apart.masks, apart.values, strict=True):
            close = close & (np.abs(value) <= atol + rtol * np.abs(size.get(mask, 0.0)))
        return close if isinstance(close, np.ndarray) else bool(close)

    def _is_numeric(self) -> bool:
        return all(is_numeric(value) or isinstance(value, Fraction) for value in self.values)


def _reverse_sign(grade: int) -> int:
    return -1 if grade % 4 in (2, 3) else 1
