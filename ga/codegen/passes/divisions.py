"""Divisions: all quotients by one number become products with its reciprocal.

Where that saves divisions, reciprocals of products become products of reciprocals: 1/s and
1/(s s) need one division together, 1/√n and 1/n too.
"""

from __future__ import annotations

from fractions import Fraction

from motorcade.ga.codegen.passes.forms import Coefficient, Form, Forms, Monomial
from motorcade.ga.codegen.passes.rebuild import copied
from motorcade.ga.codegen.tape import Tape, TapeBuilder


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
