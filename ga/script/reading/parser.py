"""Parser of CLUScript: statements, macros and pragmas around `expressions`.

A statement is ``name = expression;`` or, with a mark, ``?name = expression;`` or ``?name;``:
``?`` output, ``!`` evaluate, ``:`` draw. A macro is ``name = { statements; expression }``; its
arguments are ``_P(1)``, ``_P(2)``, … Macros do not nest. What CLUCalc and Gaalop write for the
screen is read and left out: ``:IPNS;``, ``:Red;``, ``:a^b;``, ``_BGColor = White;``.
``DefVarsN3();`` is the pragma of its algebra.
"""

from __future__ import annotations

import math
import re

from motorcade.ga.script.errors import Source
from motorcade.ga.script.reading.expressions import Cursor, parse_expression
from motorcade.ga.script.reading.lexer import Token, tokenize
from motorcade.ga.script.reading.syntax import (
    AlgebraPragma,
    Argument,
    Assignment,
    Expression,
    Macro,
    Mark,
    OutputPragma,
    Pragma,
    RangePragma,
    Script,
    Statement,
    postorder,
)

_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_BLADE = re.compile(r"1(?:\.0*)?|[A-Za-z_][A-Za-z_0-9]*(?:\^[A-Za-z_][A-Za-z_0-9]*)*")
_NUMBER = r"-?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_RANGE = re.compile(rf"({_NUMBER})\s*<=\s*([A-Za-z_][A-Za-z_0-9]*)\s*<=\s*({_NUMBER})")
_USES = {
    "output": "//#pragma output NAME BLADE …, blades such as 1, e1 or e1^e2",
    "return": "//#pragma return NAME …",
    "range": "//#pragma range LOW <= NAME <= HIGH",
    "algebra": "//#pragma algebra cga3, or //#pragma algebra P Q R",
}
_MARKS = ("?", "!", ":")
_SCREEN = frozenset(
    [
        "IPNS",
        "OPNS",
        "Black",
        "Blue",
        "Cyan",
        "Green",
        "Magenta",
        "Orange",
        "Red",
        "White",
        "Yellow",
    ]
)
_ALGEBRAS = {"DefVarsE3": "ega3", "DefVarsN3": "cga3"}
_BRANCHES = "there are no branches and loops; step, sign, abs, min and max choose values"
_HINTS = {
    **dict.fromkeys(("if", "else", "loop", "break", "for", "while"), _BRANCHES),
    **dict.fromkeys(("DefVarsP3", "DefVarsC2"), "write //#pragma algebra P Q R"),
}


def parse_pragma(source: Source, token: Token) -> list[Pragma]:
    """What one pragma says: several names after ``return`` are several pragmas.

    Raises:
        ScriptError: an unknown pragma, or one that is not written as above.
    """
    rest = token.text.removeprefix("//#pragma").strip()
    kind, _, said = rest.partition(" ")
    if kind not in _USES:
        raise source.error(token.place, f"expected a pragma {', '.join(_USES)}, got {kind[:40]!a}")
    made = _parsed(kind, said.strip(), token)
    if not made:
        raise source.error(
            token.place, f"this {kind} pragma cannot be read", f"write {_USES[kind]}"
        )
    return made


def _parsed(kind: str, said: str, token: Token) -> list[Pragma]:
    """The pragmas, none where they cannot be read."""
    words = said.split()
    if kind == "range":
        return _range(said, token)
    if kind == "algebra":
        return _algebra_pragma(words, token)
    if not words or not _NAME.fullmatch(words[0]):
        return []
    if kind == "return":
        known = all(_NAME.fullmatch(word) for word in words)
        return [OutputPragma(token.place, word, ()) for word in words] if known else []
    if not all(_BLADE.fullmatch(word) for word in words[1:]):
        return []
    blades = tuple("1" if word.startswith("1") else word for word in words[1:])
    return [OutputPragma(token.place, words[0], blades)]


def _range(said: str, token: Token) -> list[Pragma]:
    found = _RANGE.fullmatch(said)
    if found is None:
        return []
    low, high = float(found[1]), float(found[3])
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        return []
    return [RangePragma(token.place, low, found[2], high)]


def _algebra_pragma(words: list[str], token: Token) -> list[Pragma]:
    if len(words) == 1 and _NAME.fullmatch(words[0]):
        return [AlgebraPragma(token.place, words[0].lower(), (0, 0, 0))]
    if len(words) == 3 and all(re.fullmatch("[0-9]{1,2}", word) for word in words):
        p, q, r = (int(word) for word in words)
        return [AlgebraPragma(token.place, "", (p, q, r))]
    return []


def parse(text: str, file: str = "<script>") -> Script:
    """Read a script; `file` is how errors name it.

    Raises:
        ScriptError: what is wrong and where.

    >>> from motorcade.ga.script import parse
    >>> len(parse("a = x*e1; ?square = a*a;").statements)
    2
    """
    source = Source(text, file)
    tokens = tokenize(source)
    pragmas: list[Pragma] = []
    for token in tokens:
        if token.kind == "pragma":
            pragmas.extend(parse_pragma(source, token))
    cursor = Cursor(source, [token for token in tokens if token.kind != "pragma"])
    statements: list[Statement] = []
    while cursor.token.kind != "end":
        if cursor.at(";"):
            cursor.take()
        elif cursor.token.text in _ALGEBRAS and cursor.following.text == "(":
            pragmas.append(_algebra(cursor))
        elif not _for_the_screen(cursor):
            statements.append(_statement(cursor))
    return Script(source, tuple(statements), tuple(pragmas))


def _algebra(cursor: Cursor) -> AlgebraPragma:
    """``DefVarsN3();``"""
    name = cursor.take()
    for symbol in "();":
        cursor.expect(symbol, f"write {name.text}();")
    return AlgebraPragma(name.place, _ALGEBRAS[name.text], (0, 0, 0))


def _for_the_screen(cursor: Cursor) -> bool:
    """Read what only draws, if that is what comes next."""
    if cursor.token.text == "_BGColor" and cursor.following.text == "=":
        cursor.take()
        cursor.take()
    elif cursor.at(":") and cursor.following.text in _SCREEN:
        cursor.take()
        cursor.take()
        if cursor.at(";"):
            cursor.take()
        return True
    elif cursor.at(":") and not cursor.named_next(";", "=") and cursor.following.text != ":":
        cursor.take()
    else:
        return False
    _outside_macro(cursor, parse_expression(cursor))
    cursor.expect(";", "every statement ends in ';'")
    return True


def _statement(cursor: Cursor) -> Statement:
    mark = _mark(cursor)
    name = _name(cursor)
    if mark and cursor.at(";"):
        cursor.take()
        return Mark(name.place, mark, name.text)
    cursor.expect("=", _HINTS.get(name.text, "a statement is name = expression; or ?name;"))
    if not mark and cursor.at("{"):
        return _macro(cursor, name)
    return _assigned(cursor, mark, name)


def _mark(cursor: Cursor) -> str:
    return cursor.take().text if any(map(cursor.at, _MARKS)) else ""


def _name(cursor: Cursor) -> Token:
    if cursor.token.kind != "name" or cursor.token.text == "_P":
        scoped = "macros see the names of the script: leave the :: out"
        usual = "a statement is name = expression; or ?name;"
        raise cursor.unexpected("a name", scoped if cursor.at(":") else usual)
    return cursor.take()


def _assigned(cursor: Cursor, mark: str, name: Token) -> Assignment:
    if cursor.at("{"):
        raise cursor.unexpected("an expression", "a macro stands by itself and has no mark")
    value = _outside_macro(cursor, parse_expression(cursor))
    cursor.expect(";", "every statement ends in ';'")
    return Assignment(name.place, mark, name.text, value)


def _outside_macro(cursor: Cursor, value: Expression) -> Expression:
    for node in postorder(value):
        if isinstance(node, Argument):
            raise cursor.source.error(
                node.place, f"_P({node.index}) stands outside a macro", "give it a name"
            )
    return value


def _macro(cursor: Cursor, name: Token) -> Macro:
    cursor.expect("{")
    body: list[Assignment] = []
    while _at_local(cursor):
        local = cursor.take()
        cursor.take()
        if cursor.at("{"):
            raise cursor.unexpected("an expression", "a macro holds no other macro")
        body.append(Assignment(local.place, "", local.text, parse_expression(cursor)))
        cursor.expect(";", "every statement of a macro ends in ';'")
    if cursor.at("?"):
        raise cursor.unexpected("an expression", "an output is marked outside of macros")
    if cursor.at("}"):
        raise cursor.unexpected(
            "an expression", "a macro ends in the expression that it stands for"
        )
    value = parse_expression(cursor)
    if cursor.at(";"):
        cursor.take()
    cursor.expect("}", "a macro is name = { statements; expression }")
    parts = [statement.value for statement in body] + [value]
    indices = [n.index for part in parts for n in postorder(part) if isinstance(n, Argument)]
    return Macro(name.place, name.text, tuple(body), value, max(indices, default=0))


def _at_local(cursor: Cursor) -> bool:
    """Whether a local name is assigned next; the marks ! and : before it say nothing here."""
    if (cursor.at("!") or cursor.at(":")) and cursor.following.kind == "name":
        cursor.take()
    return cursor.token.kind == "name" and cursor.following.text == "="
