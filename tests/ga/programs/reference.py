"""A second reading of CLUScript, from its page alone: the witness of random scripts.

It shares nothing with the package: multivectors are dicts over an orthogonal basis, and an
expression is computed while it is read, by the table of operators. It reads what is right and does
not say what is wrong.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import combinations
from typing import Any

Values = dict[int, float]
_TOKEN = re.compile(
    r"\s*(?://[^\n]*|/\*.*?\*/)|\s*(?P<token>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
    r"|(?:::)?[A-Za-z_]\w*|[=!<>]=|&&|\|\||!!|<<|>>|\S)",
    re.S,
)
_LEVELS = ("||", "&&", "== !=", "< <= > >=", "- +", "*", "/", ". << >>", "^ &")
_LEVEL = {sign: level for level, signs in enumerate(_LEVELS) for sign in signs.split()}


class Space:
    """An algebra by its named vectors, each a sum of orthogonal ones."""

    def __init__(
        self, squares: Sequence[int], vectors: dict[str, Values], basis: Sequence[str], volume: str
    ) -> None:
        self.squares = squares
        self.vectors = vectors
        self.basis = list(basis)
        self.volume = self.blade(volume)
        self._orientation = self.named(self.volume)["^".join(basis)]

    def product(self, a: Values, b: Values, wanted: Callable[[int, int, int], bool]) -> Values:
        """The parts of the geometric product whose grades are wanted."""
        made: Values = {}
        for one, x in a.items():
            for two, y in b.items():
                if wanted(one.bit_count(), two.bit_count(), (one ^ two).bit_count()):
                    both = one & two
                    sign = x * y
                    for k, square in enumerate(self.squares):
                        if both >> k & 1:
                            sign *= square
                        if two >> k & 1 and (one >> k + 1).bit_count() & 1:
                            sign = -sign
                    made[one ^ two] = made.get(one ^ two, 0.0) + sign
        return {mask: value for mask, value in made.items() if value != 0.0}

    def times(self, a: Values, b: Values) -> Values:
        return self.product(a, b, lambda r, s, t: True)

    def size(self, a: Values) -> float:
        """The root of the size of ``⟨a ~a⟩₀``, which is 0 where only rounding is left of it."""
        square = self.times(a, reverse(a)).get(0, 0.0)
        largest = sum(value * value for value in a.values())
        return math.sqrt(abs(square)) if abs(square) > 1e-13 * largest else 0.0

    def wedge(self, a: Values, b: Values) -> Values:
        return self.product(a, b, lambda r, s, t: t == r + s)

    def blade(self, name: str) -> Values:
        made: Values = {0: 1.0}
        for vector in [] if name == "1" else name.split("^"):
            made = self.wedge(made, self.vectors[vector])
        return made

    @cached_property
    def _orthogonal(self) -> dict[int, dict[tuple[str, ...], float]]:
        """Each orthogonal vector by the named ones of the basis."""
        made: dict[int, dict[tuple[str, ...], float]] = {}
        for k in range(len(self.squares)):
            holders = [name for name in self.basis if self.vectors[name].get(1 << k)]
            if len(holders) == 1:
                made[k] = {(holders[0],): 1.0}
                continue
            # A null pair o = ½ (em - ep), i = ep + em.
            first, second = holders
            o, i = (first, second) if self._halved(first) else (second, first)
            sign = 1.0 if self.vectors[o][1 << k] > 0 else -1.0
            made[k] = {(o,): sign, (i,): 0.5}
        return made

    def _halved(self, name: str) -> bool:
        return all(abs(value) == 0.5 for value in self.vectors[name].values())

    def named(self, x: Values) -> dict[str, float]:
        """The coefficients by blade, the vectors of each in the order of the basis."""
        made: dict[str, float] = {}
        for mask, value in x.items():
            total: dict[tuple[str, ...], float] = {(): value}
            for k in range(len(self.squares)):
                if mask >> k & 1:
                    total = self._outer(total, self._orthogonal[k])
            for blade, part in total.items():
                name = "^".join(blade) or "1"
                made[name] = made.get(name, 0.0) + part
        return made

    def _outer(
        self, a: dict[tuple[str, ...], float], b: dict[tuple[str, ...], float]
    ) -> dict[tuple[str, ...], float]:
        made: dict[tuple[str, ...], float] = {}
        for one, x in a.items():
            for (vector,), y in b.items():
                if vector not in one:
                    place = self.basis.index(vector)
                    after = sum(self.basis.index(name) > place for name in one)
                    blade = tuple(sorted((*one, vector), key=self.basis.index))
                    made[blade] = made.get(blade, 0.0) + (-x * y if after & 1 else x * y)
        return made

    def complement(self, x: Values, *, back: bool = False) -> Values:
        """On basis blades, what makes ``x ^ y`` the unit volume; `back`: ``y ^ x``."""
        made: Values = {}
        for name, value in self.named(x).items():
            inside = [] if name == "1" else name.split("^")
            rest = [vector for vector in self.basis if vector not in inside]
            order = [*rest, *inside] if back else [*inside, *rest]
            places = [self.basis.index(vector) for vector in order]
            swaps = sum(u > v for u, v in combinations(places, 2))
            sign = self._orientation * (-1 if swaps & 1 else 1)
            made = added(made, self.blade("^".join(rest) or "1"), sign * value)
        return made


def added(a: Values, b: Values, factor: float = 1.0) -> Values:
    made = dict(a)
    for mask, value in b.items():
        made[mask] = made.get(mask, 0.0) + factor * value
    return made


def signed(x: Values, sign: Callable[[int], int]) -> Values:
    return {mask: sign(mask.bit_count()) * value for mask, value in x.items()}


def reverse(x: Values) -> Values:
    return signed(x, lambda r: -1 if r % 4 in (2, 3) else 1)


class Reader:
    """Reads and computes a script in one go."""

    def __init__(self, text: str, space: Space, inputs: dict[str, float]) -> None:
        self._tokens = [t for t in (m["token"] for m in _TOKEN.finditer(text)) if t]
        self._space = space
        self._at = 0
        self._names: dict[str, Values] = {name: {0: value} for name, value in inputs.items()}
        self._script = self._names
        self._arguments: list[Values] = []
        self._macros: dict[str, int] = {}
        self.outputs: dict[str, Values] = {}

    def run(self) -> dict[str, dict[str, float]]:
        while self._at < len(self._tokens):
            self._statement()
        return {name: self._space.named(x) for name, x in self.outputs.items()}

    def _next(self, ahead: int = 0) -> str:
        place = self._at + ahead
        return self._tokens[place] if place < len(self._tokens) else ""

    def _take(self) -> str:
        self._at += 1
        return self._tokens[self._at - 1]

    # Statements ----------------------------------------------------------------------------------

    def _statement(self) -> bool:
        """Run one; whether it was a break."""
        if self._next() in (";",):
            self._take()
            return False
        if self._next() == "if":
            return self._if()
        if self._next() == "loop":
            self._take()
            start = self._at
            while not self._block():
                self._at = start
            self._at = start
            self._skip()
            return False
        if self._next() == "break":
            self._take()
            return True
        if self._next(1) == "=" and self._next(2) == "{":
            self._macros[self._take()] = self._at + 3
            self._take()
            self._skip()
            return False
        mark = self._take() if self._next() in "?!:" else ""
        name = self._take()
        if self._next() == "=":
            self._take()
            self._names[name] = self._expression()
        if mark == "?":
            self.outputs[name] = self._names[name]
        return False

    def _block(self) -> bool:
        if self._next() != "{":
            return self._statement()
        self._take()
        while self._next() != "}":
            if self._statement():
                return True
        self._take()
        return False

    def _skip(self) -> None:
        """Past a block, or past one statement."""
        depth = 0
        while True:
            token = self._take()
            depth += (token == "{") - (token == "}")
            if depth == 0 and token in "};":
                return

    def _if(self) -> bool:
        self._take()
        self._take()
        holds = self._expression().get(0, 0.0) != 0.0
        self._take()
        over = False
        if holds:
            over = self._block()
            if over:
                return True
        else:
            self._skip()
        while self._next() == ";":
            self._take()
        if self._next() == "else":
            self._take()
            if holds:
                self._skip()
            else:
                over = self._block()
        return over

    # Expressions ---------------------------------------------------------------------------------

    def _expression(self, level: int = 0) -> Values:
        if level == len(_LEVELS):
            return self._prefixed()
        made = self._expression(level + 1)
        while _LEVEL.get(self._next()) == level:
            sign = self._take()
            made = self._joined(sign, made, self._expression(level + 1))
        return made

    def _joined(self, sign: str, a: Values, b: Values) -> Values:
        space = self._space
        if sign in "+-":
            return added(a, b, 1.0 if sign == "+" else -1.0)
        if sign == "&":
            both = space.wedge(space.complement(a), space.complement(b))
            return space.complement(both, back=True)
        if sign == "/":
            size = space.times(b, reverse(b))[0]
            return space.times(a, {m: v / size for m, v in reverse(b).items()})
        grades: dict[str, Callable[[int, int, int], bool]] = {
            "*": lambda r, s, t: True,
            "^": lambda r, s, t: t == r + s,
            ".": lambda r, s, t: r > 0 and s > 0 and t == abs(r - s),
            "<<": lambda r, s, t: t == s - r,
            ">>": lambda r, s, t: t == r - s,
        }
        if sign in grades:
            return space.product(a, b, grades[sign])
        x, y = a.get(0, 0.0), b.get(0, 0.0)
        compared = {
            "<": x < y, "<=": x <= y, ">": x > y, ">=": x >= y, "==": x == y, "!=": x != y,
            "&&": x != 0 and y != 0, "||": x != 0 or y != 0,
        }  # fmt: skip
        return {0: float(compared[sign])}

    def _prefixed(self) -> Values:
        if self._next() == "-":
            self._take()
            return {mask: -value for mask, value in self._prefixed().items()}
        if self._next() == "~":
            self._take()
            return reverse(self._prefixed())
        if self._next() == "*":
            self._take()
            return self._joined("/", self._prefixed(), self._space.volume)
        if self._next() == "!!":
            self._take()
            return {0: float(self._prefixed().get(0, 0.0) == 0.0)}
        made = self._primary()
        while self._next() == "[":
            self._take()
            kept: Values = {}
            named = self._space.named(made)
            while self._tokens[self._at - 1] != "]":
                blade = self._take()
                while self._next() == "^":
                    blade += self._take() + self._take()
                kept = added(kept, self._space.blade(blade), named.get(blade, 0.0))
                self._take()
            made = kept
        return made

    def _primary(self) -> Values:
        token = self._take()
        if token == "(":
            made = self._expression()
            self._take()
            return made
        if token[0].isdigit() or token[0] == ".":
            return {0: float(token)}
        if token == "_P":
            self._take()
            index = int(self._take())
            self._take()
            return self._arguments[index - 1]
        if self._next() == "(":
            return self._called(token)
        if token.startswith("::"):
            return self._script[token[2:]]
        if token in self._space.vectors:
            return self._space.vectors[token]
        return self._names[token] if token in self._names else self._script[token]

    def _called(self, name: str) -> Values:
        self._take()
        given = []
        while self._next() != ")":
            given.append(self._expression())
            if self._next() == ",":
                self._take()
        self._take()
        if name in self._macros:
            return self._expanded(self._macros[name], given)
        return self._computed(name, given)

    def _expanded(self, start: int, given: list[Values]) -> Values:
        kept = self._at, self._names, self._arguments
        self._at, self._names, self._arguments = start, {}, given
        while self._next() in ("if", "loop") or self._next(1) == "=":
            self._statement()
            while self._next() == ";":
                self._take()
        made = self._expression()
        self._at, self._names, self._arguments = kept
        return made

    def _computed(self, name: str, given: list[Values]) -> Values:
        x = given[0]
        changed: dict[str, Callable[[], Values]] = {
            "reverse": lambda: reverse(x),
            "involute": lambda: signed(x, lambda r: -1 if r % 2 else 1),
            "conjugate": lambda: signed(x, lambda r: -1 if r % 4 in (1, 2) else 1),
            "complement": lambda: self._space.complement(x),
            "uncomplement": lambda: self._space.complement(x, back=True),
            "scalar": lambda: {0: x.get(0, 0.0)},
            "abs": lambda: {0: self._space.size(x)},
            "grade": lambda: {m: v for m, v in x.items() if m.bit_count() == given[1][0]},
        }
        if name.lower() in changed:
            return changed[name.lower()]()
        numbers = [one.get(0, 0.0) for one in given]
        functions: dict[str, Any] = {
            "min": min, "max": max, "fact": lambda n: math.factorial(int(n)),
            "sign": lambda v: (v > 0) - (v < 0), "step": lambda v: v >= 0,
        }  # fmt: skip
        function = functions.get(name) or getattr(math, name.lower())
        return {0: float(function(*numbers))}
