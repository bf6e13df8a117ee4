"""Random scripts by their shape: counts of inputs and outputs, lengths of names, nested depth.

Every script is worked out on numbers while no part of it cancels: constants are halves and eighths,
which single precision holds, and functions are smooth where they are drawn, so that whatever reads
or runs the code gives the same to rounding.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from motorcade.ga.script.meaning import algebra_named
from tests.ga.gaalop.scripts import Case, Values, directly

MOST_INPUTS = 80
_ALGEBRAS = ("3d", "cga", "3dpga", "2d")
_LETTERS = "abcdghkmnpqruvwxyzABCDFGHJKLMNOPQRSTUVWXYZ_"
# Names that code writes for itself, and words that single languages keep.
_CLOSE = (
    "t0", "t1", "t2", "x0", "x1", "out_r0", "in_x", "row", "rows", "padded", "blocks", "_given",
    "_value", "_full", "np", "torch", "ca", "fn", "let", "def", "lambda", "type", "end",
    "result", "v", "E", "Inf", "NaN", "f32", "motorcade_sin", "MOTORCADE_SIN", "uint64_t",
    "_", "__", "_0", "self", "var",
    "async", "main", "i", "j", "N", "alpha", "left_arm", "__proto__", "arguments", "real_sin", "M",
)  # fmt: skip
_NUMBERS = ("0.5", "2", "0.125", "3")
_CALLS = (
    "sin({x})", "cos({x})", "atan({x})", "sqrt(2 + {x}*{x})", "exp({x}/8)", "abs({x})",
    "log(3 + {x}*{x})", "atan2({x}, 2 + {y}*{y})", "min({x}, {y})", "max({x}, 0.125)",
    "({x})/(2 + {y}*{y})", "-({x})", "({x} - {y})", "({x})*({y})/2", "({x} + 0.375*{y})",
    "asin(sin({x})/2)", "acos(cos({y})/2)", "tan(sin({x})/2)", "step({x})*{y}", "sign({y})*{x}",
    "floor(4*sin({x}))", "ceil(2*cos({y}))",
)  # fmt: skip


@dataclass(frozen=True)
class Shape:
    """What is drawn of a script."""

    inputs: int
    outputs: int
    name_length: int
    depth: int


def shape_of(number: int, rng: np.random.Generator) -> Shape:
    """Every count of inputs in turn; the rest at random, small more often than large."""
    return Shape(
        number % (MOST_INPUTS + 1),
        int(rng.choice([1, 1, 1, 2, 3, 5, 9])),
        int(rng.choice([1, 2, 3, 5, 8, 13, 21, 34, 55, 90])),
        int(rng.choice([0, 1, 1, 2, 2, 3, 5, 9, 40])),
    )


def script_case(number: int, seed: int) -> Case:
    """The script of a number, its inputs and what evaluation gives for them."""
    rng = np.random.default_rng([seed, number])
    shape = shape_of(number, rng)
    names = _names(shape, rng)
    inputs = {name: float(rng.uniform(0.3, 1.7) * rng.choice([-1, 1])) for name in names}
    algebra = str(rng.choice(_ALGEBRAS))
    text = _Writer(shape, names, algebra_named(algebra).names, rng).script()
    case = Case(f"s{number}", algebra_named(algebra), text, inputs, None, "")
    expected = directly(case)
    if isinstance(expected, str):
        return Case(case.name, case.algebra, text, inputs, None, expected)
    return Case(case.name, case.algebra, text, inputs, _finite(expected), "")


def _finite(values: Values) -> Values | None:
    numbers = [v for row in values.values() for v in row.values()]
    return values if np.isfinite(numbers).all() else None


def _names(shape: Shape, rng: np.random.Generator) -> list[str]:
    names: dict[str, None] = {}
    close = 0.1 if rng.random() < 0.3 else 0.0
    while len(names) < shape.inputs:
        if rng.random() < close:
            names[str(rng.choice(_CLOSE))] = None
            continue
        letters = "".join(rng.choice(list(_LETTERS), size=shape.name_length))
        letters = re.sub("_+", "_", letters).strip("_") or "q"
        names[f"{letters}{len(names)}" if rng.random() < 0.7 else f"x{letters}y"] = None
    return list(names)


class _Writer:
    def __init__(
        self, shape: Shape, names: list[str], vectors: tuple[str, ...], rng: np.random.Generator
    ) -> None:
        self._shape = shape
        self._names = names
        self._vectors = vectors
        self._rng = rng
        self._left = list(names)

    def script(self) -> str:
        lines = []
        share = -(-len(self._names) // self._shape.outputs)
        for k in range(self._shape.outputs):
            terms = [self._term() for _ in range(max(share, 1))]
            lines.append(self._statement(f"r{k}", " + ".join(terms)))
            if self._rng.random() < 0.1:
                lines.append(f"?zero{k} = e1 - e1;")
        return "\n".join(lines)

    def _statement(self, name: str, total: str) -> str:
        kind = self._rng.random()
        if kind < 0.1:
            test = f"{self._number()} < {self._number()}"
            return f"if ({test}) {{ {name} = {total}; }} else {name} = 2*e1;\n?{name};"
        if kind < 0.2:
            return f"?{name} = ({total})*(0.375*{self._number()} + 1.5*e1*e2);"
        return f"?{name} = {total};"

    def _term(self) -> str:
        value = self._nested(int(self._rng.integers(self._shape.depth + 1)))
        vectors = self._rng.choice(self._vectors, size=int(self._rng.integers(3)), replace=False)
        return "*".join([value, *("^".join(vectors),)]) if len(vectors) else value

    def _nested(self, depth: int) -> str:
        text = self._number()
        for _ in range(depth if self._names else 0):
            call = str(self._rng.choice(_CALLS))
            if call.count("{x}") > 1 and len(text) > 400:
                call = "sin({x})"
            text = call.format(x=text, y=self._variable())
        return text

    def _variable(self) -> str:
        """Functions of numbers alone would be numbers that single precision has to round."""
        return self._left.pop() if self._left else str(self._rng.choice(self._names))

    def _number(self) -> str:
        return (
            self._variable() if self._names else str(self._rng.choice(["0.5", "2", "0.125", "3"]))
        )
