"""Numbers: what all terms of a sum are multiplied by goes to where the sum is used.

There it may meet its reciprocal: six halves in front of the terms of three sums and six doubles in
front of their products cancel. A number moves where the operations that it costs are no more than
those that it saves, the sum and its users looked at alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from motorcade.ga.codegen.passes.rebuild import copied
from motorcade.ga.codegen.passes.sums_of_products.forms import (
    Coefficient,
    Form,
    Forms,
    moderate,
    write_form,
)
from motorcade.ga.codegen.tape import Tape, TapeBuilder


def with_numbers_outside(tape: Tape) -> Tape:
    """The tape with numbers moved out of sums and products as long as that costs nothing."""
    if not any(node.op == "const" and abs(node.value) != 1.0 for node in tape.nodes):
        return tape
    return _Mover(tape).written()


class _Mover:
    def __init__(self, tape: Tape) -> None:
        self._tape = tape
        self._forms = Forms(tape).forms
        self._order = self._needed()
        # How often a result or a function, in which a number stays, has the node as it is.
        self._fixed: dict[int, int] = {}
        # For each node the products that it is a factor of, of which form, and how often.
        self._products: dict[int, list[tuple[int, tuple[int, ...], int]]] = {}
        self._scale: dict[int, Coefficient] = {}
        self._find_uses()
        for index in self._order:
            self._move(index)

    def _is_atom(self, index: int) -> bool:
        return (index,) in self._forms[index]

    def _parts(self, index: int) -> list[int]:
        if self._is_atom(index):
            return list(self._tape.nodes[index].args)
        return [k for monomial in self._forms[index] for k in monomial]

    def _needed(self) -> list[int]:
        needed: set[int] = set()
        waiting = [k for row in self._tape.results for k in row]
        while waiting:
            index = waiting.pop()
            if index not in needed:
                needed.add(index)
                waiting.extend(self._parts(index))
        return sorted(needed)

    def _find_uses(self) -> None:
        for row in self._tape.results:
            for k in row:
                self._fixed[k] = self._fixed.get(k, 0) + 1
        for index in self._order:
            if self._is_atom(index):
                for k in self._tape.nodes[index].args:
                    self._fixed[k] = self._fixed.get(k, 0) + 1
                continue
            for monomial in self._forms[index]:
                for k in dict.fromkeys(monomial):
                    self._products.setdefault(k, []).append((index, monomial, monomial.count(k)))

    def _move(self, index: int) -> None:
        """Divide a form by the number that all its terms have, and multiply its users by that."""
        form = self._forms[index]
        if self._is_atom(index) or not form or () in form:
            return
        number = content(form)
        uses = self._products.get(index, [])
        old = [self._forms[user][monomial] for user, monomial, _ in uses]
        new = [c * number**times for c, (_, _, times) in zip(old, uses, strict=True)]
        cost = self._fixed.get(index, 0) + _multiplications(new) - _multiplications(old)
        inner = {monomial: exact(Fraction(c) / number) for monomial, c in form.items()}
        saved = _multiplications(form.values()) - _multiplications(inner.values())
        if number == 1 or cost > saved or not all(map(moderate, new)):
            return
        self._scale[index] = number
        self._forms[index] = inner
        for coefficient, (user, monomial, _) in zip(new, uses, strict=True):
            self._forms[user][monomial] = exact(coefficient)

    def written(self) -> Tape:
        """The forms as a tape; a number that was moved stands in front of what stays as it is."""
        builder = TapeBuilder()
        place: dict[int, int] = {}
        for index in self._order:
            if self._is_atom(index):
                args = tuple(self._whole(k, place, builder) for k in self._tape.nodes[index].args)
                place[index] = copied(self._tape, index, args, builder)
            else:
                place[index] = write_form(self._forms[index], place, builder)
        results = [[self._whole(k, place, builder) for k in row] for row in self._tape.results]
        return builder.finished(self._tape.inputs, self._tape.outputs, results)

    def _whole(self, index: int, place: dict[int, int], builder: TapeBuilder) -> int:
        number = builder.constant(float(self._scale.get(index, 1)))
        return builder.operation("mul", number, place[index])


def _multiplications(coefficients: Iterable[Coefficient]) -> int:
    return sum(c not in (1, -1) for c in coefficients)


def content(form: Form) -> Coefficient:
    """The smallest coefficient if all are whole multiples of it, else 1; negative if all are."""
    least: Coefficient = min(max(c, -c) for c in form.values())
    if any(c % least for c in form.values()):
        return 1
    return -least if all(c < 0 for c in form.values()) else least


def exact(value: Coefficient) -> Coefficient:
    """A coefficient as an int where it is whole."""
    return value.numerator if value.denominator == 1 else value
