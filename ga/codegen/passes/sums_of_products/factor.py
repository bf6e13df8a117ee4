"""Factoring and common subexpressions of sums of products, greedily.

In this order: what all terms of a sum share goes in front of it; factors that several terms share
go in front of these, ``ab + ac = a (b + c)``; pairs of terms that stand in several sums become a
sum of their own, and pairs of factors that stand in several products a product of their own. It
is done with and without the first step, and with products that are shared already left as they
are. The cheapest tape stays, be it the one given.
"""

from __future__ import annotations

from collections import Counter
from itertools import combinations

from motorcade.ga.codegen.passes.stats import cost_of
from motorcade.ga.codegen.passes.sums_of_products.forms import Monomial
from motorcade.ga.codegen.passes.sums_of_products.network import Network, Term, without
from motorcade.ga.codegen.tape import Tape

__all__ = ["factored"]

# Sums and products that are longer than this are searched for common pairs no further.
_LONGEST = 48


def factored(tape: Tape) -> Tape:
    """The tape with common factors and common parts of sums and products taken out."""
    candidates = [tape]
    for contents_first, shared_products in ((True, False), (False, False), (False, True)):
        network = Network(tape, shared_products=shared_products)
        _factor(network, contents_first)
        candidates.append(network.tape())
    return min(candidates, key=cost_of)


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
    network.sums[index] = [*rest, (sign, tuple(sorted(content + factor)))]


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
            made = next(reversed(network.sums))
            used.update(factors for _, factors in network.sums[made] if len(factors) > 1)
            waiting.append(made)
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
        found: dict[tuple[Monomial, Monomial, int], list[int]] = {}
        for index, terms in network.sums.items():
            ordered = sorted(terms[:_LONGEST], key=lambda term: term[1])
            for (s, first), (t, second) in combinations(ordered, 2):
                found.setdefault((first, second, s * t), []).append(index)
        shared = [(key, places) for key, places in found.items() if len(places) > 1]
        shared.sort(key=lambda item: -len(item[1]))
        done = [_share_pair(network, *key, places) for key, places in shared]
        if not any(done):
            return


def _share_pair(
    network: Network, one: Monomial, other: Monomial, sign: int, places: list[int]
) -> bool:
    """Do it for one pair, in those sums that still have it, if these are several."""
    left = []
    for index in places:
        signs = {factors: s for s, factors in network.sums[index]}
        once = len(signs) == len(network.sums[index])
        if once and one in signs and signs.get(other) == sign * signs[one]:
            left.append((index, signs[one]))
    if len(left) < 2:
        return False
    made = network.new_number()
    for index, first in left:
        rest = [term for term in network.sums[index] if term[1] not in (one, other)]
        network.sums[index] = [*rest, (first, (made,))]
    network.sums[made] = [(1, one), (sign, other)]
    return True


def _share_factors(network: Network, *, least: int, numbers_only: bool) -> None:
    """Two factors that stand in several products become a product of their own."""
    while True:
        products = [factors for factors in network.monomials() if len(factors) <= _LONGEST]
        found: dict[tuple[int, int], list[Monomial]] = {}
        for factors in products:
            for pair in dict.fromkeys(combinations(factors, 2)):
                if pair[0] < 0 or not numbers_only:
                    found.setdefault(pair, []).append(factors)
        shared = [(pair, places) for pair, places in found.items() if len(places) >= least]
        if not shared:
            return
        renamed: dict[Monomial, Monomial] = {}
        for pair, places in sorted(shared, key=lambda item: -len(item[1])):
            left = [factors for factors in places if factors not in renamed]
            if len(left) < least:
                continue
            made = network.new_number()
            network.products[made] = pair
            for factors in left:
                renamed[factors] = tuple(sorted((*without(factors, pair), made)))
        for index, terms in network.sums.items():
            network.sums[index] = [(sign, renamed.get(f, f)) for sign, f in terms]
