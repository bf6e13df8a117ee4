"""Nodes as sums of products: polynomials over the nodes that are no sums or products themselves.

Coefficients are exact. Products of a number and its reciprocal, or of two equal square roots, are
written shorter as soon as they are made.
"""

from __future__ import annotations

from fractions import Fraction

from motorcade.ga.codegen.passes.rebuild import product_of
from motorcade.ga.codegen.tape import Node, Tape, TapeBuilder

Coefficient = int | Fraction
# Positions of the factors, ascending.
Monomial = tuple[int, ...]
Form = dict[Monomial, Coefficient]

HIGHEST_DEGREE = 12
_SUMS = frozenset({"add", "sub", "neg"})
_LARGEST_EXPONENT = 900
_SMALL = 1 << 60
_ONE = Node("const", value=1.0)


class Forms:
    """The form of each node of a tape.

    A single product is written out where it is used, and so is a sum that only one other sum uses:
    it has no form of its own then, but itself. Any other sum stands where it is used as one factor,
    and with `shared_products` so do products that are used more than once.
    """

    def __init__(self, tape: Tape, *, shared_products: bool = False) -> None:
        self.tape = tape
        self.shared_products = shared_products
        self.uses = tape.uses()
        self.forms: list[Form] = []
        self.inside = _inside(tape, self.uses)
        self._rules = _rules(tape)
        self._ruled = frozenset(self._rules)
        for index in range(len(tape.nodes)):
            self.forms.append(self.form(index))

    def form(self, index: int) -> Form:
        """The form of a node, of those of its arguments."""
        node = self.tape.nodes[index]
        if node.op == "const":
            return {(): _exact(node.value)} if node.value else {}
        terms: Form | None = None
        if node.op == "mul":
            terms = self.product(self.factor(node.args[0]), self.factor(node.args[1]))
        elif node.op in _SUMS and not self.inside[index]:
            terms = self._summed(index)
        return {(index,): 1} if terms is None or not _bounded(terms) else terms

    def _summed(self, index: int) -> Form:
        """The terms of a sum and of those inside it, from left to right."""
        summed: Form = {}
        waiting: list[tuple[int, int]] = [(index, 1)]
        while waiting:
            last, sign = waiting.pop()
            node = self.tape.nodes[last]
            if last != index and not self.inside[last]:
                add_to(summed, self.factor(last), sign)
                continue
            second = -sign if node.op == "sub" else sign
            waiting.extend((k, second) for k in node.args[1:])
            waiting.append((node.args[0], -sign if node.op == "neg" else sign))
        return summed

    def factor(self, index: int) -> Form:
        """A node as a factor: its form if that is one product of few factors, else itself."""
        form = self.forms[index]
        if self.shared_products and self.uses[index] > 1 and self.tape.nodes[index].op == "mul":
            return {(index,): 1}
        if len(form) <= 1 and all(len(monomial) <= HIGHEST_DEGREE for monomial in form):
            return form
        return {(index,): 1}

    def product(self, left: Form, right: Form) -> Form:
        """The product of two forms, multiplied out."""
        form: Form = {}
        ruled = self._ruled
        for factors, a in left.items():
            for other, b in right.items():
                monomial = tuple(sorted(factors + other)) if factors and other else factors + other
                if not ruled.isdisjoint(monomial):
                    monomial = self.shortened(monomial)
                add_term(form, monomial, times(a, b))
        return form

    def shortened(self, monomial: Monomial) -> Monomial:
        """A product without pairs of factors that are known to be one factor or 1."""
        while not self._ruled.isdisjoint(monomial):
            replacement = self._pair(monomial)
            if replacement is None:
                break
            first, second, factors = replacement
            rest = list(monomial)
            rest.remove(first)
            rest.remove(second)
            monomial = tuple(sorted((*rest, *factors)))
        return monomial

    def _pair(self, monomial: Monomial) -> tuple[int, int, Monomial] | None:
        """Two factors of a product that a rule is for, and what it makes of them."""
        for first in monomial:
            for second, factors in self._rules.get(first, ()):
                if second in monomial and (first != second or monomial.count(first) > 1):
                    return first, second, factors
        return None


def add_to(total: Form, form: Form, factor: Coefficient) -> None:
    """Add a multiple of a form to another one."""
    for monomial, coefficient in form.items():
        add_term(total, monomial, times(factor, coefficient))


def add_term(total: Form, monomial: Monomial, coefficient: Coefficient) -> None:
    """Add one term, whose coefficient is not zero, to a form."""
    known = total.get(monomial)
    if known is None:
        total[monomial] = coefficient
        return
    value = known + coefficient
    if value:
        total[monomial] = value
    else:
        del total[monomial]


def times(a: Coefficient, b: Coefficient) -> Coefficient:
    """The product of two coefficients, an int where it is whole."""
    if a == 1 or b == 1:
        return b if a == 1 else a
    product = a * b
    return product.numerator if product.denominator == 1 else product


def form_cost(form: Form) -> int:
    """Additions and multiplications that a form takes as it stands."""
    products = 0
    for monomial, coefficient in form.items():
        if monomial:
            products += len(monomial) - (coefficient in (1, -1))
    return products + max(len(form) - 1, 0)


def write_form(form: Form, place: dict[int, int], builder: TapeBuilder) -> int:
    """A form as operations: positive terms first, so that sums need no sign in front."""
    total: int | None = None
    for monomial, coefficient in sorted(form.items(), key=lambda term: term[1] < 0):
        number = builder.constant(abs(float(coefficient)))
        term = product_of([number, *(place[factor] for factor in monomial)], builder)
        if total is None:
            total = builder.operation("neg", term) if coefficient < 0 else term
        else:
            total = builder.operation("sub" if coefficient < 0 else "add", total, term)
    return builder.constant(0.0) if total is None else total


def _inside(tape: Tape, uses: list[int]) -> list[bool]:
    """Which sums are only a term of one other sum."""
    inside = [False] * len(tape.nodes)
    for node in tape.nodes:
        if node.op in _SUMS:
            for k in node.args:
                inside[k] = uses[k] == 1 and tape.nodes[k].op in _SUMS
    return inside


def _rules(tape: Tape) -> dict[int, list[tuple[int, Monomial]]]:
    """Pairs of factors with a shorter product: ``x · 1/x``, ``√x · √x`` and ``x · 1/√x``.

    For the first of a pair the second, and the factors that stand for both.
    """
    rules: dict[int, list[tuple[int, Monomial]]] = {}
    for index, node in enumerate(tape.nodes):
        if node.op == "sqrt":
            rules.setdefault(index, []).append((index, node.args))
        if node.op == "div" and tape.nodes[node.args[0]] == _ONE:
            below = node.args[1]
            rules.setdefault(below, []).append((index, ()))
            if tape.nodes[below].op == "sqrt":
                rules.setdefault(tape.nodes[below].args[0], []).append((index, (below,)))
    return rules


def _exact(value: float) -> Coefficient:
    return int(value) if value.is_integer() else Fraction(value)


def _bounded(form: Form) -> bool:
    """Whether all coefficients are far from what a float overflows or underflows at."""
    return all((type(c) is int and -_SMALL < c < _SMALL) or moderate(c) for c in form.values())


def moderate(coefficient: Coefficient) -> bool:
    """Whether a coefficient is far from what a float overflows or underflows at."""
    above, below = coefficient.numerator, coefficient.denominator
    return abs(above.bit_length() - below.bit_length()) < _LARGEST_EXPONENT
