"""Sums of products that name one another: what factoring works on, and its way back to a tape.

Everything has a number: nodes of the tape keep theirs, new sums and products get higher ones,
constants negative ones, so that they come first in sorted products. A term is a sign and the
numbers of its factors.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from fractions import Fraction

from motorcade.ga.codegen.passes.rebuild import copied, product_of
from motorcade.ga.codegen.passes.sums_of_products.forms import HIGHEST_DEGREE, Forms, Monomial
from motorcade.ga.codegen.tape import Tape, TapeBuilder

__all__ = ["Network", "Term", "without"]

Term = tuple[int, Monomial]


def without(factors: Monomial, gone: Iterable[int]) -> Monomial:
    """Factors but for some, each as often as it is named."""
    rest = list(factors)
    for factor in gone:
        rest.remove(factor)
    return tuple(rest)


class Network:
    """The sums and products that the results of a tape need; see `Forms` for the argument."""

    def __init__(self, tape: Tape, *, shared_products: bool = False) -> None:
        self.sums: dict[int, list[Term]] = {}
        self.products: dict[int, tuple[int, int]] = {}
        self._tape = tape
        self._shared_products = shared_products
        self._next = len(tape.nodes)
        self._constants: dict[Fraction, int] = {}
        self._fill(Forms(tape, shared_products=shared_products))
        self._known = {_signed(terms)[1]: index for index, terms in self.sums.items() if terms}

    def _fill(self, forms: Forms) -> None:
        waiting = [k for row in self._tape.results for k in row]
        seen: set[int] = set()
        while waiting:
            index = waiting.pop()
            if index in seen:
                continue
            seen.add(index)
            form = forms.forms[index]
            if (index,) in form:
                waiting.extend(self._tape.nodes[index].args)
                continue
            terms = []
            for monomial, coefficient in form.items():
                waiting.extend(monomial)
                size = abs(Fraction(coefficient))
                factors = monomial if size == 1 else (self._constant(size), *monomial)
                terms.append((1 if coefficient > 0 else -1, factors))
            self.sums[index] = terms
        self.sums = {index: self.sums[index] for index in sorted(self.sums)}

    def _constant(self, size: Fraction) -> int:
        return self._constants.setdefault(size, -1 - len(self._constants))

    def new_number(self) -> int:
        """A number that nothing has yet."""
        self._next += 1
        return self._next - 1

    def new_sum(self, terms: list[Term]) -> Term:
        """A sum as a factor, and its sign: an equal or opposite one that is there, or a new one."""
        sign, key = _signed(terms)
        known = self._known.get(key)
        if known is None or known not in self.sums or _signed(self.sums[known])[1] != key:
            known = self.new_number()
            self.sums[known] = terms
            self._known[key] = known
        return sign * _signed(self.sums[known])[0], (known,)

    def inline_products(self) -> None:
        """Write sums of one term out where they are factors, unless products are to stay."""
        if self._shared_products:
            return
        single = {index: terms[0] for index, terms in self.sums.items() if len(terms) == 1}
        for index, terms in self.sums.items():
            self.sums[index] = [self._inlined(term, single) for term in terms]

    def _inlined(self, term: Term, single: dict[int, Term]) -> Term:
        sign, factors = term
        done: list[int] = []
        waiting = list(factors)
        while waiting:
            factor = waiting.pop()
            inner = single.get(factor)
            if inner is None or len(done) + len(waiting) + len(inner[1]) > HIGHEST_DEGREE:
                done.append(factor)
            else:
                sign *= inner[0]
                waiting.extend(inner[1])
        return sign, tuple(sorted(done))

    def monomials(self) -> Counter[Monomial]:
        """How many terms each product of two factors or more stands in."""
        found: Counter[Monomial] = Counter()
        for terms in self.sums.values():
            found.update(factors for _, factors in terms if len(factors) > 1)
        return found

    def tape(self) -> Tape:
        """The network as a tape."""
        builder = TapeBuilder()
        place = {index: builder.constant(float(size)) for size, index in self._constants.items()}
        waiting = [k for row in reversed(self._tape.results) for k in reversed(row)]
        while waiting:
            index = waiting[-1]
            missing = [k for k in self._needed(index) if k not in place]
            if missing:
                waiting.extend(reversed(missing))
                continue
            waiting.pop()
            if index not in place:
                place[index] = self._written(index, place, builder)
        results = [[place[k] for k in row] for row in self._tape.results]
        return builder.finished(self._tape.inputs, self._tape.outputs, results)

    def _needed(self, index: int) -> Iterator[int]:
        if index in self.sums:
            return (k for _, factors in self.sums[index] for k in factors)
        if index in self.products:
            return iter(self.products[index])
        return iter(self._tape.nodes[index].args)

    def _written(self, index: int, place: dict[int, int], builder: TapeBuilder) -> int:
        if index in self.products:
            left, right = self.products[index]
            return builder.operation("mul", place[left], place[right])
        if index not in self.sums:
            args = tuple(place[k] for k in self._tape.nodes[index].args)
            return copied(self._tape, index, args, builder)
        total: int | None = None
        # Positive terms come first, so that sums need no sign in front.
        for sign, factors in sorted(self.sums[index], key=lambda term: -term[0]):
            term = product_of([place[factor] for factor in factors], builder)
            if total is None:
                total = term if sign > 0 else builder.operation("neg", term)
            else:
                total = builder.operation("add" if sign > 0 else "sub", total, term)
        return builder.constant(0.0) if total is None else total


def _signed(terms: list[Term]) -> tuple[int, tuple[Term, ...]]:
    """A sum in a form that equal and opposite ones share, and the sign of it in that."""
    ordered = sorted(terms, key=lambda term: term[1])
    sign = ordered[0][0]
    return sign, tuple((sign * s, factors) for s, factors in ordered)
