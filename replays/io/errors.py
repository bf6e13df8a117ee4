"""What goes wrong with a recording, in one line: file, line or field, expected, got, what to do.

Everything that the readers refuse is a `RecordingError`. Messages never span two lines, whatever
bytes stand in a file or its name, so that a command can print them as they are.
"""

from __future__ import annotations

from pathlib import Path

from motorcade.ga.names import plain_reason, printable

_PATH_SHOWN = 300


class RecordingError(ValueError):
    """A recording, trajectory file or manifest cannot be used as it is; the message says why.

    >>> from motorcade.replays import read_trajectory
    >>> read_trajectory("missing.tum")
    Traceback (most recent call last):
    ...
    motorcade.replays.io.errors.RecordingError: missing.tum: the file is missing
    """


class DamagedError(RecordingError):
    """A file is empty, truncated, corrupt or of another size: other images may still be used."""


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
    return RecordingError(printable(plain_reason(message)))
