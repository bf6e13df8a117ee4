"""Parser of CLUScript: statements and macros around `expressions`, with the `pragmas`.

A statement is ``name = expression;`` or, with a mark, ``?name = expression;`` or ``?name;``:
``?`` output, ``!`` evaluate, ``:`` draw. The end of a line ends it too. A macro is ``name = {
statements; expression }``; its arguments are ``_P(1)``, ``_P(2)``, … Macros do not nest. There are
``if (condition) { … } else { … }`` and ``loop { … break; … }``. What CLUCalc and Gaalop write for
the screen is a statement too: ``:IPNS;``, ``:Red;``, ``:a^b;``; in macros, and as
``_BGColor = White;``, it is read and left out. ``DefVarsN3();`` is the pragma of its algebra. Of
CLUCalc's scripts there are also texts, lists, ``a % b``, ``x -> y``, ``list << item``, calls and
values that stand alone, colours behind what is drawn, and macros without a value.

Pragmas of CLUScript: lines ``#pragma …`` or ``//#pragma …`` beside the statements.

What a pragma of Gaalop says to its own writers or screen alone is read and left out, with a warning
where somebody could count on it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

from motorcade.ga.script import syntax
from motorcade.ga.script.errors import Imports, Place, Source
from motorcade.ga.script.expressions import Cursor, parse_expression
from motorcade.ga.script.syntax import Token, tokenize

MAX_BLOCKS = 20
_MARKS = ("?", "!", ":")
_COLOURS = ("Black", "Blue", "Cyan", "Green", "Magenta", "Orange", "Red", "White", "Yellow")
_SCREEN = frozenset(["IPNS", "OPNS", *_COLOURS])
# The algebras of CLUCalc's names, those that hold the others last.
_ALGEBRAS = {"E3": "ega3", "P3": "p3", "C2": "c2", "N3": "cga3"}
_BINARY = re.compile(r"[-+*/^.&]")
_CLUCALCS = re.compile("_(?:2dView|DoAnimate|FrameBoxSize)|%")
_OF_ALGEBRA = re.compile(
    r"(?:DefVars|DirVec|Vec|Rotor|Reflector|Sphere|Translator|Dilator)([EPNC][23])"
)
_HINTS = {
    **dict.fromkeys(("for", "while"), "a loop is written loop { … if (…) { break; } … }"),
}
_USUAL = "a statement is name = expression; or ?name;"


def parse(text: str, file: str = "<script>", folder: Path | None = None) -> syntax.Script:
    """Read a script.

    Args:
        text: of the script.
        file: how errors name it.
        folder: where the files lie that it may name: macros to import, an algebra. Without one it
            may name none.

    Raises:
        ScriptError: what is wrong and where, in the script or in a file that it imports.

    >>> from motorcade.ga.script import parse
    >>> len(parse("a = x*e1; ?square = a*a;").statements)
    2
    """
    return _parsed(Source(text, file), folder, Imports(folder))


def _parsed(source: Source, folder: Path | None, imports: Imports) -> syntax.Script:
    tokens = tokenize(source)
    pragmas: list[syntax.Pragma] = []
    macros: list[syntax.Macro] = []
    for token in tokens:
        if token.kind == "pragma":
            pragmas.extend(parse_pragma(source, token))
    for pragma in pragmas:
        if isinstance(pragma, syntax.ImportPragma):
            macros.extend(_imported(source, pragma, imports))
        elif isinstance(pragma, syntax.LeftOutPragma) and pragma.why:
            source.warn(pragma.place, pragma.why)
    cursor = Cursor(source, [token for token in tokens if token.kind != "pragma"])
    reader = _Statements(cursor, pragmas)
    cursor.macros = {macro.name for macro in macros}
    cursor.macros.update(
        name.text
        for name, equals, brace in zip(tokens, tokens[1:], tokens[2:], strict=False)
        if (name.kind, equals.text, brace.text) == ("name", "=", "{")
    )
    reader.name_algebra(tokens)
    statements = (*macros, *reader.read())
    return syntax.Script(source, statements, tuple(pragmas), folder, cursor.clucalc)


def _imported(source: Source, pragma: syntax.ImportPragma, imports: Imports) -> list[syntax.Macro]:
    """The macros of a file, and of those that it imports."""
    imported: list[syntax.Macro] = []
    with imports.opened(source, pragma.place, pragma.file) as file:
        if file is None:
            return []
        script = _parsed(file, imports.folder, imports)
        for statement in script.statements:
            if isinstance(statement, syntax.Macro):
                imported.append(statement)
            elif not isinstance(statement, syntax.Screen):
                raise file.error(
                    statement.place, "expected macros alone in a file that is imported"
                )
    return imported


class _Statements:
    """Reads the statements of one text."""

    def __init__(self, cursor: Cursor, pragmas: list[syntax.Pragma]) -> None:
        self._cursor = cursor
        self._pragmas = pragmas
        self._unrolled = [p for p in pragmas if isinstance(p, syntax.UnrollPragma)]
        self._in_macro = False
        self._blocks = 0
        self._macros: list[syntax.Macro] = []
        self._loops = 0

    def read(self) -> list[syntax.Statement]:
        """All statements of the text."""
        cursor = self._cursor
        statements: list[syntax.Statement] = []
        while cursor.token.kind != "end":
            statements.extend(self._step())
        return [*self._macros, *statements]

    def name_algebra(self, tokens: list[Token]) -> None:
        """Add the pragma of the largest algebra whose vectors a script of CLUCalc's defines."""
        self._cursor.clucalc = any(_CLUCALCS.fullmatch(token.text) for token in tokens)
        named = [t for t in tokens if t.kind == "name" and _OF_ALGEBRA.fullmatch(t.text)]
        if not any(t.text.startswith("DefVars") or t.text[-2:] in ("P3", "C2") for t in named):
            return
        largest = max(named, key=lambda t: list(_ALGEBRAS).index(t.text[-2:]))
        name = _ALGEBRAS[largest.text[-2:]]
        self._pragmas.append(syntax.AlgebraPragma(largest.place, name, (0, 0, 0)))
        self._cursor.clucalc = True

    def _opens_macro(self) -> bool:
        return self._cursor.following.text == "=" and self._cursor.second.text == "{"

    def _step(self) -> list[syntax.Step]:
        """The next statement, if it is one."""
        cursor = self._cursor
        if cursor.at(";"):
            cursor.take()
            return []
        if cursor.token.kind == "name" and self._opens_macro() and not self._in_macro:
            self._macros.append(self._macro())
            return []
        drawn = self._for_the_screen()
        if drawn is not None:
            return drawn
        if cursor.token.kind == "name" and cursor.following.text == "(" and cursor.named("if"):
            return [self._if()]
        if cursor.named("loop") and (self._in_macro or cursor.following.text == "{"):
            return [self._loop()]
        if cursor.named("break") and cursor.following.text != "=":
            place = cursor.take().place
            if not self._loops and not self._in_macro:
                raise cursor.source.error(place, "expected a break inside a loop")
            cursor.end_statement()
            return [syntax.Break(place)]
        return self._assigned()

    def _block(self) -> tuple[syntax.Step, ...]:
        """``{ statements }``, or one statement."""
        cursor = self._cursor
        self._blocks += 1
        if self._blocks > MAX_BLOCKS:
            raise cursor.source.error(
                cursor.token.place, f"expected at most {MAX_BLOCKS} blocks in each other"
            )
        steps: list[syntax.Step] = []
        if cursor.at("{"):
            cursor.take()
            while not cursor.at("}"):
                if cursor.token.kind == "end":
                    raise cursor.unexpected("'}'", "a block is { statements }")
                steps.extend(self._step())
            cursor.take()
        else:
            steps = self._step()
        self._blocks -= 1
        return tuple(steps)

    def _if(self) -> syntax.If:
        cursor = self._cursor
        place = cursor.take().place
        cursor.expect("(", "a branch is if (condition) { … } else { … }")
        condition = self._expression(closed=True)
        cursor.expect(")", "a branch is if (condition) { … } else { … }")
        then = self._block()
        while cursor.at(";"):
            cursor.take()
        otherwise: tuple[syntax.Step, ...] = ()
        if cursor.named("else"):
            cursor.take()
            otherwise = self._block()
        return syntax.If(place, condition, then, otherwise)

    def _loop(self) -> syntax.Loop:
        """A loop, with the rounds of the pragma between it and what comes before it."""
        cursor = self._cursor
        before = cursor.before
        place = cursor.take().place
        said = [
            pragma.rounds
            for pragma in self._unrolled
            if pragma.place < place and (before is None or before.place < pragma.place)
        ]
        self._loops += 1
        body = self._block()
        self._loops -= 1
        return syntax.Loop(place, body, said[-1] if said else 0)

    def _for_the_screen(self) -> list[syntax.Step] | None:
        """What only draws, if that is what comes next."""
        cursor = self._cursor
        drawn = cursor.at(":")
        place, word = cursor.token.place, cursor.following.text
        if cursor.token.text == "_BGColor" and word == "=":
            cursor.take()
            cursor.take()
        elif drawn and word in _SCREEN and not _BINARY.fullmatch(cursor.second.text):
            cursor.take()
            cursor.take()
            if cursor.at(";"):
                cursor.take()
            return self._kept(syntax.Screen(place, word, None))
        elif drawn and not cursor.named_next(";", "=") and word != ":":
            cursor.take()
        else:
            return None
        value = self._expression()
        self._end_drawn()
        word = value.name if isinstance(value, syntax.Call) and value.name == "Color" else ""
        return self._kept(syntax.Screen(place, word, value)) if drawn else []

    def _kept(self, screen: syntax.Screen) -> list[syntax.Step]:
        return [] if self._in_macro else [screen]

    def _end_drawn(self) -> None:
        """Read the end of a statement, and the colours and styles that CLUCalc takes behind it."""
        cursor = self._cursor
        before = cursor.before
        while (
            cursor.at(":") and before is not None and cursor.token.place.line == before.place.line
        ):
            cursor.clucalc = True
            cursor.take()
            self._expression()
        cursor.end_statement()

    def _assigned(self) -> list[syntax.Step]:
        cursor = self._cursor
        mark = cursor.take().text if any(map(cursor.at, _MARKS)) else ""
        named = cursor.token.kind == "name" and cursor.token.text != "_P"
        ends = cursor.following.kind in ("name", "end") or cursor.following.text in _MARKS
        if not named or not (ends or cursor.following.text in ("=", ";", "->", "}")):
            return self._unnamed(mark)
        name = cursor.take()
        said = name.text.removeprefix("::")
        if mark and cursor.at_end:
            self._end_drawn()
            return [syntax.Mark(name.place, mark, said)]
        if cursor.clucalc and cursor.at(";"):
            return []
        refers = cursor.at("->")
        cursor.clucalc |= refers
        if refers:
            cursor.take()
        else:
            cursor.expect("=", _HINTS.get(said, _USUAL))
        if cursor.at("{"):
            raise cursor.unexpected("an expression", "a macro stands by itself and has no mark")
        said = name.text if self._in_macro else said
        if cursor.token.kind == "name" and cursor.following.text == "=":
            first = self._assigned()
            chained = syntax.Name(cursor.token.place, getattr(first[-1], "name", ""))
            return [*first, syntax.Assignment(name.place, mark, said, chained, refers)]
        value = self._expression()
        self._end_drawn()
        return [syntax.Assignment(name.place, mark, said, value, refers)]

    def _unnamed(self, mark: str) -> list[syntax.Step]:
        """A value that stands alone, as of ``f(x);``, ``?"text";`` or ``list << item;``."""
        cursor = self._cursor
        place = cursor.token.place
        if (
            cursor.token.kind not in ("name", "number", "text")
            and cursor.token.text not in "*-~!(["
        ):
            raise cursor.unexpected("a name", _USUAL)
        hint = _HINTS.get(cursor.token.text, _USUAL)
        value = self._expression()
        if cursor.at("=") and not mark and not isinstance(value, syntax.Number):
            return self._into(value)
        if not mark and isinstance(value, syntax.Number):
            raise cursor.source.error(place, "expected a name", _USUAL)
        if hint != _USUAL:
            raise cursor.unexpected("'='", hint)
        known = cursor.clucalc or isinstance(value, syntax.Call | syntax.Skipped)
        if not mark and not known and not _appends(value):
            raise cursor.unexpected("'='", _USUAL)
        cursor.clucalc = True
        self._end_drawn()
        return [_alone(place, mark, value)]

    def _into(self, target: syntax.Expression) -> list[syntax.Step]:
        """``list(place) = value;`` or ``[a, b] = list;``."""
        cursor = self._cursor
        place = target.place
        names = target.items if isinstance(target, syntax.ListOf) else ()
        item = isinstance(target, syntax.Call) and target.name and target.arguments
        if not item and not (names and all(isinstance(name, syntax.Name) for name in names)):
            raise cursor.unexpected("';'", _USUAL)
        cursor.take()
        cursor.clucalc = True
        value = self._expression()
        cursor.end_statement()
        if isinstance(target, syntax.Call):
            into = (syntax.Name(place, target.name), *target.arguments, value)
            said = target.name if self._in_macro else target.name.removeprefix("::")
            return [syntax.Assignment(place, "", said, syntax.Call(place, "=", into))]
        whole = syntax.Name(place, f"line_{place.line}_list")
        steps: list[syntax.Step] = [syntax.Assignment(place, "", whole.name, value)]
        for number, name in enumerate(names, 1):
            part = syntax.Call(place, "", (whole, syntax.Number(place, float(number))))
            steps.append(syntax.Assignment(place, "", getattr(name, "name", ""), part))
        return steps

    def _expression(self, *, closed: bool = False) -> syntax.Expression:
        value = parse_expression(self._cursor, closed=closed)
        for node in () if self._in_macro else syntax.postorder(value):
            if isinstance(node, syntax.Argument):
                raise self._cursor.source.error(
                    node.place, f"_P({node.index}) stands outside a macro", "give it a name"
                )
        return value

    def _macro(self) -> syntax.Macro:
        cursor = self._cursor
        name = cursor.take()
        cursor.take()
        cursor.take()
        self._in_macro = True
        body: list[syntax.Step] = []
        value: syntax.Expression | None = None
        while value is None and not cursor.at("}"):
            if self._at_step():
                if cursor.following.text == "=" and cursor.second.text == "{":
                    raise cursor.unexpected("an expression", "a macro holds no other macro")
                body.extend(self._step())
                continue
            value = self._expression()
            if cursor.at("="):
                body.extend(self._into(value))
                value = None
                continue
            if cursor.at(";"):
                cursor.take()
            if (cursor.clucalc and not cursor.at("}")) or (cursor.clucalc and _appends(value)):
                body.append(_alone(value.place, "", value))
                value = None
        if value is None and not cursor.clucalc:
            raise cursor.unexpected(
                "an expression", "a macro ends in the expression that it stands for"
            )
        cursor.expect("}", "a macro is name = { statements; expression }")
        self._in_macro = False
        parts = [*syntax.expressions_of(body), *([] if value is None else [value])]
        indices = [
            n.index
            for part in parts
            for n in syntax.postorder(part)
            if isinstance(n, syntax.Argument)
        ]
        said = name.text.removeprefix("::")
        return syntax.Macro(
            name.place, said, tuple(body), value, max(indices, default=0), cursor.source
        )

    def _at_step(self) -> bool:
        """Whether a statement of a macro comes next, and not yet its value."""
        cursor = self._cursor
        if cursor.at(";") or any(map(cursor.at, _MARKS)):
            return True
        if cursor.token.kind != "name" or cursor.token.text == "_P":
            return False
        if cursor.following.text in ("=", "->") or cursor.named("break"):
            return True
        return (cursor.named("if") and cursor.following.text == "(") or (
            cursor.named("loop") and cursor.following.text == "{"
        )


def _appends(value: syntax.Expression) -> bool:
    """Whether a value that stands alone is ``list << item``."""
    while isinstance(value, syntax.Binary) and value.operator == "<<":
        value = value.left
        if isinstance(value, syntax.Name):
            return True
    return False


def _alone(place: Place, mark: str, value: syntax.Expression) -> syntax.Assignment:
    """A statement without a name; what it prints is an output by the name of its line."""
    items: list[syntax.Expression] = []
    if not mark and _appends(value):
        while isinstance(value, syntax.Binary):
            items.append(value.right)
            value = value.left
        assert isinstance(value, syntax.Name)
        appended = syntax.Call(place, "<<", (value, *reversed(items)))
        return syntax.Assignment(place, "", value.name, appended)
    return syntax.Assignment(place, mark, f"line_{place.line}" if mark else "", value)


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


def parse_pragma(source: Source, token: Token) -> list[syntax.Pragma]:
    """What one pragma says: several names after ``return`` are several pragmas.

    Raises ScriptError: an unknown pragma, or one that is not written as above.
    """
    text = token.text.removeprefix("//").replace("\t", " ").replace("#spragma", "#pragma", 1)
    if text.startswith("#include"):
        kind, said = "import", text.removeprefix("#include").strip()
    else:
        kind, _, said = text.removeprefix("#pragma").strip().partition(" ")
    if kind not in _READERS:
        raise source.error(token.place, f"expected a pragma {', '.join(USES)}, got {kind[:40]!a}")
    pragma = _READERS[kind](said.strip(), token)
    if not pragma:
        raise source.error(token.place, f"this {kind} pragma cannot be read", f"write {USES[kind]}")
    return pragma


def _names(said: str) -> list[str]:
    """Names with blanks or commas between them; none where one is no name."""
    words = said.replace(",", " ").split()
    return words if all(map(_NAME.fullmatch, words)) else []


def _output(said: str, token: Token) -> list[syntax.Pragma]:
    name, *blades = said.split() or [""]
    if not _NAME.fullmatch(name) or not all(map(_BLADE.fullmatch, blades)):
        return []
    kept = tuple("1" if blade.startswith("1") else blade for blade in blades)
    return [syntax.OutputPragma(token.place, name, kept)]


def _return(said: str, token: Token) -> list[syntax.Pragma]:
    names, *shaped = re.split(r"\s+typed\s+|\s+as\s+|\s+(?=[A-Za-z_0-9]+\()", said)
    pragmas: list[syntax.Pragma] = [
        syntax.OutputPragma(token.place, name, ()) for name in _names(names)
    ]
    if pragmas and shaped:
        pragmas.append(
            syntax.LeftOutPragma(token.place, "outputs are multivectors: typed … as is left out")
        )
    return pragmas


def _in2out(said: str, token: Token) -> list[syntax.Pragma]:
    before, arrow, after = said.partition("->")
    inputs, outputs = _names(before), _names(after)
    if not arrow or not outputs or (before.strip() and not inputs):
        return []
    return [
        *(syntax.InputPragma(token.place, name) for name in inputs),
        *(syntax.OutputPragma(token.place, name, (), leads=True) for name in outputs),
    ]


def _range(said: str, token: Token) -> list[syntax.Pragma]:
    match = _RANGE.fullmatch(said)
    if match is None:
        return []
    low, high = float(match[1]), float(match[3])
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        return []
    return [syntax.RangePragma(token.place, low, match[2], high)]


def _algebra_pragma(said: str, token: Token) -> list[syntax.Pragma]:
    words = said.split()
    if len(words) == 3 and all(re.fullmatch("[0-9]{1,2}", word) for word in words):
        p, q, r = (int(word) for word in words)
        return [syntax.AlgebraPragma(token.place, "", (p, q, r))]
    file = _FILE.fullmatch(said)
    if file is None or len(words) != 1:
        return []
    name = file[1] if file[1].endswith(".toml") else file[1].lower()
    return [syntax.AlgebraPragma(token.place, name, (0, 0, 0))]


def _import(said: str, token: Token) -> list[syntax.Pragma]:
    file = _FILE.fullmatch(said)
    return [] if file is None else [syntax.ImportPragma(token.place, file[1])]


def _unroll(said: str, token: Token) -> list[syntax.Pragma]:
    whole = re.fullmatch("[0-9]{1,4}", said)
    if whole is None or not 1 <= int(said) <= MAX_ROUNDS:
        return []
    return [syntax.UnrollPragma(token.place, int(said))]


def _normalize(said: str, token: Token) -> list[syntax.Pragma]:
    return [] if said else [syntax.NormalizePragma(token.place)]


def _left_out(why: str) -> Callable[[str, Token], list[syntax.Pragma]]:
    return lambda said, token: [syntax.LeftOutPragma(token.place, why)] if said else []


def _evaluated(said: str, token: Token) -> list[syntax.Pragma]:
    return [syntax.LeftOutPragma(token.place, "")] if _names(said) else []


_READERS: dict[str, Callable[[str, Token], list[syntax.Pragma]]] = {
    "output": _output,
    "return": _return,
    "in2out": _in2out,
    "range": _range,
    "algebra": _algebra_pragma,
    "import": _import,
    "unroll": _unroll,
    "count": _unroll,
    "normalize": _normalize,
    "onlyEvaluate": _evaluated,
    "insert": _left_out("no text of a script goes into code: insert is left out"),
    "segments": _left_out(""),
    "triangles": _left_out(""),
}
