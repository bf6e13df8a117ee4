"""The syntax tree of CLUScript: frozen nodes that know their places.

Long sums make deep trees, so nothing here recurses: `postorder` walks with a stack of its own,
and nodes compare by identity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from motorcade.ga.script.errors import Place, Source


@dataclass(frozen=True, eq=False, repr=False)
class Number:
    """A decimal number."""

    place: Place
    value: float


@dataclass(frozen=True, eq=False, repr=False)
class Name:
    """A variable or basis vector."""

    place: Place
    name: str


@dataclass(frozen=True, eq=False, repr=False)
class Argument:
    """``_P(index)``, from 1."""

    place: Place
    index: int


@dataclass(frozen=True, eq=False, repr=False)
class Unary:
    """``-x``, ``~x`` reverse or ``*x`` dual."""

    place: Place
    operator: str
    operand: Expression


@dataclass(frozen=True, eq=False, repr=False)
class Binary:
    """``^ . / * - +`` between two operands; the place is the operator's."""

    place: Place
    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, eq=False, repr=False)
class Call:
    """A function or macro with its arguments."""

    place: Place
    name: str
    arguments: tuple[Expression, ...]


Expression = Number | Name | Argument | Unary | Binary | Call


@dataclass(frozen=True, eq=False, repr=False)
class Assignment:
    """``name = value;``, `mark` being ``?`` output, ``!`` evaluate, ``:`` draw, or empty."""

    place: Place
    mark: str
    name: str
    value: Expression


@dataclass(frozen=True, eq=False, repr=False)
class Mark:
    """``?name;``, ``!name;`` or ``:name;``."""

    place: Place
    mark: str
    name: str


@dataclass(frozen=True, eq=False, repr=False)
class Macro:
    """``name = { statements; expression }``; `arity` is the highest index of ``_P``."""

    place: Place
    name: str
    body: tuple[Assignment, ...]
    value: Expression
    arity: int


@dataclass(frozen=True, eq=False, repr=False)
class OutputPragma:
    """``//#pragma output name blade …`` or ``//#pragma return name``; no blades: all of them."""

    place: Place
    name: str
    blades: tuple[str, ...]


@dataclass(frozen=True, eq=False, repr=False)
class RangePragma:
    """``//#pragma range low <= name <= high``."""

    place: Place
    low: float
    name: str
    high: float


@dataclass(frozen=True, eq=False, repr=False)
class AlgebraPragma:
    """``//#pragma algebra`` with a name, or with p, q and r."""

    place: Place
    name: str
    signature: tuple[int, int, int]


Statement = Assignment | Mark | Macro
Pragma = OutputPragma | RangePragma | AlgebraPragma


@dataclass(frozen=True, eq=False, repr=False)
class Script:
    """A parsed script: its statements and pragmas, each in the order of the text.

    >>> from motorcade.ga.script import parse
    >>> [statement.name for statement in parse("a = x*e1; ?square = a*a;").statements]
    ['a', 'square']
    """

    source: Source
    statements: tuple[Statement, ...]
    pragmas: tuple[Pragma, ...]


def postorder(root: Expression) -> Iterator[Expression]:
    """All nodes of an expression, operands before what they are operands of, left to right."""
    waiting: list[tuple[Expression, bool]] = [(root, False)]
    while waiting:
        node, ready = waiting.pop()
        below = () if ready else _operands(node)
        if not below:
            yield node
            continue
        waiting.append((node, True))
        waiting.extend((operand, False) for operand in reversed(below))


def _operands(node: Expression) -> tuple[Expression, ...]:
    if isinstance(node, Binary):
        return node.left, node.right
    if isinstance(node, Unary):
        return (node.operand,)
    return node.arguments if isinstance(node, Call) else ()
