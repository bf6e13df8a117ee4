"""What a kernel is to the generator: its name, what it takes and gives, and its definition.

Like terms of its sums are added up, and shared factors scaled once. Sums are regrouped here, in
exact arithmetic without effect; the emitters then keep the order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.recording import casadi_function, trace
from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder

_SUMS = frozenset({"add", "sub", "neg"})
# A factor used so often is worth multiplying by a constant once.
_OFTEN = 3
Terms = dict[int, float]
NOTE = "Written by `python -m motorcade.ga.codegen` from ga/kernels/definitions; edit those."


def collected(tape: Tape) -> Tape:
    """The tape with like terms added up: ``xy + wz + xy + wz`` becomes ``2 (xy + wz)``."""
    return _Collector(tape).run()


class _Collector:
    def __init__(self, tape: Tape) -> None:
        self._tape = tape
        self._uses = tape.uses()
        self._builder = TapeBuilder()
        self._place: dict[int, int] = {}

    def run(self) -> Tape:
        for index, node in enumerate(self._tape.nodes):
            self._place[index] = self._moved(index) if node.args else self._leaf(index)
        results = [[self._place[i] for i in row] for row in self._tape.results]
        return self._builder.finished(self._tape.inputs, self._tape.outputs, results)

    def _leaf(self, index: int) -> int:
        node = self._tape.nodes[index]
        if node.op == "const":
            return self._builder.constant(node.value)
        return self._builder.input(*node.source)

    def _moved(self, index: int) -> int:
        node = self._tape.nodes[index]
        if node.op in ("add", "sub"):
            terms: Terms = {}
            count = self._gather(index, 1.0, terms)
            if count > len(terms):
                return self._sum(terms)
        if node.op == "mul":
            for factor, other in (node.args, node.args[::-1]):
                scaled = self._scaled(factor, other)
                if scaled is not None:
                    return scaled
        return self._builder.operation(node.op, *(self._place[i] for i in node.args))

    def _gather(self, index: int, sign: float, terms: Terms) -> int:
        """Add the signed terms of a sum to `terms`; returns how many were met."""
        node = self._tape.nodes[index]
        signs = (
            (sign, -sign) if node.op == "sub" else (-sign,) if node.op == "neg" else (sign, sign)
        )
        count = 0
        for argument, signed in zip(node.args, signs, strict=True):
            if self._tape.nodes[argument].op in _SUMS and self._uses[argument] == 1:
                count += self._gather(argument, signed, terms)
            else:
                terms[argument] = terms.get(argument, 0.0) + signed
                count += 1
        return count

    def _sum(self, terms: Terms) -> int:
        kept = {index: factor for index, factor in terms.items() if factor != 0.0}
        if not kept:
            return self._builder.constant(0.0)
        # The factor that most terms share goes in front of all of them, once.
        sizes = [abs(factor) for factor in kept.values()]
        common = sizes[0] if sizes.count(sizes[0]) == len(sizes) else 1.0
        total: int | None = None
        for index, factor in kept.items():
            total = self._added(total, self._place[index], factor / common)
        assert total is not None
        if common == 1.0:
            return total
        return self._builder.operation("mul", self._builder.constant(common), total)

    def _added(self, total: int | None, term: int, factor: float) -> int:
        if abs(factor) != 1.0:
            term = self._builder.operation("mul", self._builder.constant(abs(factor)), term)
        if total is None:
            return term if factor > 0 else self._builder.operation("neg", term)
        return self._builder.operation("add" if factor > 0 else "sub", total, term)

    def _scaled(self, factor: int, other: int) -> int | None:
        """``x (c y)`` as ``(c x) y`` where x is a factor of many products."""
        if self._uses[factor] < _OFTEN or self._uses[other] != 1:
            return None
        if self._tape.nodes[factor].op in ("const", "input"):
            return None
        moved = self._builder.nodes[self._place[other]]
        if moved.op != "mul":
            return None
        for constant, rest in (moved.args, moved.args[::-1]):
            if self._builder.nodes[constant].op == "const":
                larger = self._builder.operation("mul", constant, self._place[factor])
                return self._builder.operation("mul", larger, rest)
        return None


@dataclass(frozen=True)
class Kernel:
    """A function of one row, applied to batches by the code that is written from it.

    `define` takes the precision and a list of scalars for each input, and returns a list of
    scalars for each output. `group` names the file that its code goes to. The first line of the
    docstring of `define` is the summary, unless another is given.

    >>> from motorcade.ga.codegen.library_kernels.kernel import Kernel
    >>> from motorcade.ga.codegen.precision import DOUBLE
    >>> from motorcade.ga.codegen.tape import Operand
    >>> def twice(precision, x):
    ...     'Twice the number.'
    ...     return [[2 * x[0]]]
    >>> kernel = Kernel("twice", "tests", (Operand("x", ("x",)),), (Operand("out", ("x",)),), twice)
    >>> kernel.summary, kernel.tape(DOUBLE).operations()
    ('Twice the number', {'mul': 1})
    """

    name: str
    group: str
    inputs: tuple[Operand, ...]
    outputs: tuple[Operand, ...]
    define: Callable[..., Sequence[Sequence[Any]]]
    summary: str = ""

    def __post_init__(self) -> None:
        if not self.summary:
            first = (self.define.__doc__ or "").partition("\n")[0]
            object.__setattr__(self, "summary", first.removesuffix("."))

    def tape(self, precision: Precision) -> Tape:
        """The operations of the kernel in a precision."""
        define = self._bound(precision)
        traced = trace(self.name, self.inputs, self.outputs, define, powers_of_two=True)
        return collected(traced)

    def casadi(self, precision: Precision) -> Any:
        """The kernel as a CasADi function, for derivatives and as a witness."""
        return casadi_function(self.name, self.inputs, self.outputs, self._bound(precision))

    def _bound(self, precision: Precision) -> Callable[..., Sequence[Sequence[Any]]]:
        return lambda *inputs: self.define(precision, *inputs)
