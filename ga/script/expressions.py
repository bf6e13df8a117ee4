"""Expressions of CLUScript by operator precedence, on a stack of its own.

Tightest first: brackets, calls and slices ``x[e1, e2]``, the prefixes ``*`` dual, ``~`` reverse,
``-``, ``!`` inverse and ``!!`` not, the remainder ``%``, then ``^`` with ``&``, ``.`` with ``<<``
and ``>>``, ``/``, ``*``, then ``-`` and ``+`` together, comparisons, ``==`` and ``!=``, ``&&``,
``||``. All binary operators group to the left, so ``a - b + c`` is ``(a - b) + c``. Nesting is
limited, and never costs the caller's own stack.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from motorcade.ga.script import syntax
from motorcade.ga.script.errors import Place, ScriptError, Source
from motorcade.ga.script.syntax import Token

MAX_NESTING = 200
MAX_ARGUMENTS = 100
MAX_OPERATIONS = 20_000

_TIGHTEST_LAST = ("||", "&&", "== !=", "< <= > >=", "- +", "*", "/", ". << >>", "^ &", "%")
_BINDING = {
    operator: binding
    for binding, together in enumerate(_TIGHTEST_LAST, 1)
    for operator in together.split()
}
_PREFIXES = frozenset(["*", "~", "-", "!!", "!"])
_PREFIX_BINDING = 11
# What only draws in CLUCalc, or sets up its windows, textures, lights and tools.
_DRAWS = re.compile(
    r"(?:Read|Write|Copy|Resize|Reshape|Insert|GetLatex)Img|GetImgCoords|Img2Matrix|Matrix2Img|"
    r"Draw\w+|Set[A-Z]\w*|Enable[A-Z]\w*|(?:Start|End)(?:Overlay|View)|(?:Push|Pop)Frame|Plot|Offset"
    r"|DefVars(?:E3|P3|N3|C2)|(?:Rotate|Translate|Scale)(?:Frame|View)|Button|_AddScriptToList|_ClearScriptList|Title"
)


_SLICED = "x[e1, e2^e3] is the part of x on these blades, coefficient(x, e1) one coefficient"


class Cursor:
    """The tokens of a script and how far they are read."""

    def __init__(self, source: Source, tokens: list[Token]) -> None:
        self.source = source
        self.operations = 0
        self.clucalc = False
        self.macros: set[str] = set()
        self._named: set[str] = set()
        self._tokens = tokens
        self._next = 0

    @property
    def token(self) -> Token:
        """The next token."""
        return self._tokens[self._next]

    @property
    def following(self) -> Token:
        """The token after the next one."""
        return self._tokens[min(self._next + 1, len(self._tokens) - 1)]

    @property
    def second(self) -> Token:
        """The token after `following`."""
        return self._tokens[min(self._next + 2, len(self._tokens) - 1)]

    def named(self, word: str) -> bool:
        """Whether the next token is this name."""
        return self.token.kind == "name" and self.token.text == word

    @property
    def before(self) -> Token | None:
        """The token that was read last."""
        return self._tokens[self._next - 1] if self._next else None

    def named_next(self, *symbols: str) -> bool:
        """Whether a name and then one of these symbols follow the next token."""
        return self.following.kind == "name" and self.second.text in symbols

    def take(self) -> Token:
        """Read one token; the end is never passed."""
        token = self.token
        self._next = min(self._next + 1, len(self._tokens) - 1)
        return token

    def at(self, symbol: str) -> bool:
        """Whether the next token is this symbol."""
        return self.token.kind == "symbol" and self.token.text == symbol

    def expect(self, symbol: str, hint: str = "") -> Token:
        """Read this symbol. Raises ScriptError: another token."""
        if not self.at(symbol):
            raise self.unexpected(f"'{symbol}'", hint)
        return self.take()

    @property
    def at_end(self) -> bool:
        """Whether a statement ends here: at ``;``, or where the next one begins on a later line."""
        token, before = self.token, self.before
        below = before is not None and token.place.line > before.place.line
        begins = token.kind in ("name", "end") or token.text in ("}", "?", "!", ":")
        return self.at(";") or (below and begins)

    def end_statement(self) -> None:
        """Read the ``;`` of a statement, which the end of its line may stand for.

        Raises ScriptError: something else follows.
        """
        if not self.at_end:
            raise self.unexpected("';'", "every statement ends in ';'")
        if self.at(";"):
            self.take()

    def draws(self, name: str) -> bool:
        """Whether a call only draws in CLUCalc, and no macro of the script has its name."""
        return name not in self.macros and _DRAWS.fullmatch(name) is not None

    def skip(self, call: _Pending, arguments: tuple[syntax.Expression, ...]) -> syntax.Skipped:
        """Leave out a call that only draws, and name it once."""
        self.clucalc = True
        if call.text not in self._named and not call.text.startswith("DefVars"):
            self._named.add(call.text)
            self.source.warn(call.place, f"{call.text} is for CLUCalc's window: skipped")
        drawn = arguments if call.text.startswith("Draw") else ()
        return syntax.Skipped(call.place, call.text, drawn)

    def unexpected(self, expected: str, hint: str = "") -> ScriptError:
        """The error of a token that cannot come next."""
        return self.source.error(
            self.token.place, f"expected {expected}, got {_named(self.token)}", hint
        )

    def count_operation(self, place: Place) -> None:
        """Count one operation of the script. Raises ScriptError: too many."""
        self.operations += 1
        if self.operations > MAX_OPERATIONS:
            raise self.source.error(
                place, f"expected at most {MAX_OPERATIONS} operations", "split the script"
            )


def _named(token: Token) -> str:
    if token.kind == "end":
        return "the end of the script"
    shown = token.text if len(token.text) <= 40 else f"{token.text[:37]}..."
    return f"'{shown}'"


@dataclass(frozen=True, slots=True)
class _Pending:
    """What waits for its right side: an operator, or an open bracket (`binding` 0)."""

    place: Place
    text: str
    binding: int
    operands_below: int


class _Reader:
    """Reads one expression: operands and what waits for them, on two stacks."""

    def __init__(self, cursor: Cursor, closed: bool) -> None:
        self._cursor = cursor
        self._closed = closed
        self._operands: list[syntax.Expression] = []
        self._pending: list[_Pending] = []
        self._nesting = 0

    def read(self) -> syntax.Expression:
        while True:
            self._read_operand()
            if not self._read_operator():
                break
        self._reduce(1)
        if self._pending:
            opened = self._pending[-1].place
            raise self._cursor.unexpected(
                "an operator or ')'", f"the bracket at {opened.line}:{opened.column} is open"
            )
        return self._operands.pop()

    def _read_operand(self) -> None:
        """Prefixes and opening brackets up to and with the next operand."""
        cursor = self._cursor
        while True:
            token = cursor.token
            if token.kind == "symbol" and token.text in _PREFIXES:
                self._push(cursor.take(), _PREFIX_BINDING)
            elif cursor.at("(") or cursor.at("["):
                self._push(cursor.take(), 0)
                cursor.clucalc |= token.text == "["
                if token.text == "[" and cursor.at("]"):
                    self._close(cursor.take(), empty=True)
                    return
            elif token.kind == "name" and cursor.following.text == "(" and token.text != "_P":
                self._push(cursor.take(), 0)
                cursor.take()
                if cursor.at(")"):
                    self._close(cursor.take(), empty=True)
                    return
            else:
                self._operands.append(self._leaf())
                return

    def _leaf(self) -> syntax.Expression:
        cursor = self._cursor
        token = cursor.token
        if token.kind == "number":
            return syntax.Number(cursor.take().place, float(token.text))
        if token.kind == "text":
            cursor.clucalc = True
            return syntax.Text(cursor.take().place, re.sub(r"\\(.)", r"\1", token.text[1:-1]))
        if token.kind != "name":
            hint = "" if token.kind != "symbol" else "an operand is a name, a number or a bracket"
            raise cursor.unexpected("an expression", hint)
        cursor.take()
        return (
            _argument(cursor, token) if token.text == "_P" else syntax.Name(token.place, token.text)
        )

    def _read_operator(self) -> bool:
        """Closing brackets up to and with the next operator or comma; False at the end."""
        cursor = self._cursor
        while True:
            token = cursor.token
            binding = _BINDING.get(token.text) if token.kind == "symbol" else None
            if cursor.at("[") and not isinstance(self._operands[-1], syntax.ListOf):
                self._operands.append(_slice(cursor, self._operands.pop()))
                continue
            if cursor.at("("):
                self._push(Token("symbol", "", cursor.take().place), 0, below=1)
                cursor.clucalc = True
                if cursor.at(")"):
                    self._close(cursor.take())
                    continue
                return True
            if binding is not None:
                self._reduce(binding)
                self._pending.append(_Pending(cursor.take().place, token.text, binding, 0))
                self._warn_of_powers(token)
                return True
            if cursor.at("=") and self._nesting and isinstance(self._operands[-1], syntax.Name):
                self._pending.append(_Pending(cursor.take().place, "=", 1, 0))
                cursor.clucalc = True
                return True
            if not any(map(cursor.at, ",)][")):
                return False
            self._reduce(1)
            if not self._pending and self._closed and cursor.at(")"):
                return False
            if not self._pending:
                raise cursor.unexpected("an operator or ';'", "no bracket is open here")
            if cursor.at(",") or cursor.at("["):
                self._next_argument()
                return True
            if cursor.at("]") != (self._pending[-1].text == "["):
                raise cursor.unexpected("')'" if cursor.at("]") else "']'")
            self._close(cursor.take())

    def _warn_of_powers(self, operator: Token) -> None:
        """Warn of what other languages mean a power by: ``x^2`` is 2 x, ``x**2`` x times a dual."""
        cursor, (line, column) = self._cursor, operator.place
        if cursor.token.place != (line, column + 1):
            return  # with a blank between them it is written as what it is
        if operator.text == "^" and cursor.token.kind == "number":
            what = "an outer product, with a number no more than a factor"
        elif operator.text == "*" and cursor.at("*"):
            what = "a product with a dual"
        else:
            return
        cursor.source.warn(
            operator.place, f"{what}; there are no powers: write x*x, or exp and log"
        )

    def _next_argument(self) -> None:
        opened = self._pending[-1]
        if opened.text == "(":
            raise self._cursor.unexpected("')'", "only a call has several arguments")
        if len(self._operands) - opened.operands_below >= MAX_ARGUMENTS:
            raise self._cursor.unexpected(f"at most {MAX_ARGUMENTS} arguments")
        if not self._cursor.at("["):
            self._cursor.take()

    def _push(self, token: Token, binding: int, below: int = 0) -> None:
        self._nesting += 1
        if self._nesting > MAX_NESTING:
            raise self._cursor.source.error(
                token.place,
                f"expected at most {MAX_NESTING} levels of nesting",
                "give parts of the expression names of their own",
            )
        operands = len(self._operands) - below
        self._pending.append(_Pending(token.place, token.text, binding, operands))

    def _close(self, bracket: Token, *, empty: bool = False) -> None:
        opened = self._pending.pop()
        self._nesting -= 1
        if opened.text == "(":
            return
        arguments = () if empty else tuple(self._operands[opened.operands_below :])
        del self._operands[opened.operands_below :]
        self._cursor.count_operation(bracket.place)
        if opened.text == "[":
            self._operands.append(syntax.ListOf(opened.place, arguments))
        elif self._cursor.draws(opened.text):
            self._operands.append(self._cursor.skip(opened, arguments))
        else:
            self._operands.append(syntax.Call(opened.place, opened.text, arguments))

    def _reduce(self, binding: int) -> None:
        """Build what binds at least as tightly, down to the last open bracket."""
        while self._pending and self._pending[-1].binding >= binding:
            waiting = self._pending.pop()
            self._cursor.count_operation(waiting.place)
            right = self._operands.pop()
            if waiting.binding == _PREFIX_BINDING:
                self._nesting -= 1
                self._operands.append(syntax.Unary(waiting.place, waiting.text, right))
            else:
                left = self._operands.pop()
                if waiting.text == "=" and isinstance(left, syntax.Name):
                    named = syntax.Text(left.place, left.name)
                    self._operands.append(syntax.Call(waiting.place, ":=", (named, right)))
                    continue
                self._operands.append(syntax.Binary(waiting.place, waiting.text, left, right))


def parse_expression(cursor: Cursor, *, closed: bool = False) -> syntax.Expression:
    """Read one expression and stop before the token that ends it; `closed`: a bracket may.

    Raises ScriptError: no expression, a bracket left open, too deep or too long a one.
    """
    return _Reader(cursor, closed).read()


def _slice(cursor: Cursor, operand: syntax.Expression) -> syntax.Slice:
    """The rest of ``x[e1, e2^e3]``."""
    opened = cursor.take()
    cursor.count_operation(opened.place)
    blades: list[str] = []
    while not blades or cursor.at(","):
        if blades:
            cursor.take()
        if len(blades) >= MAX_ARGUMENTS:
            raise cursor.unexpected(f"at most {MAX_ARGUMENTS} blades")
        blades.append(_blade(cursor))
    cursor.expect("]", _SLICED)
    return syntax.Slice(opened.place, operand, tuple(blades))


def _blade(cursor: Cursor) -> str:
    if cursor.token.kind == "number" and float(cursor.token.text) == 1.0:
        cursor.take()
        return "1"
    factors: list[str] = []
    while not factors or cursor.at("^"):
        if factors:
            cursor.take()
        if cursor.token.kind != "name":
            raise cursor.unexpected("the name of a blade", _SLICED)
        factors.append(cursor.take().text)
    return "^".join(factors)


def _argument(cursor: Cursor, name: Token) -> syntax.Argument:
    """The rest of ``_P(1)``; without a number it is the list of all."""
    hint = "a macro's arguments are _P(1), _P(2), …"
    if not cursor.at("(") and not cursor.at("["):
        cursor.clucalc = True
        return syntax.Argument(name.place, 0)
    closing = ")" if cursor.take().text == "(" else "]"
    token = cursor.token
    whole = token.kind == "number" and token.text.isdigit() and len(token.text) <= 4
    if not whole or not 1 <= int(token.text) <= MAX_ARGUMENTS:
        raise cursor.unexpected(f"a whole number from 1 to {MAX_ARGUMENTS}", hint)
    cursor.take()
    cursor.expect(closing, hint)
    return syntax.Argument(name.place, int(token.text))
