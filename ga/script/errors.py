"""ScriptError: what is wrong with a script, and where; ScriptWarning: what it says in vain.

Lines and columns count from 1, columns in characters. The message shows the line with a caret
under the column, and a hint where there is something to do.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

_WINDOW = 100


class Place(NamedTuple):
    """Where something stands in a script, from 1."""

    line: int
    column: int


class ScriptError(ValueError):
    """A script that cannot be read or evaluated.

    Attributes: `message`, `file`, `line`, `column`, `source_line` and `hint` (may be empty).

    >>> from motorcade.ga.script import parse
    >>> parse("?a = (1;", "mine.clu")
    Traceback (most recent call last):
    ...
    motorcade.ga.script.errors.ScriptError: mine.clu:1:8: expected an operator or ')', got ';'
    ...
    """

    def __init__(
        self, message: str, file: str, line: int, column: int, source_line: str, hint: str = ""
    ) -> None:
        super().__init__(message, file, line, column, source_line, hint)
        self.message = message
        self.file = file
        self.line = line
        self.column = column
        self.source_line = source_line
        self.hint = hint

    def __str__(self) -> str:
        shown, column = _window(self.source_line, self.column)
        lead = "".join("\t" if letter == "\t" else " " for letter in shown[: column - 1])
        lines = [
            f"{self.file}:{self.line}:{self.column}: {self.message}",
            f"    {shown}",
            f"    {lead}^",
        ]
        return "\n".join([*lines, f"hint: {self.hint}"] if self.hint else lines)


class ScriptWarning(UserWarning):
    """What a script says that is left out, or means less here than where it comes from."""


class Source:
    """A script's text under its file name: makes errors that show the line."""

    __slots__ = ("_lines", "file", "text")

    def __init__(self, text: str, file: str) -> None:
        self.text = text
        self.file = file
        self._lines = text.split("\n")

    def error(self, place: Place, message: str, hint: str = "") -> ScriptError:
        """The error to raise for what stands at a place."""
        line = self._lines[place.line - 1].rstrip("\r")
        return ScriptError(message, self.file, place.line, place.column, line, hint)

    def warn(self, place: Place, message: str) -> None:
        """Warn of what stands at a place, as ``file:line:column: message``."""
        where = f"{self.file}:{place.line}:{place.column}"
        warnings.warn(ScriptWarning(f"{where}: {message}"), stacklevel=2)


def _window(line: str, column: int) -> tuple[str, int]:
    """A long line's part around a column, and the column in it."""
    if len(line) <= _WINDOW:
        return line, column
    start = max(0, min(column - _WINDOW // 2, len(line) - _WINDOW))
    return line[start : start + _WINDOW], column - start
