"""What goes wrong with a recording, in one line: file, line or field, expected, got, what to do.

Everything that the readers refuse is a `RecordingError`. Messages never span two lines, whatever
bytes stand in a file or its name, so that a command can print them as they are.
"""

from __future__ import annotations

import reprlib
from pathlib import Path

_PATH_SHOWN = 300


class RecordingError(ValueError):
    """A recording, trajectory file or manifest cannot be used as it is; the message says why.

    >>> from motorcade.replays import read_trajectory
    >>> read_trajectory("missing.tum")
    Traceback (most recent call last):
    ...
    motorcade.replays.errors.RecordingError: missing.tum: the file is missing
    """


class DamagedError(RecordingError):
    """A file is empty, truncated or corrupt: if it is a picture, the others may still be used."""


def refusal(
    path: Path | str,
    problem: str,
    *,
    line: int | None = None,
    field: str | None = None,
    advice: str | None = None,
) -> RecordingError:
    """Make the error "path, line 3, field: problem; advice".

    Args:
        path: the file or folder that is at fault.
        problem: what was expected and what was got.
        line: line of the file, counted from 1.
        field: key, column or frame.
        advice: what the reader can do about it.
    """
    where = str(path)
    if len(where) > _PATH_SHOWN:
        where = "..." + where[3 - _PATH_SHOWN :]
    if line is not None:
        where += f", line {line}"
    if field is not None:
        where += f", {field}"
    message = f"{where}: {problem}" + (f"; {advice}" if advice else "")
    return RecordingError(_printable(message))


def one_line(value: object, limit: int = 60) -> str:
    """Quote a value from a file for a message: printable, on one line, shortened to `limit`."""
    if isinstance(value, bytes):
        text = value[: 4 * limit].decode("utf-8", "replace")
    elif isinstance(value, list | tuple | dict):
        text = reprlib.repr(value)  # bounds the depth and the count of what it shows
    else:
        text = str(value)
    text = _printable(text[: limit + 1])
    return repr(text if len(text) <= limit else text[: limit - 3] + "...")


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else "?" for letter in text)
