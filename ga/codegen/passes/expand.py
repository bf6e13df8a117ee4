"""Like terms: sums are multiplied out where terms cancel or join, and only there.

For every sum, the sums among its factors are multiplied out, those made last first, a level at a
time. The level at which it takes the fewest operations is kept; what nothing uses any more is
gone. Equal or worse levels are not taken, so that numbers which are factored well stay so.
"""

from __future__ import annotations

from motorcade.ga.codegen.passes.factor import factored
from motorcade.ga.codegen.passes.forms import (
    Coefficient,
    Form,
    Forms,
    Monomial,
    add_term,
    form_cost,
    write_form,
)
from motorcade.ga.codegen.passes.rebuild import copied
from motorcade.ga.codegen.passes.stats import cost_of
from motorcade.ga.codegen.tape import Tape, TapeBuilder

# A level is given up where it has more terms than this, or than four times those of the sum.
_MOST_TERMS = 96
_FEW_TERMS = 16
_MOST_LEVELS = 5
_SUMS = frozenset({"add", "sub", "neg", "mul"})


def expanded(tape: Tape) -> Tape:
    """The tape with sums multiplied out where that leaves fewer operations.

    Products are written out on the way, so that it may look costlier until they are shared again:
    then what is left after factoring decides.
    """
    expansion = _written(tape, _Expander(tape).forms)
    if cost_of(expansion) <= cost_of(tape):
        return expansion
    return min(tape, expansion, key=lambda candidate: cost_of(factored(candidate)))


class _Expander(Forms):
    """Forms, each at its cheapest level."""

    def __init__(self, tape: Tape) -> None:
        self._heights: list[int] = []
        super().__init__(tape)

    def form(self, index: int) -> Form:
        cheapest = super().form(index)
        node = self.tape.nodes[index]
        if node.op in _SUMS and not self.inside[index]:
            cheapest = self._cheapest(cheapest)
        below = max((self._heights[k] for k in node.args), default=0)
        if node.op in _SUMS:
            below = max((self._heights[k] for m in cheapest for k in m if k < index), default=0)
        self._heights.append(below + (len(cheapest) > 1))
        return cheapest

    def _cheapest(self, form: Form) -> Form:
        best, least = form, self._cost(form)
        most = min(_FEW_TERMS + 4 * len(form), max(_MOST_TERMS, len(form)))
        for _ in range(_MOST_LEVELS):
            wider = self._one_level(form, most)
            if wider is None:
                break
            form = wider
            cost = self._cost(form)
            if cost < least:
                best, least = form, cost
        return best

    def _cost(self, form: Form) -> int:
        """The operations of a form and of the sums that only it needs."""
        cost = form_cost(form)
        for k in set().union(*form):
            if self.uses[k] == 1 and self.is_expandable(k):
                cost += self._cost(self.forms[k])
        return cost

    def is_expandable(self, index: int) -> bool:
        """Whether a factor is a sum that can be multiplied out."""
        return len(self.forms[index]) > 1

    def _one_level(self, form: Form, most: int) -> Form | None:
        """The form with its highest sums multiplied out; None where none are or it grows long."""
        sums = [k for k in set().union(*form) if self.is_expandable(k)]
        if not sums:
            return None
        highest = max([self._heights[k] for k in sums])
        chosen = frozenset([k for k in sums if self._heights[k] == highest])
        total: Form = {}
        for monomial, coefficient in form.items():
            if chosen.isdisjoint(monomial):
                add_term(total, monomial, coefficient)
                continue
            terms = self._multiplied_out(monomial, coefficient, chosen, most)
            if terms is None:
                return None
            for other, value in terms.items():
                add_term(total, other, value)
            if len(total) > most:
                return None
        return total

    def _multiplied_out(
        self, monomial: Monomial, coefficient: Coefficient, chosen: frozenset[int], most: int
    ) -> Form | None:
        form: Form = {tuple([k for k in monomial if k not in chosen]): coefficient}
        for factor in monomial:
            if factor in chosen:
                if len(form) * len(self.forms[factor]) > most:
                    return None
                form = self.product(form, self.forms[factor])
        return form


def _written(tape: Tape, forms: list[Form]) -> Tape:
    """The forms as operations, terms and factors in their order."""
    builder = TapeBuilder()
    place: dict[int, int] = {}
    waiting = [k for row in reversed(tape.results) for k in reversed(row)]
    while waiting:
        index = waiting[-1]
        form = forms[index]
        atom = (index,) in form and len(form) == 1
        needed = tape.nodes[index].args if atom else [k for m in form for k in m]
        missing = [k for k in needed if k not in place]
        if missing:
            waiting.extend(reversed(missing))
            continue
        waiting.pop()
        if index not in place:
            place[index] = (
                copied(tape, index, tuple(place[k] for k in needed), builder)
                if atom
                else write_form(form, place, builder)
            )
    results = [[place[k] for k in row] for row in tape.results]
    return builder.finished(tape.inputs, tape.outputs, results)
