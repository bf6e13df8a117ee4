"""Factoring and common subexpressions of sums of products, greedily.

In this order: what all terms of a sum share goes in front of it; factors that several terms share
go in front of these, ``ab + ac = a (b + c)``; pairs of terms that stand in several sums become a
sum of their own, and pairs of factors that stand in several products a product of their own. It
is done with and without the first step, and with products that are shared already left as they
are. The cheapest tape stays, be it the one given.

What it works on are sums of products that name one another. Everything has a number: nodes of the
tape keep theirs, new sums and products get higher ones, constants negative ones, so that they come
first in sorted products. A term is a sign and the numbers of its factors.

Numbers: what all terms of a sum are multiplied by goes to where the sum is used.

There it may meet its reciprocal: six halves in front of the terms of three sums and six doubles in
front of their products cancel. A number moves where the operations that it costs are no more than
those that it saves, the sum and its users looked at alone.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import lru_cache
from itertools import combinations

from motorcade.ga.codegen.passes.forms import (
    HIGHEST_DEGREE,
    Coefficient,
    Form,
    Forms,
    Monomial,
    moderate,
    write_form,
)
from motorcade.ga.codegen.passes.rebuild import copied, product_of
from motorcade.ga.codegen.passes.stats import cost_of
from motorcade.ga.codegen.tape import Tape, TapeBuilder

Term = tuple[int, Monomial]
# Sums and products that are longer than this are searched for common pairs no further.
_LONGEST = 48
# What moving numbers may cost before factors are taken out and still save operations after that.
_MUCH_COSTLIER = 1.1


def without(factors: Monomial, gone: Iterable[int]) -> Monomial:
    """Factors but for some, each as often as it is named."""
    rest = list(factors)
    for factor in gone:
        rest.remove(factor)
    return tuple(rest)


class Network:
    """The sums and products that the results of a tape need."""

    def __init__(self, forms: Forms) -> None:
        self.sums: dict[int, list[Term]] = {}
        self.products: dict[int, tuple[int, int]] = {}
        self._tape = forms.tape
        self._forms = forms
        self._next = len(forms.tape.nodes)
        self._constants: dict[Coefficient, int] = {}
        self._fill(forms)
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
                size = max(coefficient, -coefficient)
                factors = monomial if size == 1 else (self._constant(size), *monomial)
                terms.append((1 if coefficient > 0 else -1, factors))
            self.sums[index] = terms
        self.sums = {index: self.sums[index] for index in sorted(self.sums)}

    def _constant(self, size: Coefficient) -> int:
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

    def product(self, factors: Monomial) -> Monomial:
        """A product in its order, without a number beside its reciprocal."""
        return self._forms.shortened(tuple(sorted(factors)))

    def inline_products(self) -> None:
        """Write sums of one term out where they are factors, unless products are to stay."""
        if self._forms.shared_products:
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
        return sign, self.product(tuple(done))

    def monomials(self) -> Counter[Monomial]:
        """How many terms each product of two factors or more stands in."""
        counter: Counter[Monomial] = Counter()
        for terms in self.sums.values():
            counter.update(factors for _, factors in terms if len(factors) > 1)
        return counter

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


@lru_cache(maxsize=2)
def factored(tape: Tape) -> Tape:
    """The tape with common factors and common parts of sums and products taken out."""
    candidates = [tape]
    for variant in _with_numbers_placed(tape):
        plain, shared = Forms(variant), Forms(variant, shared_products=True)
        for forms, contents_first in ((plain, True), (plain, False), (shared, False)):
            network = Network(forms)
            _factor(network, contents_first)
            candidates.append(network.tape())
    return min(candidates, key=cost_of)


def _with_numbers_placed(tape: Tape) -> tuple[Tape, ...]:
    """The tape, with its numbers outside of sums instead where that is better, both in doubt."""
    outside = with_numbers_outside(tape)
    if outside is tape or cost_of(outside) > _MUCH_COSTLIER * cost_of(tape):
        return (tape,)
    return (outside,) if cost_of(outside) < cost_of(tape) else (tape, outside)


def _factor(network: Network, contents_first: bool) -> None:
    if contents_first:
        _take_contents(network)
    network.inline_products()
    _take_factors(network, constants=False)
    network.inline_products()
    _share_terms(network)
    network.inline_products()
    # A number may be worth more in a product that is shared than in front of one sum.
    _share_factors(network, least=3, numbers_only=True)
    _take_factors(network, constants=True)
    _share_factors(network, least=2, numbers_only=False)


def _take_contents(network: Network) -> None:
    """Factors of all terms go in front; numbers only together with others."""
    for index, terms in list(network.sums.items()):
        if len(terms) < 2:
            continue
        common = Counter(terms[0][1])
        for _, factors in terms[1:]:
            common &= Counter(factors)
        content = sorted(common.elements())
        if content and content[-1] >= 0:
            _take_out(network, index, tuple(content), range(len(terms)))


def _take_out(network: Network, index: int, content: Monomial, chosen: range | list[int]) -> None:
    """Put a product in front of some terms of a sum."""
    terms = network.sums[index]
    inner: list[Term] = [(terms[k][0], without(terms[k][1], content)) for k in chosen]
    rest = [term for k, term in enumerate(terms) if k not in chosen]
    sign, factor = network.new_sum(inner)
    network.sums[index] = [*rest, (sign, network.product(content + factor))]


def _take_factors(network: Network, *, constants: bool) -> None:
    """Take the factor that saves most out of each sum, as long as one saves anything."""
    used = network.monomials()
    waiting = list(network.sums)
    while waiting:
        index = waiting.pop()
        terms = network.sums[index]
        factor, chosen = _best_factor(terms, used, constants=constants)
        if not chosen:
            continue
        before = len(network.sums)
        used.subtract(factors for _, factors in terms)
        _take_out(network, index, (factor,), chosen)
        used.update(factors for _, factors in network.sums[index] if len(factors) > 1)
        if len(network.sums) > before:
            newest = next(reversed(network.sums))
            used.update(factors for _, factors in network.sums[newest] if len(factors) > 1)
            waiting.append(newest)
        waiting.append(index)


def _best_factor(
    terms: list[Term], used: Counter[Monomial], *, constants: bool
) -> tuple[int, list[int]]:
    """The factor to take out and the terms that have it; none where nothing is saved."""
    places: dict[int, list[int]] = {}
    for k, (_, factors) in enumerate(terms):
        for factor in dict.fromkeys(factors):
            if constants or factor >= 0:
                places.setdefault(factor, []).append(k)
    best: tuple[int, int, list[int]] = (0, 0, [])
    for factor, chosen in places.items():
        if len(chosen) < 2:
            continue
        saved = -1
        for k in chosen:
            factors = terms[k][1]
            rest = without(factors, (factor,))
            if used[factors] == 1:
                saved += len(factors) - 1
            if len(rest) > 1 and used[rest] == 0:
                saved -= len(rest) - 1
        if saved > best[0]:
            best = (saved, factor, chosen)
    return best[1], best[2]


def _share_terms(network: Network) -> None:
    """Two terms that stand in several sums, up to a sign, become a sum of their own."""
    while True:
        sums_of: dict[tuple[Monomial, Monomial, int], list[int]] = {}
        for index, terms in network.sums.items():
            ordered = sorted(terms[:_LONGEST], key=lambda term: term[1])
            for (s, first), (t, second) in combinations(ordered, 2):
                sums_of.setdefault((first, second, s * t), []).append(index)
        shared = [(key, places) for key, places in sums_of.items() if len(places) > 1]
        shared.sort(key=lambda item: -len(item[1]))
        done = [_share_pair(network, *key, places) for key, places in shared]
        if not any(done):
            return


def _share_pair(
    network: Network, monomial: Monomial, other: Monomial, sign: int, places: list[int]
) -> bool:
    """Do it for one pair, in those sums that still have it, if these are several."""
    left = []
    for index in places:
        signs = {factors: s for s, factors in network.sums[index]}
        once = len(signs) == len(network.sums[index])
        if once and monomial in signs and signs.get(other) == sign * signs[monomial]:
            left.append((index, signs[monomial]))
    if len(left) < 2:
        return False
    number = network.new_number()
    for index, first in left:
        rest = [term for term in network.sums[index] if term[1] not in (monomial, other)]
        network.sums[index] = [*rest, (first, (number,))]
    network.sums[number] = [(1, monomial), (sign, other)]
    return True


def _share_factors(network: Network, *, least: int, numbers_only: bool) -> None:
    """Two factors that stand in several products become a product of their own."""
    while True:
        products = [factors for factors in network.monomials() if len(factors) <= _LONGEST]
        products_of: dict[tuple[int, int], list[Monomial]] = {}
        for factors in products:
            for pair in dict.fromkeys(combinations(factors, 2)):
                if pair[0] < 0 or not numbers_only:
                    products_of.setdefault(pair, []).append(factors)
        shared = [(pair, places) for pair, places in products_of.items() if len(places) >= least]
        if not shared:
            return
        renamed: dict[Monomial, Monomial] = {}
        for pair, places in sorted(shared, key=lambda item: -len(item[1])):
            left = [factors for factors in places if factors not in renamed]
            if len(left) < least:
                continue
            number = network.new_number()
            network.products[number] = pair
            for factors in left:
                renamed[factors] = tuple(sorted((*without(factors, pair), number)))
        for index, terms in network.sums.items():
            network.sums[index] = [(sign, renamed.get(f, f)) for sign, f in terms]


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
