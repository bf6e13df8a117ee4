"""Files of others, opened within bounds (`ga.files`); ours, written whole or not at all.

What the guard refuses comes as a recording's errors. No reader and no killed run meets half a file.
"""

from __future__ import annotations

import csv
import io
import os
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

from motorcade.ga import files
from motorcade.ga.files import EmptyFileError, FileError
from motorcade.ga.names import plain_reason, printable
from motorcade.ga.unfinished import unfinished

_PATH_SHOWN = 300


class RecordingError(ValueError):
    """A recording, trajectory file or manifest cannot be used as it is; the message says why.

    >>> from motorcade.replays import read_trajectory
    >>> read_trajectory("missing.tum")
    Traceback (most recent call last):
    ...
    motorcade.replays.io.files.RecordingError: missing.tum: the file is missing
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


def read_bounded(path: Path, limit_bytes: int, field: str | None = None) -> bytes:
    """Read a whole regular file of at most `limit_bytes`; raises as `open_bounded`."""
    with refused(field):
        return files.read_bounded(path, limit_bytes)


@contextmanager
def open_bounded(
    path: Path, limit_bytes: int, field: str | None = None
) -> Iterator[BufferedReader]:
    """Open a regular file of 1 to `limit_bytes` bytes, to be read within the block.

    Raises:
        DamagedError: empty.
        RecordingError: missing, not a regular file (a pipe would hang), larger than the limit, or
            unreadable, also within the block.
    """
    with refused(field), files.open_bounded(path, limit_bytes) as file:
        yield file


def admit_file(path: Path, limit_bytes: int, field: str | None = None) -> None:
    """Check a file that a library is about to open; raises as `open_bounded`."""
    with refused(field):
        files.admit_file(path, limit_bytes)


@contextmanager
def refusing(path: Path | str, field: str | None = None) -> Iterator[None]:
    """Turn a ValueError of the block into a refusal of `path`; refusals pass as they are."""
    try:
        yield
    except RecordingError:
        raise
    except ValueError as fault:
        raise refusal(path, str(fault), field=field) from fault


@contextmanager
def refused(field: str | None = None) -> Iterator[None]:
    """Turn what the door refuses (`ga.files`) into this room's errors."""
    try:
        yield
    except EmptyFileError as fault:
        raise DamagedError(str(refusal(fault.path, fault.problem, field=field))) from fault
    except FileError as fault:
        raise refusal(fault.path, fault.problem, field=field) from fault


def write_bytes(path: Path, data: bytes) -> None:
    """Write `data` over `path`; OSError naming `path`, which then stays as it was."""
    with replacing(path) as building:
        building.write_bytes(data)


def copy_file(source: Path, path: Path) -> None:
    """Copy a file over `path`; OSError naming `path` where that fails."""
    with replacing(path) as building:
        shutil.copyfile(source, building)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A file to write within the block, which then takes the place of `path`, all of it or nothing.

    Raises:
        OSError: a file that cannot be written, named by `path`, which then stays as it was.
    """
    try:
        with unfinished(path.parent) as place:
            building = place / f"content{path.suffix}"
            yield building
            with building.open("rb") as file:
                os.fsync(file.fileno())
            building.replace(path)
    except OSError as fault:
        raise OSError(fault.errno, f"cannot be written: {fault.strerror}", str(path)) from fault


def write_csv(path: Path, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table, whole or not at all; None is an empty cell.

    Raises:
        OSError: the file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    write_bytes(path, text.getvalue().encode())
