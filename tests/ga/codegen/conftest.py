"""Random CLUScripts over four scalars, of functions defined everywhere; tapes written by hand."""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga.codegen.tape import Node, Operand, Tape

_VARIABLES = ("a", "b", "c", "d")
_BLADES = ("e1", "e2", "e3", "einf", "e0", "e1^e2", "e2^e3", "e3^e1")
_WRAPPED = (
    "abs({x})",
    "(~{x})",
    "(-{x})",
    "({x}*{x})",
    "({x}/abs({x}*~{x} + 7 + {v}*{v}))",
    "({x}*invert(3 + {v}*e1^e2))",
    "(sin({v}*2)*{x})",
    "(cos({v})*{x})",
    "({x}/({v}*{v}*{w}))",
    "(sqrt({v}*{v} + 1)*{x}/sqrt({v}*{v} + 1))",
    "(atan({v}/{w})*{x})",
    "(exp(-{v}*{v})*{x})",
    "(floor(3*{v})*{x})",
)


@pytest.fixture
def random_script() -> Callable[[np.random.Generator], str]:
    """What makes a script from a generator of random numbers."""
    return written


def written(rng: np.random.Generator) -> str:
    """A script of a few assignments, of which the last two are outputs."""
    names: list[str] = []
    lines = []
    for index in range(rng.integers(2, 5)):
        lines.append(f"v{index} = {_expression(rng, names, int(rng.integers(1, 4)))};")
        names.append(f"v{index}")
    return "\n".join([*lines, *(f"?{name};" for name in names[-2:])])


def _pick(rng: np.random.Generator, choices: tuple[str, ...]) -> str:
    return choices[rng.integers(len(choices))]


def _expression(rng: np.random.Generator, names: list[str], depth: int) -> str:
    if depth == 0:
        kind = rng.integers(4)
        if kind == 0 and names:
            return _pick(rng, tuple(names))
        if kind == 1:
            return str(rng.integers(1, 5))
        variable = _pick(rng, _VARIABLES)
        return f"{variable}*{_pick(rng, _BLADES)}" if kind == 2 else variable
    left = _expression(rng, names, depth - 1)
    if rng.random() < 0.2:
        v, w = _pick(rng, _VARIABLES), _pick(rng, _VARIABLES)
        return _pick(rng, _WRAPPED).format(x=left, v=v, w=w)
    right = _expression(rng, names, depth - 1)
    return f"({left} {_pick(rng, ('+', '+', '-', '*', '*', '*', '^', '.'))} {right})"


class Nodes:
    """A tape as it is written down: nothing is simplified or shared."""

    def __init__(self, *names: str) -> None:
        self.names = names
        self.nodes = [Node("input", (), 0.0, (name, 0)) for name in names]

    def __call__(self, op: str, *args: int) -> int:
        self.nodes.append(Node(op, args))
        return len(self.nodes) - 1

    def constant(self, value: float) -> int:
        self.nodes.append(Node("const", (), value))
        return len(self.nodes) - 1

    def tape(self) -> Tape:
        inputs = tuple(Operand(name, ("1",)) for name in self.names)
        return Tape(inputs, (Operand("out", ("1",)),), tuple(self.nodes), ((len(self.nodes) - 1,),))


@pytest.fixture
def nodes() -> type[Nodes]:
    """Called with the names of inputs it begins a tape."""
    return Nodes
