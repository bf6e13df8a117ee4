"""Random scripts of the whole language, in every algebra, with what the second reading computes.

Brackets are left out as often as not, so that the order of operators counts; spaces, comments and
names that other languages keep for themselves come anywhere.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from motorcade.ga.algebra import Algebra
from motorcade.ga.script.meaning import algebra_named
from tests.ga.gaalop.scripts import Case
from tests.ga.programs.reference import Reader, Space, Values

# Algebras, the volume that duals divide by, and whether `*` does.
VOLUMES = {
    "2d": ("e1^e2", True),
    "3d": ("e1^e2^e3", True),
    "2dpga": ("e1^e2^e0", False),
    "3dpga": ("e1^e2^e3^e0", False),
    "cra": ("e1^e2^einf^e0", True),
    "cga": ("e1^e2^e3^einf^e0", True),
    "sta": ("e1^e2^e3^e4", True),
    "dcga": ("e1^e2^e3^ei1^eo1^e6^e7^e8^ei2^eo2", False),
    "gac": ("e1^e2^einfp^einfm^einfc^e0p^e0m^e0c", False),
    "qga": ("e1^e2^e3^einfx^einfy^einfz^e0x^e0y^e0z", True),
    "ccga": ("e1^e2^" + "^".join(f"ei{k}^eo{k}" for k in range(1, 8)), False),
}
_NAMES = ("x1", "def", "vec3", "double", "fn", "let", "out_a", "main", "lambda", "t0", "I", "Pi")
_MACROS = """
twice = { _P(1) + _P(1) }   // nested calls
Square = { k = _P(1); if (_P(2) > 1) { k = twice(k) - k; } else k = -k; k*_P(1) }
mixed = { grade(Square(_P(1), _P(2)) ^ _P(1), 2) + ::a*_P(1) }
"""


@cache
def space(name: str) -> Space:
    """The witness's own algebra."""
    algebra: Algebra = algebra_named(name)
    vectors: dict[str, Values] = {n: {1 << k: 1.0} for k, n in enumerate(algebra.names)}
    for o, i in algebra.basis.pairs:
        vectors[algebra.names[o]] = {1 << o: -0.5, 1 << i: 0.5}
        vectors[algebra.names[i]] = {1 << o: 1.0, 1 << i: 1.0}
    for named in algebra.named:
        total: Values = {}
        for mask, factor in algebra.masks_of(named):
            for part, value in vectors[algebra.names[mask.bit_length() - 1]].items():
                total[part] = total.get(part, 0.0) + factor * value
        vectors[named] = total
    return Space(algebra.basis.squares, vectors, algebra.names, VOLUMES[name][0])


class Grammar:
    """Writes one script."""

    def __init__(self, name: str, rng: np.random.Generator) -> None:
        self._rng = rng
        self._space = space(name)
        self._dual = VOLUMES[name][1]
        self._known = ["a", "b", "c", "d"]
        self._assigned: list[str] = []

    def script(self) -> str:
        """Statements and their outputs."""
        lines = [_MACROS] if self._rng.random() < 0.8 else []
        names = list(self._rng.permutation(_NAMES))[: int(self._rng.integers(2, 5))]
        for name in map(str, names):
            lines.append(self._statement(name))
            self._known.append(name)
            self._assigned.append(name)
        called = bool(lines) and lines[0] == _MACROS
        if called:
            lines.append(f"m_ = mixed({self._sum(1)}, {self._number()});")
            self._assigned.append("m_")
        return "\n".join([*lines, *(f"?{name};" for name in self._assigned[-3:])])

    def _pick(self, choices: Any) -> Any:
        return choices[int(self._rng.integers(len(choices)))]

    def _statement(self, name: str) -> str:
        kind = self._rng.random()
        if kind < 0.2:
            then, other = self._sum(2), self._sum(1)
            last = self._pick([f"{{ {name} = {other}; }}", f"{name} = {other};"])
            return f"if ({self._condition()}) {{ {name} = {then}; }} else {last}"
        if kind < 0.3:
            rounds = int(self._rng.integers(1, 4))
            return (
                f"{name} = {self._sum(1)}; n = 0;\nloop {{ if (n >= {rounds}) {{ break; }}\n"
                f"  {name} = {name}*{self._number()} + {self._vector()}; n = n + 1; }}"
            )
        mark = self._pick(["", "", "?", "!", ":"])
        return f"{mark}{name} = {self._sum(3)};{self._pick(['', ' // note', ' /* a; b */'])}"

    def _condition(self) -> str:
        signs = ["<", "<=", ">", ">=", "==", "!="]
        one = f"{self._number()} {self._pick(signs)} {self._number()}"
        two = f"!!({self._number()} < {self._number()})"
        return self._pick([one, two, f"{one} && {two}", f"{two} || {one}"])

    def _number(self) -> str:
        name = self._pick("abcd")
        return self._pick(
            [name, "2", "0.5", "1e-3", "1.5E0", ".25", f"sin({name})", f"COS({name})",
             f"SQRT({name})", f"exp(-{name})", f"atan({name})", f"max({name}, 1)", f"-{name}",
             f"sign({name} - 1)", "fact(3)", f"Floor(3*{name})", f"step({name}-1)",
             f"atan2({name}, {self._pick('abcd')})", f"abs({name}*{self._vector()})"]
        )  # fmt: skip

    def _vector(self) -> str:
        return str(self._pick(list(self._space.vectors)))

    def _sum(self, depth: int) -> str:
        """Operands between operators; what follows a division keeps to what has an inverse."""
        text = self._operand(depth)
        free = True
        for _ in range(int(self._rng.integers(0, 4))):
            if free and self._rng.random() < 0.15:
                name = self._pick("abcd")
                divisor = self._pick([f"(2 + {name}*{name})", "2", name, f"3/{name}"])
                text, free = f"{text} / {divisor}", False
                continue
            loose = ["+", "-", "*"]
            sign = self._pick([*loose, *loose, "^", ".", "<<", ">>", "&"] if free else loose)
            gap = self._pick(["", " "]) if sign not in ("*", ".", "&") else " "
            text, free = f"{text}{gap}{sign} {self._operand(depth)}", True
        return text

    def _operand(self, depth: int) -> str:
        kind = self._rng.random()
        if depth == 0 or kind < 0.35:
            return self._leaf()
        inside = self._sum(depth - 1)
        if kind < 0.55:
            return f"({inside})"
        if kind < 0.7:
            prefix = self._pick(["-", "~", "-~", *(["*"] if self._dual else [])])
            return f"{prefix}{self._pick([f'({inside})', self._leaf()])}"
        if kind < 0.75:
            blades = ", ".join({self._vector_of_basis(), "1"})
            return f"({inside})[{blades}]"
        if kind < 0.8:
            return f"grade({inside}, {int(self._rng.integers(0, 3))})"
        name = self._pick(
            ["reverse", "involute", "conjugate", "scalar", "abs", "complement", "uncomplement"]
        )
        return f"{name}({inside})"

    def _vector_of_basis(self) -> str:
        return str(self._pick(self._space.basis))

    def _leaf(self) -> str:
        kind = self._rng.random()
        if kind < 0.3:
            return self._number()
        if kind < 0.5 and self._assigned:
            return str(self._pick(self._assigned))
        if kind < 0.7:
            return self._vector()
        return f"{self._pick('abcd')}*{self._vector()}"


def grammar_cases(name: str, count: int, seed: int) -> list[Case]:
    """Scripts of an algebra, with what the second reading computes."""
    rng = np.random.default_rng([seed, list(VOLUMES).index(name)])
    made = []
    for k in range(count):
        text = Grammar(name, rng).script()
        inputs = {variable: float(rng.uniform(0.5, 1.5)) for variable in "abcd"}
        outputs = Reader(text, space(name), inputs).run()
        made.append(Case(f"{name}_g{k}", algebra_named(name), text, inputs, outputs, ""))
    return made
