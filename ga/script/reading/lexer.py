"""Lexer of CLUScript: text to tokens with places.

Names are ASCII identifiers. Numbers are decimal, with an optional exponent and C's suffixes f and
d, which change nothing; a point that follows digits belongs to the number, so the inner product of
a number is written with a space. ``/*`` always opens a comment: division by a dual is ``a / *b``.
``//#pragma …``, ``#pragma …`` and ``#include …`` are one token each, and so are a text in quotes
and a name with ``::`` before it, which says that it is the script's.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from motorcade.ga.script.errors import Place, ScriptError, Source

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
