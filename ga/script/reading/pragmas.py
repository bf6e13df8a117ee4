"""Pragmas of CLUScript: lines ``#pragma …`` or ``//#pragma …`` beside the statements.

What a pragma of Gaalop says to its own writers or screen alone is read and left out, with a warning
where somebody could count on it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from motorcade.ga.script.errors import Source
from motorcade.ga.script.reading.lexer import Token
from motorcade.ga.script.reading.syntax import (
    AlgebraPragma,
    ImportPragma,
    InputPragma,
    LeftOutPragma,
    NormalizePragma,
    OutputPragma,
    Pragma,
    RangePragma,
    UnrollPragma,
)

MAX_ROUNDS = 1000
_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_BLADE = re.compile(r"1(?:\.0*)?|[A-Za-z_][A-Za-z_0-9]*(?:\^[A-Za-z_][A-Za-z_0-9]*)*")
_NUMBER = r"-?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_RANGE = re.compile(rf"({_NUMBER})\s*<=\s*([A-Za-z_][A-Za-z_0-9]*)\s*<=\s*({_NUMBER})")
# A file beside the script or below it: no other place can be named.
_FILE = re.compile(r"\"?([A-Za-z0-9_][A-Za-z0-9_.\-]*(?:/[A-Za-z0-9_][A-Za-z0-9_.\-]*)*)\"?")
USES = {
    "output": "#pragma output NAME BLADE …, blades such as 1, e1 or e1^e2",
    "return": "#pragma return NAME …",
    "in2out": "#pragma in2out INPUT, … -> OUTPUT, …",
    "range": "#pragma range LOW <= NAME <= HIGH",
    "algebra": "#pragma algebra cga, #pragma algebra FILE.toml, or #pragma algebra P Q R",
    "import": "#pragma import FILE.clu, a file beside the script or below it",
    "unroll": f"#pragma unroll N, N from 1 to {MAX_ROUNDS}",
    "count": f"#pragma count N, N from 1 to {MAX_ROUNDS}",
    "normalize": "#pragma normalize",
    "onlyEvaluate": "#pragma onlyEvaluate NAME …",
    "insert": "#pragma insert TEXT",
    "segments": "#pragma segments A B, …",
    "triangles": "#pragma triangles A B C, …",
}


def parse_pragma(source: Source, token: Token) -> list[Pragma]:
    """What one pragma says: several names after ``return`` are several pragmas.

    Raises:
        ScriptError: an unknown pragma, or one that is not written as above.
    """
    text = token.text.removeprefix("//").replace("\t", " ")
    if text.startswith("#include"):
        kind, said = "import", text.removeprefix("#include").strip()
    else:
        kind, _, said = text.removeprefix("#pragma").strip().partition(" ")
    if kind not in _READERS:
        raise source.error(token.place, f"expected a pragma {', '.join(USES)}, got {kind[:40]!a}")
    made = _READERS[kind](said.strip(), token)
    if not made:
        raise source.error(token.place, f"this {kind} pragma cannot be read", f"write {USES[kind]}")
    return made


def _names(said: str) -> list[str]:
    """Names with blanks or commas between them; none where one is no name."""
    words = said.replace(",", " ").split()
    return words if all(map(_NAME.fullmatch, words)) else []


def _output(said: str, token: Token) -> list[Pragma]:
    name, *blades = said.split() or [""]
    if not _NAME.fullmatch(name) or not all(map(_BLADE.fullmatch, blades)):
        return []
    kept = tuple("1" if blade.startswith("1") else blade for blade in blades)
    return [OutputPragma(token.place, name, kept)]


def _return(said: str, token: Token) -> list[Pragma]:
    names, *shaped = re.split(r"\s+typed\s+|\s+as\s+", said)
    made: list[Pragma] = [OutputPragma(token.place, name, ()) for name in _names(names)]
    if made and shaped:
        made.append(LeftOutPragma(token.place, "outputs are multivectors: typed … as is left out"))
    return made


def _in2out(said: str, token: Token) -> list[Pragma]:
    before, arrow, after = said.partition("->")
    inputs, outputs = _names(before), _names(after)
    if not arrow or not outputs or (before.strip() and not inputs):
        return []
    return [
        *(InputPragma(token.place, name) for name in inputs),
        *(OutputPragma(token.place, name, (), leads=True) for name in outputs),
    ]


def _range(said: str, token: Token) -> list[Pragma]:
    found = _RANGE.fullmatch(said)
    if found is None:
        return []
    low, high = float(found[1]), float(found[3])
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        return []
    return [RangePragma(token.place, low, found[2], high)]


def _algebra(said: str, token: Token) -> list[Pragma]:
    words = said.split()
    if len(words) == 3 and all(re.fullmatch("[0-9]{1,2}", word) for word in words):
        p, q, r = (int(word) for word in words)
        return [AlgebraPragma(token.place, "", (p, q, r))]
    file = _FILE.fullmatch(said)
    if file is None or len(words) != 1:
        return []
    name = file[1] if file[1].endswith(".toml") else file[1].lower()
    return [AlgebraPragma(token.place, name, (0, 0, 0))]


def _import(said: str, token: Token) -> list[Pragma]:
    file = _FILE.fullmatch(said)
    return [] if file is None else [ImportPragma(token.place, file[1])]


def _unroll(said: str, token: Token) -> list[Pragma]:
    whole = re.fullmatch("[0-9]{1,4}", said)
    if whole is None or not 1 <= int(said) <= MAX_ROUNDS:
        return []
    return [UnrollPragma(token.place, int(said))]


def _normalize(said: str, token: Token) -> list[Pragma]:
    return [] if said else [NormalizePragma(token.place)]


def _left_out(why: str) -> Callable[[str, Token], list[Pragma]]:
    return lambda said, token: [LeftOutPragma(token.place, why)] if said else []


def _evaluated(said: str, token: Token) -> list[Pragma]:
    return [LeftOutPragma(token.place, "")] if _names(said) else []


_READERS: dict[str, Callable[[str, Token], list[Pragma]]] = {
    "output": _output,
    "return": _return,
    "in2out": _in2out,
    "range": _range,
    "algebra": _algebra,
    "import": _import,
    "unroll": _unroll,
    "count": _unroll,
    "normalize": _normalize,
    "onlyEvaluate": _evaluated,
    "insert": _left_out("no text of a script goes into code: insert is left out"),
    "segments": _left_out(""),
    "triangles": _left_out(""),
}
