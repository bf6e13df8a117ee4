"""Parser of CLUScript: statements and macros around `expressions`, with the `pragmas`.

A statement is ``name = expression;`` or, with a mark, ``?name = expression;`` or ``?name;``:
``?`` output, ``!`` evaluate, ``:`` draw. The end of a line ends it too. A macro is ``name = {
statements; expression }``; its arguments are ``_P(1)``, ``_P(2)``, … Macros do not nest. There are
``if (condition) { … } else { … }`` and ``loop { … break; … }``. What CLUCalc and Gaalop write for
the screen is a statement too: ``:IPNS;``, ``:Red;``, ``:a^b;``; in macros, and as
``_BGColor = White;``, it is read and left out. ``DefVarsN3();`` is the pragma of its algebra.
"""

from __future__ import annotations

from pathlib import Path

from motorcade.ga.script.errors import Source
from motorcade.ga.script.reading.expressions import Cursor, parse_expression
from motorcade.ga.script.reading.imports import Imports
from motorcade.ga.script.reading.lexer import Token, tokenize
from motorcade.ga.script.reading.pragmas import parse_pragma
from motorcade.ga.script.reading.syntax import (
    AlgebraPragma,
    Argument,
    Assignment,
    Break,
    Call,
    Expression,
    If,
    ImportPragma,
    LeftOutPragma,
    Loop,
    Macro,
    Mark,
    Pragma,
    Screen,
    Script,
    Statement,
    Step,
    UnrollPragma,
    expressions_of,
    postorder,
)

MAX_BLOCKS = 20
_MARKS = ("?", "!", ":")
_COLOURS = ("Black", "Blue", "Cyan", "Green", "Magenta", "Orange", "Red", "White", "Yellow")
_SCREEN = frozenset(["IPNS", "OPNS", *_COLOURS])
_ALGEBRAS = {"DefVarsE3": "ega3", "DefVarsN3": "cga3"}
_HINTS = {
    **dict.fromkeys(("for", "while"), "a loop is written loop { … if (…) { break; } … }"),
    **dict.fromkeys(("DefVarsP3", "DefVarsC2"), "write #pragma algebra P Q R"),
}
_USUAL = "a statement is name = expression; or ?name;"


def parse(text: str, file: str = "<script>", folder: Path | None = None) -> Script:
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


def _parsed(source: Source, folder: Path | None, imports: Imports) -> Script:
    tokens = tokenize(source)
    pragmas: list[Pragma] = []
    macros: list[Macro] = []
    for token in tokens:
        if token.kind == "pragma":
            pragmas.extend(parse_pragma(source, token))
    for pragma in pragmas:
        if isinstance(pragma, ImportPragma):
            macros.extend(_imported(source, pragma, imports))
        elif isinstance(pragma, LeftOutPragma) and pragma.why:
            source.warn(pragma.place, pragma.why)
    cursor = Cursor(source, [token for token in tokens if token.kind != "pragma"])
    reader = _Statements(cursor, pragmas)
    statements = (*macros, *reader.read())
    return Script(source, statements, tuple(pragmas), folder)


def _imported(source: Source, pragma: ImportPragma, imports: Imports) -> list[Macro]:
    """The macros of a file, and of those that it imports."""
    made: list[Macro] = []
    with imports.opened(source, pragma) as found:
        if found is None:
            return []
        script = _parsed(found, imports.folder, imports)
        for statement in script.statements:
            if isinstance(statement, Macro):
                made.append(statement)
            elif not isinstance(statement, Screen):
                raise found.error(
                    statement.place, "expected macros alone in a file that is imported"
                )
    return made


class _Statements:
    """Reads the statements of one text."""

    def __init__(self, cursor: Cursor, pragmas: list[Pragma]) -> None:
        self._cursor = cursor
        self._pragmas = pragmas
        self._unrolled = [p for p in pragmas if isinstance(p, UnrollPragma)]
        self._in_macro = False
        self._blocks = 0
        self._loops = 0

    def read(self) -> list[Statement]:
        """All statements of the text."""
        cursor = self._cursor
        made: list[Statement] = []
        while cursor.token.kind != "end":
            if cursor.token.text in _ALGEBRAS and cursor.following.text == "(":
                self._pragmas.append(_algebra(cursor))
            elif cursor.token.kind == "name" and self._opens_macro():
                made.append(self._macro())
            else:
                made.extend(self._step())
        return made

    def _opens_macro(self) -> bool:
        return self._cursor.following.text == "=" and self._cursor.second.text == "{"

    def _step(self) -> list[Step]:
        """The next statement, if it is one."""
        cursor = self._cursor
        if cursor.at(";"):
            cursor.take()
            return []
        drawn = self._for_the_screen()
        if drawn is not None:
            return drawn
        if cursor.token.kind == "name" and cursor.following.text == "(" and cursor.named("if"):
            return [self._if()]
        if cursor.named("loop") and cursor.following.text == "{":
            return [self._loop()]
        if cursor.named("break") and cursor.following.text != "=":
            place = cursor.take().place
            if not self._loops:
                raise cursor.source.error(place, "expected a break inside a loop")
            cursor.end_statement()
            return [Break(place)]
        return [self._assigned()]

    def _block(self) -> tuple[Step, ...]:
        """``{ statements }``, or one statement."""
        cursor = self._cursor
        self._blocks += 1
        if self._blocks > MAX_BLOCKS:
            raise cursor.source.error(
                cursor.token.place, f"expected at most {MAX_BLOCKS} blocks in each other"
            )
        made: list[Step] = []
        if cursor.at("{"):
            cursor.take()
            while not cursor.at("}"):
                if cursor.token.kind == "end":
                    raise cursor.unexpected("'}'", "a block is { statements }")
                made.extend(self._step())
            cursor.take()
        else:
            made = self._step()
        self._blocks -= 1
        return tuple(made)

    def _if(self) -> If:
        cursor = self._cursor
        place = cursor.take().place
        cursor.expect("(", "a branch is if (condition) { … } else { … }")
        condition = self._expression(closed=True)
        cursor.expect(")", "a branch is if (condition) { … } else { … }")
        then = self._block()
        while cursor.at(";"):
            cursor.take()
        otherwise: tuple[Step, ...] = ()
        if cursor.named("else"):
            cursor.take()
            otherwise = self._block()
        return If(place, condition, then, otherwise)

    def _loop(self) -> Loop:
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
        return Loop(place, body, said[-1] if said else 0)

    def _for_the_screen(self) -> list[Step] | None:
        """What only draws, if that is what comes next."""
        cursor = self._cursor
        drawn = cursor.at(":")
        place, word = cursor.token.place, cursor.following.text
        if cursor.token.text == "_BGColor" and word == "=":
            cursor.take()
            cursor.take()
        elif drawn and word in _SCREEN:
            cursor.take()
            cursor.take()
            if cursor.at(";"):
                cursor.take()
            return self._kept(Screen(place, word, None))
        elif drawn and not cursor.named_next(";", "=") and word != ":":
            cursor.take()
        else:
            return None
        value = self._expression()
        cursor.end_statement()
        word = value.name if isinstance(value, Call) and value.name == "Color" else ""
        return self._kept(Screen(place, word, value)) if drawn else []

    def _kept(self, screen: Screen) -> list[Step]:
        return [] if self._in_macro else [screen]

    def _assigned(self) -> Assignment | Mark:
        cursor = self._cursor
        mark = cursor.take().text if any(map(cursor.at, _MARKS)) else ""
        if cursor.token.kind != "name" or cursor.token.text == "_P":
            raise cursor.unexpected("a name", _USUAL)
        name = cursor.take()
        said = name.text.removeprefix("::")
        if mark and cursor.at_end:
            cursor.end_statement()
            return Mark(name.place, mark, said)
        cursor.expect("=", _HINTS.get(said, _USUAL))
        if cursor.at("{"):
            raise cursor.unexpected("an expression", "a macro stands by itself and has no mark")
        if self._in_macro and name.text != said:
            raise cursor.source.error(
                name.place, f"a macro reads {name.text}, and assigns names of its own alone"
            )
        value = self._expression()
        cursor.end_statement()
        return Assignment(name.place, mark, said, value)

    def _expression(self, *, closed: bool = False) -> Expression:
        value = parse_expression(self._cursor, closed=closed)
        for node in () if self._in_macro else postorder(value):
            if isinstance(node, Argument):
                raise self._cursor.source.error(
                    node.place, f"_P({node.index}) stands outside a macro", "give it a name"
                )
        return value

    def _macro(self) -> Macro:
        cursor = self._cursor
        name = cursor.take()
        cursor.take()
        cursor.take()
        self._in_macro = True
        body: list[Step] = []
        while self._at_step():
            if cursor.following.text == "=" and cursor.second.text == "{":
                raise cursor.unexpected("an expression", "a macro holds no other macro")
            body.extend(self._step())
        if cursor.at("}"):
            raise cursor.unexpected(
                "an expression", "a macro ends in the expression that it stands for"
            )
        value = self._expression()
        if cursor.at(";"):
            cursor.take()
        cursor.expect("}", "a macro is name = { statements; expression }")
        self._in_macro = False
        parts = [*expressions_of(body), value]
        indices = [n.index for part in parts for n in postorder(part) if isinstance(n, Argument)]
        said = name.text.removeprefix("::")
        return Macro(name.place, said, tuple(body), value, max(indices, default=0), cursor.source)

    def _at_step(self) -> bool:
        """Whether a statement of a macro comes next, and not yet its value."""
        cursor = self._cursor
        if cursor.at(";") or any(map(cursor.at, _MARKS)):
            return True
        if cursor.token.kind != "name" or cursor.token.text == "_P":
            return False
        if cursor.following.text == "=" or cursor.named("break"):
            return True
        return (cursor.named("if") and cursor.following.text == "(") or (
            cursor.named("loop") and cursor.following.text == "{"
        )


def _algebra(cursor: Cursor) -> AlgebraPragma:
    """``DefVarsN3();``"""
    name: Token = cursor.take()
    for symbol in "();":
        cursor.expect(symbol, f"write {name.text}();")
    return AlgebraPragma(name.place, _ALGEBRAS[name.text], (0, 0, 0))
