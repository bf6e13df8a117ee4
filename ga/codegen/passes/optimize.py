"""The optimiser: all passes in their order, each measured.

Sums are expanded: for every sum, the sums among its factors are multiplied out, those made last
first, a level at a time. The level at which it takes the fewest operations is kept; what nothing
uses any more is gone. Equal or worse levels are not taken, so that numbers which are factored well
stay so.

Where that saves divisions, reciprocals of products become products of reciprocals: 1/s and
1/(s s) need one division together, 1/√n and 1/n too.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from fractions import Fraction

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
from motorcade.ga.codegen.passes.merge import merged
from motorcade.ga.codegen.passes.rebuild import copied, folded_tape, with_single_differences
from motorcade.ga.codegen.passes.stats import PassStats, cost_of, count_operations
from motorcade.ga.codegen.tape import Operand, Tape, TapeBuilder


def as_reciprocals(tape: Tape) -> Tape:
    """The tape with ``x / d`` written ``x (1/d)``, every reciprocal once."""
    if not any(node.op == "div" for node in tape.nodes):
        return tape
    forms = Forms(tape)
    roots = {node.args[0]: k for k, node in enumerate(tape.nodes) if node.op == "sqrt"}
    divisors = {
        node.args[1]: _monomial(forms, node.args[1], roots)
        for node in tape.nodes
        if node.op == "div"
    }
    split = _worth_splitting([found[0] for found in divisors.values() if found])
    builder = TapeBuilder()
    place: list[int] = []
    for index, node in enumerate(tape.nodes):
        args = tuple(place[k] for k in node.args)
        divisor = divisors.get(node.args[1]) if node.op == "div" else None
        if node.op != "div":
            copy = copied(tape, index, args, builder)
        elif tape.nodes[node.args[1]].op == "const" or not (divisor and divisor[0] in split):
            copy = _over(builder, args[0], args[1])
        else:
            monomial, coefficient = divisor
            copy = args[0]
            for factor in monomial:
                # A root may come later on the tape: it is computed here then.
                below = (
                    place[factor]
                    if factor < index
                    else builder.operation("sqrt", place[tape.nodes[factor].args[0]])
                )
                copy = _over(builder, copy, below)
            scale = builder.constant(float(1 / Fraction(coefficient)))
            copy = builder.operation("mul", scale, copy)
        place.append(copy)
    results = [[place[k] for k in row] for row in tape.results]
    return builder.finished(tape.inputs, tape.outputs, results)


def with_quotients(tape: Tape) -> Tape:
    """The tape with ``x (1/d)`` written ``x / d`` where the reciprocal serves only once."""
    if not any(node.op == "div" for node in tape.nodes):
        return tape
    uses = tape.uses()
    builder = TapeBuilder()
    place: list[int] = []
    for index, node in enumerate(tape.nodes):
        quotient = None
        for factor, rest in (node.args, node.args[::-1]) if node.op == "mul" else ():
            inner = tape.nodes[factor]
            if uses[factor] == 1 and inner.op == "div" and _is_one(tape, inner.args[0]):
                quotient = builder.operation("div", place[rest], place[inner.args[1]])
                break
        if quotient is None:
            quotient = copied(tape, index, tuple(place[k] for k in node.args), builder)
        place.append(quotient)
    results = [[place[k] for k in row] for row in tape.results]
    return builder.finished(tape.inputs, tape.outputs, results)


def _is_one(tape: Tape, index: int) -> bool:
    node = tape.nodes[index]
    return node.op == "const" and node.value == 1.0


def _over(builder: TapeBuilder, above: int, below: int) -> int:
    if builder.nodes[below].op == "const":
        return builder.operation("div", above, below)
    reciprocal = builder.operation("div", builder.constant(1.0), below)
    return builder.operation("mul", above, reciprocal)


def _monomial(
    forms: Forms, index: int, roots: dict[int, int]
) -> tuple[Monomial, Coefficient] | None:
    """A divisor as a product of nodes and a power of two, None where it is none.

    A number of `roots`, whose square root is on the tape, counts as the square of that.
    """
    form: Form = forms.factor(index)
    if len(form) != 1:
        return None
    ((monomial, coefficient),) = form.items()
    scale = abs(Fraction(coefficient))
    if scale.numerator & (scale.numerator - 1) or scale.denominator & (scale.denominator - 1):
        return None
    parts = [(roots[k], roots[k]) if k in roots else (k,) for k in monomial]
    return tuple(sorted(k for part in parts for k in part)), coefficient


def _worth_splitting(monomials: list[Monomial]) -> set[Monomial]:
    """The products that share factors so that fewer reciprocals serve all of them."""
    split: set[Monomial] = set()
    for group in _connected(sorted(set(monomials))):
        factors = {factor for monomial in group for factor in monomial}
        if len(factors) < len(group) or all(len(set(monomial)) == 1 for monomial in group):
            split.update(group)
    return split


def _connected(monomials: list[Monomial]) -> list[list[Monomial]]:
    """The products in groups that share no factor with one another."""
    groups: list[tuple[set[int], list[Monomial]]] = []
    for monomial in monomials:
        touched = [group for group in groups if group[0] & set(monomial)]
        groups = [group for group in groups if group not in touched]
        factors = set(monomial).union(*(group[0] for group in touched))
        groups.append((factors, [m for group in touched for m in group[1]] + [monomial]))
    return [group for _, group in groups]


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


# Passes that search, and in more than linear time: tapes of more nodes go past them.
_SEARCHES = frozenset({expanded, factored})
LONGEST_SEARCHED = 20_000


def without_zeros(tape: Tape) -> Tape:
    """The tape without the components of outputs that are the number zero.

    An output of which nothing is left keeps its name.
    """
    kept = [[i for i, k in enumerate(row) if not _is_zero(tape, k)] for row in tape.results]
    if [len(places) for places in kept] == [len(row) for row in tape.results]:
        return tape
    outputs = tuple(
        Operand(operand.name, tuple(operand.components[i] for i in places))
        for operand, places in zip(tape.outputs, kept, strict=True)
    )
    results = [[row[i] for i in places] for row, places in zip(tape.results, kept, strict=True)]
    builder = TapeBuilder()
    builder.nodes.extend(tape.nodes)
    return builder.finished(tape.inputs, outputs, results)


def _is_zero(tape: Tape, index: int) -> bool:
    node = tape.nodes[index]
    return node.op == "const" and node.value == 0.0


PASSES: tuple[tuple[str, Callable[[Tape], Tape]], ...] = (
    ("fold constants", folded_tape),
    ("share reciprocals", as_reciprocals),
    ("merge equal nodes", merged),
    ("drop zeros", without_zeros),
    ("collect like terms", expanded),
    ("merge equal nodes", merged),
    ("drop zeros", without_zeros),
    ("factor", factored),
    ("single quotients", with_quotients),
    ("single differences", with_single_differences),
)


def optimized(tape: Tape) -> tuple[Tape, tuple[PassStats, ...]]:
    """A tape of the same values with fewer operations, and what each pass did.

    Values agree to rounding wherever those of the given tape are real numbers. Components that are
    zero are left out of the outputs. Tapes of more than `LONGEST_SEARCHED` nodes are not searched
    for like terms and common factors.

    Raises ValueError: a divisor is zero whatever the inputs are.
    """
    done = []
    settled: dict[Callable[[Tape], Tape], Tape] = {}
    for name, apply in PASSES:
        start = time.perf_counter()
        skipped = apply in _SEARCHES and len(tape.nodes) > LONGEST_SEARCHED
        # A pass leaves nothing to do for itself where no other one changed the tape.
        improved = tape if skipped or settled.get(apply) is tape else apply(tape)
        settled[apply] = improved
        spent = 1e3 * (time.perf_counter() - start)
        counts = count_operations(tape), count_operations(improved)
        done.append(PassStats(name, *counts, spent, skipped))
        tape = improved
    return tape, tuple(done)
