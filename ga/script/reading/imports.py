"""Files of macros that a script imports: where they may lie, and how many there may be.

A file is named below the script's own folder, by plain names: no path leads out of it. Each file is
read once, however often it is named.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from motorcade.ga.files import FileError, read_bounded
from motorcade.ga.script.errors import Source
from motorcade.ga.script.reading.syntax import ImportPragma

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
    def opened(self, source: Source, pragma: ImportPragma) -> Iterator[Source | None]:
        """The text that an import names; None if it has been read.

        Raises:
            ScriptError: a file that cannot be read, too many, or too deep in each other.
        """
        if pragma.file in self._read:
            yield None
            return
        self._read.add(pragma.file)
        if len(self._read) > MAX_IMPORTS or self._depth >= MAX_IMPORT_DEPTH:
            raise source.error(
                pragma.place,
                f"expected at most {MAX_IMPORTS} imports, {MAX_IMPORT_DEPTH} in each other",
            )
        try:
            path = path_below(self.folder, pragma.file)
            text = text_of(path, read_bounded(path, MAX_IMPORTED_BYTES))
        except ValueError as refused:
            raise source.error(pragma.place, str(refused)) from refused
        self._depth += 1
        try:
            yield Source(text, str(path))
        finally:
            self._depth -= 1
