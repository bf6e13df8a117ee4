"""Programs as source code: one module a target, each with ``write(program, precision)``.

``write`` returns the text of each file by its name. Names from scripts are checked by `names`; no
other text of a script gets into the code. `shared` holds what several targets need. What was
written is read back: brackets that close, neighbours that may stand beside each other in all of
these languages. Compilers say the rest; tests run them where they are installed.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from collections.abc import Set as AbstractSet

from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.programs import Program
from motorcade.ga.codegen.targets import (
    c,
    c_batch,
    casadi,
    cpp,
    glsl,
    javascript,
    julia,
    latex,
    numpy,
    rust,
    torch,
    wgsl,
)

_TOKEN = re.compile(
    r"(?P<space>[ \t]+|\\\n)|(?P<comment>/\*.*?\*/|//[^\n]*)|(?P<line>\n)|(?P<text>\"[^\"\n]*\")"
    r"|(?P<number>(?:0x[0-9a-fA-F.]+(?:p[+-]?\d+)?|(?:\d+\.?\d*|\.\d+)(?:[ef][+-]?\d+)?)[a-zA-Z]*)"
    r"|(?P<name>[A-Za-z_]\w*)|(?P<pair>[([{]|[)\]}])|(?P<end>[;,])|(?P<step>\+\+|--|\.\.\.)"
    r"|(?P<between>->|&&|\|\||::|[=!]==|<<=?|>>=?|[-+*/<>=!&|]=|[-+*/%<>=&|^.?:~!@#])",
    re.S,
)
_CLOSING = {"(": ")", "[": "]", "{": "}"}
# Before an operand, these are signs of it; types of pointers and references are written with them.
_SIGNS = frozenset("-+!*&~")
# After these words another word may follow: types, and what begins a statement.
_WORDS = """
    _Bool array bool char const double else end export extern f32 f64 float fn for function if
    inline inout int int64_t let mut out pub ptr restrict return short signed size_t sizeof static
    struct typedef uint32_t uint64_t union unsigned using var void while
"""
_BEFORE_NAMES = frozenset(_WORDS.split())
_PREPROCESSED = re.compile(r"^[ \t]*#[^\n]*$", re.M)
_ATTRIBUTES = re.compile(r"__attribute__\(\(.*\)\)|\((?:void|float|double|int|unsigned)\)")
_OWN_TYPE = re.compile(r"(?:\} |struct )(\w+)")
_ENVIRONMENT = re.compile(r"\\(begin|end)\{([^}]*)\}|\\(left|right)(?![a-z])|\\[{}]|([{}])|%[^\n]*")


def check_text(language: str, name: str, text: str) -> None:
    """Refuse a file of code that cannot be what it is meant to be.

    Raises RuntimeError: where, and between which words; it is a fault of the writer, not of what
    it wrote.
    """
    fault = _latex_fault(text) if language == "latex" else _fault(text, language)
    if fault:
        raise RuntimeError(
            f"target {language}: wrote a file {name} that does not read, {fault}; "
            "please report the script that it was written from"
        )


def _fault(text: str, language: str) -> str:
    by_lines = language == "julia"
    plain = re.sub(r"#[^\n]*", "", text) if by_lines else _ATTRIBUTES.sub("", text)
    plain = plain if by_lines else _PREPROCESSED.sub("", plain)
    types = _BEFORE_NAMES | set(_OWN_TYPE.findall(plain)) | ({"end"} if by_lines else set())
    opened: list[str] = []
    before, kind, at = ";", "end", 0
    while at < len(plain):
        match = _TOKEN.match(plain, at)
        line = plain.count("\n", 0, at) + 1
        if match is None:
            return f"line {line}: {plain[at]!r}"
        at, now, word = match.end(), str(match.lastgroup), match[0]
        if now == "line" and by_lines and not opened and kind != "between":
            now, word = "end", ";"
        if now in ("space", "comment", "line"):
            continue
        if word in _CLOSING:
            opened.append(_CLOSING[word])
        elif now == "pair" and (not opened or opened.pop() != word):
            return f"line {line}: {word} closes nothing"
        if not _neighbours(before, kind, word, now, types):
            return f"line {line}: {before} {word}"
        before, kind = word, now
    return f"{opened[-1]} is missing at the end" if opened else ""


def _neighbours(before: str, kind: str, word: str, now: str, types: AbstractSet[str]) -> bool:
    """Whether one token may follow another."""
    operand = now in ("name", "number", "text")
    ended = kind in ("number", "text") or before in (")", "]")
    if operand and kind == "name":
        return before in types or word in types
    if operand and ended:
        return word in types
    if before == "<" and word == ">":
        return True  # of a template without arguments
    if now == "between" and word not in _SIGNS:
        return kind != "between" and not (kind == "end" or before in ("(", "["))
    if kind == "between" and (now == "end" or word in (")", "]", "}")):
        return before[-1] == ">"  # of a template
    return not (word == "," and (before in ("(", "[", "{", ",")))


def _latex_fault(text: str) -> str:
    opened: list[str] = []
    for match in _ENVIRONMENT.finditer(text):
        environment, name, delimiter, brace = match.groups()
        if environment == "begin" or delimiter == "left" or brace == "{":
            opened.append(name or delimiter or "}")
        elif environment or delimiter or brace:
            expected = name or ("left" if delimiter else "}")
            if not opened or opened.pop() != expected:
                return f"line {text.count(chr(10), 0, match.start()) + 1}: {match[0]} ends nothing"
    return f"{opened[-1]} is left open" if opened else ""


Write = Callable[[Program, Precision | None], dict[str, str]]


def _read_back(language: str, write: Write) -> Write:
    def written(program: Program, precision: Precision | None) -> dict[str, str]:
        files = write(program, precision)
        for name, text in files.items():
            check_text(language, name, text)
        return files

    return written


_BY_PYTHON = ("numpy", "casadi", "torch")  # which parses them where they are put together
_WRITERS: dict[str, Write] = {
    "c": c.write,
    "c-batch": c_batch.write,
    "numpy": numpy.write,
    "glsl": glsl.write,
    "casadi": casadi.write,
    "torch": torch.write,
    "cpp": cpp.write,
    "rust": rust.write,
    "javascript": javascript.write,
    "wgsl": wgsl.write,
    "julia": julia.write,
    "latex": latex.write,
}
TARGETS: dict[str, Write] = {
    language: write if language in _BY_PYTHON else _read_back(language, write)
    for language, write in _WRITERS.items()
}
