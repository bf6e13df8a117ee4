"""Runs a script on multivectors that write down each operation done to them.

The record keeps products, sums, reverses and parts of multivectors whole, as the generators that
write one call an operation see them, while `program` flattens them to scalars. What is computed
between scalars (functions, choices, closed forms) is kept as expressions of coefficients.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from motorcade.ga.algebra import Algebra, Multivector
from motorcade.ga.algebra.products import Masks
from motorcade.ga.algebra.scalars import is_numeric
from motorcade.ga.codegen.recording import Scalars
from motorcade.ga.script import Script, evaluate


@dataclass(frozen=True)
class Step:
    """One operation on whole multivectors; its `args` are the numbers of earlier steps.

    `op` is a product of `algebra.products`, ``add``, ``sub``, ``negate``, ``reverse``,
    ``involute``, ``conjugate``, ``part`` (the blades `masks` of its argument), or ``given``, which
    has one of `scalars` for each blade. `masks` are the blades of the result; those that cancel as
    they stand are left out.
    """

    op: str
    args: tuple[int, ...]
    masks: Masks
    scalars: tuple[Any, ...] = ()

    @property
    def is_scalar(self) -> bool:
        """Whether the result is a number."""
        return self.masks == (0,)


@dataclass(frozen=True)
class Record:
    """The steps that a script needs, by number in their order; `outputs` name those they are.

    An output that vanishes has no step. `inputs` are the free variables.
    """

    algebra: Algebra
    inputs: tuple[str, ...]
    steps: dict[int, Step]
    outputs: dict[str, int | None]
    scalars: Scalars

    def reads(self, step: Step) -> dict[str, tuple[int, int] | None]:
        """The symbols in a step's scalars: step and blade of a coefficient, None of a variable."""
        return {name: _coefficient(name) for name in self.scalars.names_in(step.scalars)}


def record(script: Script, algebra: Algebra, variables: Iterable[str]) -> Record:
    """Run a script once over multivectors of `algebra` that record what is done to them.

    Raises ScriptError: whatever `evaluate` refuses.
    """
    recording = _Recording(algebra)
    inputs = {name: recording.scalars.symbol(name) for name in variables}
    outcome = evaluate(script, recording, **inputs)
    outcome = {name: recording.trimmed(x) for name, x in outcome.items()}
    outputs = {name: recording.lifted(x).step if x.masks else None for name, x in outcome.items()}
    everything = dict(enumerate(recording.steps))
    whole = Record(algebra, tuple(inputs), everything, outputs, recording.scalars)
    return replace(whole, steps=_needed(whole))


def _coefficient(name: str) -> tuple[int, int] | None:
    """Step and blade by the name of a symbol; those of variables hold no space."""
    step, _, mask = name.partition(" ")
    return (int(step), int(mask)) if mask else None


def _needed(record: Record) -> dict[int, Step]:
    """The steps that the outputs come from, in their order."""
    wanted = {number for number in record.outputs.values() if number is not None}
    for number in reversed(record.steps):
        if number in wanted:
            step = record.steps[number]
            wanted.update(step.args)
            wanted.update(read[0] for read in record.reads(step).values() if read is not None)
    return {number: record.steps[number] for number in sorted(wanted)}


class _Recording(Algebra):
    """An algebra whose multivectors of symbols are `_Recorded`; those of numbers stay plain.

    The symbol of each coefficient of each step stands for what it comes to in terms of the inputs.
    """

    __slots__ = ("scalars", "steps")

    def __init__(self, plain: Algebra) -> None:
        self._set_like(plain)
        self.steps: list[Step] = []
        self.scalars = Scalars()

    def multivector(self, coefficients: Mapping[str, Any]) -> Multivector:
        """The multivector with these coefficients, written down where it holds symbols."""
        multivector = self.trimmed(super().multivector(coefficients))
        return multivector if all(map(is_numeric, multivector.values)) else self.lifted(multivector)

    def lifted(self, x: Multivector) -> _Recorded:
        """The multivector itself, or one that is made of scalars in a step of its own."""
        if isinstance(x, _Recorded):
            return x
        flat = Multivector._trusted(self, x.masks, map(self.scalars.resolved, x.values))
        return self.written("given", (), flat, x.values)

    def trimmed(self, x: Multivector) -> Multivector:
        """The multivector without coefficients that are zero as they stand."""
        pairs = [(m, v) for m, v in zip(x.masks, x.values, strict=True) if not _zero(v)]
        if len(pairs) == len(x.masks):
            return x
        return Multivector._trusted(self, tuple(m for m, _ in pairs), (v for _, v in pairs))

    def written(
        self, op: str, args: tuple[int, ...], flat: Multivector, scalars: tuple[Any, ...] = ()
    ) -> _Recorded:
        """Write a step down; its result."""
        names = [f"{len(self.steps)} {mask}" for mask in flat.masks]
        for name, value in zip(names, flat.values, strict=True):
            self.scalars.replace(name, value)
        recorded = _Recorded(self, tuple(map(self.scalars.symbol, names)), flat, len(self.steps))
        self.steps.append(Step(op, args, flat.masks, scalars))
        return recorded


class _Recorded(Multivector):
    """The result of a recorded step: a symbol a blade.

    `flat` is the same in terms of the inputs, which tells what is zero. Operations that are not
    overridden here work on the coefficients, and become a step ``given`` where they are used.
    """

    __slots__ = ("flat", "step")

    algebra: _Recording
    flat: Multivector
    step: int

    def __init__(
        self, algebra: _Recording, symbols: tuple[Any, ...], flat: Multivector, step: int
    ) -> None:
        self._set(algebra, flat.masks, symbols)
        object.__setattr__(self, "flat", flat)
        object.__setattr__(self, "step", step)

    def _wrap(self, masks: Any, values: Any, algebra: Any = None) -> Any:
        return Multivector._trusted(algebra or self.algebra, masks, values)

    def _written(self, op: str, flat: Multivector, *operands: Multivector) -> Multivector:
        kept = tuple(
            mask for mask, value in zip(flat.masks, flat.values, strict=True) if not _zero(value)
        )
        if not kept:
            return Multivector._trusted(self.algebra, (), ())
        steps = tuple(self.algebra.lifted(operand).step for operand in operands)
        return self.algebra.written(op, steps, flat._selected(kept.__contains__))

    def _joined(self, op: str, left: Multivector, right: Multivector, flat: Multivector) -> Any:
        """A sum, of which an empty side leaves the other."""
        if not right.masks:
            return left
        if not left.masks:
            return right if op == "add" else -right
        return self._written(op, flat, left, right)

    def _lifted(self, other: Any) -> Any:
        operand = self.algebra.trimmed(super()._lifted(other))
        return self.algebra.lifted(operand) if operand.masks else operand

    def __add__(self, other: Any) -> Any:
        right = self._lifted(other)
        return self._joined("add", self, right, self.flat + _flat(right))

    def __radd__(self, other: Any) -> Any:
        left = self._lifted(other)
        return self._joined("add", left, self, _flat(left) + self.flat)

    def __sub__(self, other: Any) -> Any:
        right = self._lifted(other)
        return self._joined("sub", self, right, self.flat - _flat(right))

    def __rsub__(self, other: Any) -> Any:
        left = self._lifted(other)
        return self._joined("sub", left, self, _flat(left) - self.flat)

    # Products ------------------------------------------------------------------------------------

    def _product(self, kind: str, other: Any, grades: frozenset[int] | None = None) -> Any:
        right = self._lifted(other)
        return self._written(kind, self.flat._product(kind, _flat(right), grades), self, right)

    def _multiplied(self, kind: str, other: Any) -> Any:
        """A product from the right."""
        left = self._lifted(other)
        return self._written(kind, _flat(left)._product(kind, self.flat), left, self)

    def __rmul__(self, other: Any) -> Any:
        return self._multiplied("geometric", other)

    def __rxor__(self, other: Any) -> Any:
        return self._multiplied("outer", other)

    def __ror__(self, other: Any) -> Any:
        return self._multiplied("inner", other)

    def _scaled(self, scalar: Any) -> Any:
        return self._product("geometric", self._lifted(scalar))

    def _divided(self, divisor: Any) -> Any:
        return self._scaled(1.0 / divisor)

    def __rtruediv__(self, other: Any) -> Any:
        return self._lifted(other) * self.inverse()

    def reverse_product(self) -> Any:
        """``x ~x``: a reverse, and a product without the blades that cancel by symmetry."""
        return self._written("geometric", self.flat.reverse_product(), self, ~self)

    def norm_squared(self) -> Any:
        """``⟨x ~x⟩₀``: a reverse and the scalar part of a product."""
        return self._product("geometric", ~self, frozenset({0})).scalar_part()

    def square(self) -> Any:
        """``x x``: a product without the blades that cancel by symmetry."""
        return self._written("geometric", self.flat.square(), self, self)

    def inverse(self) -> Any:
        """The inverse in the steps of `algebra.inverse`; the script answers for the divisor."""
        if self.masks == (0,):
            return self.algebra.scalar(1.0 / self.values[0])
        size = self.reverse_product()
        if not any(size.masks):
            return (~self)._divided(size.scalar_part())
        rest = tuple(mask for mask in size.masks if mask)
        if not any(self.algebra.symmetric_plan(rest, (1,) * len(rest)).masks):
            mirrored: Multivector = 2.0 * size.scalar_part() - size
            divisor = size._product("geometric", mirrored, frozenset({0}))
            return (~self * mirrored)._divided(divisor.scalar_part())
        degree = 2 ** ((self.algebra.dimension + 1) // 2)
        power: Multivector = self
        before: Multivector = self
        for k in range(1, degree):
            before = power - degree / k * power.scalar_part()
            power = self * before
        return before._divided(power.scalar_part())

    # Signs and parts -----------------------------------------------------------------------------

    def __neg__(self) -> Any:
        return self._written("negate", -self.flat, self)

    def __invert__(self) -> Any:
        return self._written("reverse", ~self.flat, self)

    def involute(self) -> Any:
        """Grade involution."""
        return self._written("involute", self.flat.involute(), self)

    def conjugate(self) -> Any:
        """Clifford conjugate."""
        return self._written("conjugate", self.flat.conjugate(), self)

    def _selected(self, wanted: Callable[[int], bool]) -> Any:
        return self._written("part", self.flat._selected(wanted), self)


def _flat(x: Multivector) -> Multivector:
    return x.flat if isinstance(x, _Recorded) else x


def _zero(value: Any) -> bool:
    return bool(value.is_zero()) if hasattr(value, "is_zero") else bool(value == 0.0)
