"""Random scripts, each computed beside its text by the library clifford.

A script has four free variables and a few statements, of all products, sums, reverses, grades,
duals, divisions, functions of scalars, branches and macros. Its meaning is computed while its text
is written, on clifford's own multivectors.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import clifford
import numpy as np

from motorcade.ga.algebra import Algebra
from motorcade.ga.script.meaning import algebra_named
from tests.ga.gaalop.scripts import Case

ALGEBRAS = ("3d", "3dpga", "cra", "cga", "sta", "gac")
# A text and what clifford computes for it.
Term = tuple[str, Any]
_MACRO = "m = { k = _P(1) - _P(2); k*_P(1) + 2 }"


class Witness:
    """An algebra and clifford's of the same signature."""

    def __init__(self, name: str) -> None:
        self.algebra: Algebra = algebra_named(name)
        self.layout = clifford.Cl(*self.algebra.signature)[0]
        self.scalar = self.layout.scalar
        self.vectors = self._vectors()
        self._columns: Any = None

    def _vectors(self) -> dict[str, Any]:
        """Clifford's vectors by our names; those of square 0 come first there."""
        p, _, r = self.algebra.signature
        theirs = list(self.layout.blades_of_grade(1))
        pools = {0: theirs[:r], 1: theirs[r : r + p], -1: theirs[r + p :]}
        basis, names = self.algebra.basis, self.algebra.names
        made = {
            name: pools[square].pop(0) for name, square in zip(names, basis.squares, strict=True)
        }
        for o, i in basis.pairs:
            ep, em = made[names[o]], made[names[i]]
            made[names[o]], made[names[i]] = 0.5 * (em - ep), ep + em
        return made

    @property
    def pseudoscalar(self) -> Any:
        """The unit pseudoscalar, whose inverse makes the dual; that of gac is its paper's."""
        if "einfm" in self.vectors:
            return self._blade("e0p^e0m^e0c^e1^e2^einfp^einfm^einfc")
        return self.algebra.pseudoscalar_sign * self._blade("^".join(self.algebra.names))

    def coefficients(self, x: Any) -> dict[str, float]:
        """What clifford has for our blades."""
        names = self.algebra.blades
        if self._columns is None:
            self._columns = np.stack([self._blade(name).value for name in names], axis=1)
        found = np.linalg.solve(self._columns.astype(float), x.value.astype(float))
        return {name: float(v) for name, v in zip(names, found, strict=True) if v != 0.0}

    def _blade(self, name: str) -> Any:
        made = self.scalar
        for factor in [] if name == "1" else name.split("^"):
            made = made ^ self.vectors[factor]
        return made


@cache
def witness(name: str) -> Witness:
    """Made once, as tables of products take a while."""
    return Witness(name)


class Writer:
    """Writes one script and computes it."""

    def __init__(self, witness: Witness, rng: np.random.Generator) -> None:
        self._witness = witness
        self._rng = rng
        self.inputs = {name: float(rng.uniform(0.5, 1.5)) for name in "abcd"}
        self._names: dict[str, Any] = {}

    def script(self) -> tuple[str, dict[str, Any]]:
        """The text and the values of its outputs."""
        lines, count = [_MACRO], int(self._rng.integers(2, 5))
        for k in range(count):
            lines.append(self._statement(f"v{k}"))
        outputs = {name: self._names[name] for name in list(self._names)[-2:]}
        return "\n".join([*lines, *(f"?{name};" for name in outputs)]), outputs

    def _statement(self, name: str) -> str:
        text, value = self._term(3)
        if self._rng.random() < 0.3:
            (one, a), (two, b) = self._number(), self._number()
            other, instead = self._term(2)
            self._names[name] = value if a < b else instead
            return f"if ({one} < {two}) {{ {name} = {text}; }} else {name} = {other};"
        self._names[name] = value
        return f"{name} = {text};"

    def _pick(self, choices: Any) -> Any:
        return choices[int(self._rng.integers(len(choices)))]

    def _number(self) -> tuple[str, float]:
        """A scalar by a variable, a number or a function."""
        name = self._pick("abcd")
        value = self.inputs[name]
        function = self._pick(["{x}", "sin({x})", "COS({x})", "exp(-{x})", "sqrt({x})", "1/({x})"])
        computed = {
            "{x}": value,
            "sin({x})": math.sin(value),
            "COS({x})": math.cos(value),
            "exp(-{x})": math.exp(-value),
            "sqrt({x})": math.sqrt(value),
            "1/({x})": 1 / value,
        }[function]
        return function.format(x=name), computed

    def _term(self, depth: int) -> Term:
        if depth == 0:
            return self._leaf()
        if self._rng.random() < 0.35:
            return self._changed(self._term(depth - 1))
        left, right = self._term(depth - 1), self._term(depth - 1)
        operator = self._pick(["+", "-", "*", "*", "^", ".", "<<", ">>"])
        return f"({left[0]} {operator} {right[0]})", _OPERATIONS[operator](left[1], right[1])

    def _leaf(self) -> Term:
        kind = self._rng.random()
        if kind < 0.3 and self._names:
            name = self._pick(list(self._names))
            return name, self._names[name]
        text, value = self._number()
        if kind < 0.45:
            return f"({text})", value * self._witness.scalar
        name = self._pick(self._witness.algebra.names)
        return f"({text}*{name})", value * self._witness.vectors[name]

    def _changed(self, term: Term) -> Term:
        """A term after an operation on one multivector."""
        text, x = term
        one = self._witness.scalar
        kind = int(self._rng.integers(8))
        if kind == 0:
            return f"(~{text})", ~x
        if kind == 1:
            grade = int(self._rng.integers(0, 4))
            return f"grade({text}, {grade})", x(grade)
        if kind == 2:
            return f"involute({text})", x.gradeInvol()
        if kind == 3:
            number, value = self._number()
            return f"({text} / (2 + {number}*{number}))", x / (2 + value * value)
        if kind == 4:
            number, value = self._number()
            return f"m({text}, {number})", (x - value) * x + 2 * one
        if kind == 5 and 0 not in self._witness.algebra.basis.squares:
            return f"(*{text})", x * self._witness.pseudoscalar.inv()
        if kind == 6:
            e1, name = self._witness.vectors["e1"], "e1"
            return f"({text} / (3*{name}))", x * e1 / (3 * float((e1 * e1)[0]))
        return f"(-{text})", -x


def _left(a: Any, b: Any) -> Any:
    """Left contraction by the grades of clifford's products."""
    made = 0.0 * a
    for r in a.grades():
        for s in b.grades():
            if s >= r:
                made = made + (a(int(r)) * b(int(s)))(int(s - r))
    return made


_OPERATIONS: dict[str, Any] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "^": lambda a, b: a ^ b,
    ".": lambda a, b: a | b,
    "<<": _left,
    ">>": lambda a, b: ~_left(~b, ~a),
}


def random_cases(name: str, count: int, seed: int) -> list[Case]:
    """Scripts of an algebra, with what clifford computes."""
    there = witness(name)
    rng = np.random.default_rng([seed, ALGEBRAS.index(name)])
    made = []
    for k in range(count):
        writer = Writer(there, rng)
        text, outputs = writer.script()
        expected = {output: there.coefficients(x) for output, x in outputs.items()}
        made.append(Case(f"{name}_{k}", there.algebra, text, writer.inputs, expected, ""))
    return made
