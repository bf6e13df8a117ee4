"""Tokens and the syntax tree of CLUScript, which know their places.

Names are ASCII identifiers. Numbers are decimal, with an optional exponent and C's suffixes f and
d, which change nothing; a point that follows digits belongs to the number, so the inner product of
a number is written with a space. ``/*`` always opens a comment: division by a dual is ``a / *b``.
``//#pragma …``, ``#pragma …`` and ``#include …`` are one token each, and so are a text in quotes
and a name with ``::`` before it, which says that it is the script's.

Long sums make deep trees, so nothing here recurses: `postorder` walks with a stack of its own,
and nodes compare by identity.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from motorcade.ga.script.errors import Place, ScriptError, Source


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
    """``-x``, ``~x`` reverse, ``*x`` dual or ``!!x`` logical not."""

    place: Place
    operator: str
    operand: Expression


@dataclass(frozen=True, eq=False, repr=False)
class Binary:
    """An operator between two operands; the place is the operator's."""

    place: Place
    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, eq=False, repr=False)
class Call:
    """A function or macro with its arguments; without a name the first of them is called."""

    place: Place
    name: str
    arguments: tuple[Expression, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Slice:
    """``x[e1, e2^e3]``: the part of `operand` on these blades; the place is the bracket's."""

    place: Place
    operand: Expression
    blades: tuple[str, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Text:
    """``"words"``, in CLUCalc's scripts."""

    place: Place
    text: str


@dataclass(frozen=True, eq=False, repr=False)
class ListOf:
    """``[a, b]`` in CLUCalc's scripts."""

    place: Place
    items: tuple[Expression, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Skipped:
    """A call of CLUCalc's that draws or sets up its window; `arguments` are those that it draws."""

    place: Place
    name: str
    arguments: tuple[Expression, ...]


Expression = Number | Name | Argument | Unary | Binary | Call | Slice | Text | ListOf | Skipped


@dataclass(frozen=True, eq=False, repr=False)
class Assignment:
    """``name = value;``, `mark` being ``?`` output, ``!`` evaluate, ``:`` draw, or empty.

    Without a name the value is only computed, as of ``f(x);``; `refers`: it is ``name -> value;``.
    """

    place: Place
    mark: str
    name: str
    value: Expression
    refers: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Mark:
    """``?name;``, ``!name;`` or ``:name;``."""

    place: Place
    mark: str
    name: str


@dataclass(frozen=True, eq=False, repr=False)
class If:
    """``if (condition) then`` with or without ``else otherwise``."""

    place: Place
    condition: Expression
    then: tuple[Step, ...]
    otherwise: tuple[Step, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Loop:
    """``loop { body }`` up to a ``break``; `rounds` are those of ``#pragma unroll``, 0 without."""

    place: Place
    body: tuple[Step, ...]
    rounds: int


@dataclass(frozen=True, eq=False, repr=False)
class Break:
    """``break;``"""

    place: Place


@dataclass(frozen=True, eq=False, repr=False)
class Screen:
    """``:IPNS;``, ``:Red;`` or ``:Color(1, 0, 0);``: a word for the image, the call as its value.

    Without a word the value is drawn, as of ``:a^b;``.
    """

    place: Place
    word: str
    value: Expression | None


Step = Assignment | Mark | If | Loop | Break | Screen


@dataclass(frozen=True, eq=False, repr=False)
class Macro:
    """``name = { statements; expression }`` of the text `source`.

    `arity` is the highest index of ``_P``; one of CLUCalc's may end without a value.
    """

    place: Place
    name: str
    body: tuple[Step, ...]
    value: Expression | None
    arity: int
    source: Source


@dataclass(frozen=True, eq=False, repr=False)
class OutputPragma:
    """``#pragma output name blade …`` or ``#pragma return name``; no blades: all of them.

    `leads` are those of ``#pragma in2out``, which come before all other outputs.
    """

    place: Place
    name: str
    blades: tuple[str, ...]
    leads: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class InputPragma:
    """A variable that ``#pragma in2out`` names before its arrow."""

    place: Place
    name: str


@dataclass(frozen=True, eq=False, repr=False)
class RangePragma:
    """``#pragma range low <= name <= high``."""

    place: Place
    low: float
    name: str
    high: float


@dataclass(frozen=True, eq=False, repr=False)
class AlgebraPragma:
    """``#pragma algebra`` with a name or the name of a file, or with p, q and r.

    `by_caller`: no text holds it, the caller named it; a file of that name lies in `folder` then.
    """

    place: Place
    name: str
    signature: tuple[int, int, int]
    by_caller: bool = False
    folder: Path | None = None


@dataclass(frozen=True, eq=False, repr=False)
class NormalizePragma:
    """``#pragma normalize``: outputs that are assigned below it are divided by their size."""

    place: Place


@dataclass(frozen=True, eq=False, repr=False)
class UnrollPragma:
    """``#pragma unroll N``: how often the loop below it runs."""

    place: Place
    rounds: int


@dataclass(frozen=True, eq=False, repr=False)
class ImportPragma:
    """``#pragma import FILE`` or ``#include FILE``: a file of macros beside the script."""

    place: Place
    file: str


@dataclass(frozen=True, eq=False, repr=False)
class LeftOutPragma:
    """What is read and changes nothing; `why` is what a warning says, none if empty."""

    place: Place
    why: str


Statement = Step | Macro
Pragma = (
    OutputPragma
    | InputPragma
    | RangePragma
    | AlgebraPragma
    | NormalizePragma
    | UnrollPragma
    | ImportPragma
    | LeftOutPragma
)


@dataclass(frozen=True, eq=False, repr=False)
class Script:
    """A parsed script: its statements and pragmas, each in the order of the text.

    `folder` is where the files lie that it names, None if it may name none. `clucalc`: it has what
    CLUCalc alone reads, so that CLUCalc's variables have their values.

    >>> from motorcade.ga.script import parse
    >>> [statement.name for statement in parse("a = x*e1; ?square = a*a;").statements]
    ['a', 'square']
    """

    source: Source
    statements: tuple[Statement, ...]
    pragmas: tuple[Pragma, ...]
    folder: Path | None = None
    clucalc: bool = False


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
    if isinstance(node, Unary | Slice):
        return (node.operand,)
    if isinstance(node, ListOf):
        return node.items
    return node.arguments if isinstance(node, Call | Skipped) else ()


def expressions_of(steps: Sequence[Step]) -> Iterator[Expression]:
    """The expressions that statements compute, in their order, those of blocks included."""
    for step in steps:
        if isinstance(step, Assignment):
            yield step.value
        elif isinstance(step, If):
            yield step.condition
            yield from expressions_of((*step.then, *step.otherwise))
        elif isinstance(step, Loop):
            yield from expressions_of(step.body)


MAX_SCRIPT_CHARACTERS = 1_000_000
MAX_TOKENS = 200_000

_PATTERN = re.compile(
    r"(?P<space>[ \t\r\f]+)"
    r"|(?P<newline>\n)"
    r"|(?P<pragma>(?:(?://)?#s?pragma|#include)\b[^\n]*)"
    r"|(?P<comment>//[^\n]*)"
    r"|(?P<block>/\*)"
    r"|(?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(?:[fFdD](?![A-Za-z_0-9]))?"
    r"|(?P<name>(?:::)?[A-Za-z_][A-Za-z_0-9]*)"
    r'|(?P<text>"(?:[^"\\]|\\[^\n])*+")'
    r"|(?P<symbol>[=!<>]=|&&|\|\||!!|->|<<|>>|[-+*/%^.~()=?!:;,{}<>&\[\]])"
)
_ALMOST = re.compile(r"//[ \t]+#(?:pragma|include)\b")
_HINTS = {
    "$": "an output's blades are chosen with #pragma output NAME BLADE …",
    "|": "the inner product is written with a point",
    "#": "a pragma is written #pragma, a file of macros #include FILE",
    '"': "this text has no end",
}


@dataclass(frozen=True, slots=True)
class Token:
    """A piece of a script; `kind` is name, number, text, symbol, pragma or end."""

    kind: str
    text: str
    place: Place


def tokenize(source: Source) -> list[Token]:
    """All tokens of a script, the last of kind ``end``.

    Raises ScriptError: a character that no token starts with, a comment without an end, a number
    too large, a script that is too long.
    """
    text, position, line, start = source.text, 0, 1, 0
    if len(text) > MAX_SCRIPT_CHARACTERS:
        raise source.error(
            Place(1, 1),
            f"expected at most {MAX_SCRIPT_CHARACTERS} characters, got {len(text)}",
            "split the script",
        )
    tokens: list[Token] = []
    while position < len(text):
        place = Place(line, position - start + 1)
        match = _PATTERN.match(text, position)
        if match is None:
            raise _unknown(source, place, text[position])
        kind, end = str(match.lastgroup), match.end()
        if kind == "block":
            end = _comment_end(source, position, place)
        if kind in ("newline", "block"):
            line += text.count("\n", position, end)
            start = max(start, text.rfind("\n", position, end) + 1)
        elif kind == "comment" and _ALMOST.match(match.group()):
            source.warn(place, "a comment, and no pragma: write //#pragma without a blank")
        elif kind not in ("space", "comment"):
            token = Token(kind, match.group(kind), place)
            tokens.append(_checked(source, token, text[end : end + 1]))
            line += token.text.count("\n")
            start = max(start, text.rfind("\n", position, end) + 1)
        if len(tokens) > MAX_TOKENS:
            raise source.error(place, f"expected at most {MAX_TOKENS} tokens", "split the script")
        position = end
    tokens.append(Token("end", "", Place(line, position - start + 1)))
    return tokens


def _comment_end(source: Source, position: int, place: Place) -> int:
    end = source.text.find("*/", position + 2)
    if end < 0:
        raise source.error(
            place,
            "this comment has no end",
            "close it with */, or write a space between / and * to divide by a dual",
        )
    return end + 2


def _checked(source: Source, token: Token, following: str) -> Token:
    if token.kind == "number":
        if following.isascii() and (following.isalpha() or following == "_"):
            place = Place(token.place.line, token.place.column + len(token.text))
            raise source.error(
                place,
                f"expected an operator after the number {_short(token.text)}",
                f"write {_short(token.text)}*{following}… for a product",
            )
        if float(token.text) == float("inf"):
            raise source.error(token.place, "expected a number below 1.8e308")
    return token


def _short(text: str) -> str:
    return text if len(text) <= 20 else f"{text[:17]}..."


def _unknown(source: Source, place: Place, letter: str) -> ScriptError:
    hint = _HINTS.get(letter, "")
    return source.error(place, f"expected a token, got {letter!a}", hint)
