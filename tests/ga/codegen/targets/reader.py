"""Reads generated text back: a small evaluator of expressions over arrays, for WGSL and Julia.

It knows nothing of the writers: operators and their precedence are those that both languages share.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[ef][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<symbol>\|\||&&|[<>=!]=|[-+*/<>!(),]))"
)
BINARY: dict[str, tuple[int, Callable[..., Any]]] = {
    "||": (1, np.logical_or), "&&": (2, np.logical_and), "==": (3, np.equal),
    "!=": (3, np.not_equal), "<": (3, np.less), "<=": (3, np.less_equal), "+": (4, np.add),
    "-": (4, np.subtract), "*": (5, np.multiply), "/": (5, np.divide),
}  # fmt: skip


class Expressions:
    """Evaluates expressions; `functions` are what a language calls, by its names."""

    def __init__(self, functions: Mapping[str, Callable[..., Any]]) -> None:
        self._functions = functions
        self._tokens: list[str] = []

    def value(self, text: str, names: Mapping[str, Any]) -> Any:
        """The value of one expression."""
        (made,) = self.values(text, names)
        return made

    def values(self, text: str, names: Mapping[str, Any]) -> list[Any]:
        """The values of a list of expressions, which may end in a comma."""
        self._tokens = [m[m.lastgroup or 0] for m in TOKEN.finditer(text)]
        assert "".join(self._tokens) == re.sub(r"\s", "", text), "a sign that is no token"
        made = []
        while self._tokens:
            made.append(self._binary(0, names))
            assert not self._tokens or self._tokens.pop(0) == ","
        return made

    def _binary(self, least: int, names: Mapping[str, Any]) -> Any:
        left = self._unary(names)
        while self._tokens and BINARY.get(self._tokens[0], (0, None))[0] > least:
            level, operation = BINARY[self._tokens.pop(0)]
            left = operation(left, self._binary(level, names))
        return left

    def _unary(self, names: Mapping[str, Any]) -> Any:
        token = self._tokens.pop(0)
        if token == "-":
            return -self._unary(names)
        if token == "!":
            return np.logical_not(self._unary(names))
        if token == "(":
            made = self._binary(0, names)
            assert self._tokens.pop(0) == ")"
            return made
        if re.fullmatch(r"[\d.].*", token):
            return float(token.replace("f", "e"))
        if self._tokens and self._tokens[0] == "(":
            return self._functions[token](*self._arguments(names))
        return names[token]

    def _arguments(self, names: Mapping[str, Any]) -> list[Any]:
        made, following = [], self._tokens.pop(0)
        while following != ")":
            made.append(self._binary(0, names))
            following = self._tokens.pop(0)
            assert following in ",)"
        return made
