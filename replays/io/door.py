"""The door for files of others (`ga.files`), with what it refuses as a recording's errors."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

from motorcade.ga import files
from motorcade.ga.files import EmptyFileError, FileError
from motorcade.replays.io.errors import DamagedError, refusal


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
def refused(field: str | None = None) -> Iterator[None]:
    """Turn what the door refuses (`ga.files`) into this room's errors."""
    try:
        yield
    except EmptyFileError as fault:
        raise DamagedError(str(refusal(fault.path, fault.problem, field=field))) from fault
    except FileError as fault:
        raise refusal(fault.path, fault.problem, field=field) from fault
