"""ScriptError: what is wrong with a script, and where; ScriptWarning: what it says in vain.

Lines and columns count from 1, columns in characters. The message shows the line with a caret
under the column, and a hint where there is something to do. A file of macros that a script imports
is named below the script's own folder, by plain names: no path leads out of it. Each file is read
once, however often it is named.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from motorcade.ga.files import FileError, read_bounded

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


MAX_IMPORTED_BYTES = 1_000_000
MAX_IMPORTS = 32
MAX_IMPORT_DEPTH = 8


def path_below(folder: Path | None, file: str) -> Path:
    """Where a file lies that is named below a folder.

    Raises:
        ValueError: no folder, or a path that leads out of it.
    """
    if folder is None:
        raise ValueError(f"{file}: only a script that is read from a file names others")
    path = folder / file
    if ".." in Path(file).parts or not path.resolve().is_relative_to(folder.resolve()):
        raise ValueError(f"{file}: expected a file below the folder of what names it")
    return path


def text_of(path: Path, data: bytes) -> str:
    """The text of a file.

    Raises:
        FileError: it is no UTF-8.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as refused:
        raise FileError(path, f"expected UTF-8 text at offset {refused.start}") from refused


class Imports:
    """The files that one script has imported so far, and those that are being read now."""

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        self._read: set[str] = set()
        self._depth = 0

    @contextmanager
    def opened(self, source: Source, place: Place, name: str) -> Iterator[Source | None]:
        """The text that an import names; None if it has been read.

        Raises ScriptError: a file that cannot be read, too many, or too deep in each other.
        """
        if name in self._read:
            yield None
            return
        self._read.add(name)
        if len(self._read) > MAX_IMPORTS or self._depth >= MAX_IMPORT_DEPTH:
            raise source.error(
                place,
                f"expected at most {MAX_IMPORTS} imports, {MAX_IMPORT_DEPTH} in each other",
            )
        try:
            path = path_below(self.folder, name)
            text = text_of(path, read_bounded(path, MAX_IMPORTED_BYTES))
        except ValueError as refused:
            raise source.error(place, str(refused)) from refused
        self._depth += 1
        try:
            yield Source(text, str(path))
        finally:
            self._depth -= 1
