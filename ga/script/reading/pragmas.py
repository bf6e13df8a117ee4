"""Pragmas of CLUScript, one a line.

``//#pragma output NAME BLADE …`` makes NAME an output, of these blades only where any are named;
``//#pragma return NAME …`` makes every NAME an output; ``//#pragma range LOW <= NAME <= HIGH`` is
what a free variable must keep to; ``//#pragma algebra NAME`` or ``//#pragma algebra P Q R`` is the
algebra of the script.
"""

from __future__ import annotations

import math
import re

from motorcade.ga.script.errors import Source
from motorcade.ga.script.reading.lexer import Token
from motorcade.ga.script.reading.syntax import AlgebraPragma, OutputPragma, Pragma, RangePragma

__all__ = ["parse_pragma"]

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
        return _algebra(words, token)
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


def _algebra(words: list[str], token: Token) -> list[Pragma]:
    if len(words) == 1 and _NAME.fullmatch(words[0]):
        return [AlgebraPragma(token.place, words[0].lower(), (0, 0, 0))]
    if len(words) == 3 and all(re.fullmatch("[0-9]{1,2}", word) for word in words):
        p, q, r = (int(word) for word in words)
        return [AlgebraPragma(token.place, "", (p, q, r))]
    return []
