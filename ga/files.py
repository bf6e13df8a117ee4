"""The one door for files that others made: regular, bounded, and on record while someone asks.

Everything of the program that opens a file which a user, a recording or another file names comes
through here, wherever the name came from. Libraries that open a file themselves (videos, bags,
HDF5) are given its path after `admit_file`.
"""

from __future__ import annotations

import hashlib
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO

__all__ = [
    "MISSING",
    "EmptyFileError",
    "FileError",
    "admit_file",
    "file_digest",
    "files_read",
    "off_record",
    "open_bounded",
    "read_bounded",
]

MISSING = "missing"
"""What stands in a record in place of the digest of a file that was looked for in vain."""

_record: ContextVar[dict[Path, str] | None] = ContextVar("record", default=None)


class FileError(ValueError):
    """A file cannot be used as it is.

    Fields:
        path: the file.
        problem: what was expected and what was got, without the path.
    """

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path
        self.problem = problem


class EmptyFileError(FileError):
    """A file without a byte, as a copy that was stopped leaves it."""


def read_bounded(path: Path, limit_bytes: int) -> bytes:
    """Read a whole regular file of 1 to `limit_bytes` bytes; raises as `open_bounded`.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.ga.files import read_bounded
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "pose.txt"
    ...     written = path.write_bytes(b"0 0 0 1")
    ...     read_bounded(path, 100)
    b'0 0 0 1'
    """
    with open_bounded(path, limit_bytes) as file:
        data = file.read(limit_bytes + 1)
    if len(data) > limit_bytes:  # it grew since it was admitted
        raise FileError(path, f"expected at most {limit_bytes} bytes, got more")
    return data


@contextmanager
def open_bounded(path: Path, limit_bytes: int) -> Iterator[BinaryIO]:
    """Open a regular file of 1 to `limit_bytes` bytes, to be read within the block.

    Raises:
        EmptyFileError: empty.
        FileError: missing, not a regular file (a pipe would hang), larger than the limit, or
            unreadable, also within the block.
    """
    admit_file(path, limit_bytes)
    with _told(path), path.open("rb") as file:
        yield file


def admit_file(path: Path, limit_bytes: int) -> None:
    """Check a file that a library is about to open, and put it on record.

    Raises:
        EmptyFileError, FileError: as `open_bounded`.
    """
    record = _record.get()
    with _told(path):
        try:
            about = path.stat()
        except FileNotFoundError:
            if record is not None:
                record[path.absolute()] = MISSING
            raise
        except ValueError as fault:
            raise FileError(path, f"expected the name of a file, got one with {fault}") from fault
    if not stat.S_ISREG(about.st_mode):
        raise FileError(path, "expected a file, got a folder or a device")
    if about.st_size > limit_bytes:
        raise FileError(path, f"expected at most {limit_bytes} bytes, got {about.st_size}")
    if record is not None:
        record[path.absolute()] = file_digest(path)
    if about.st_size == 0:
        raise EmptyFileError(path, "the file is empty")


@contextmanager
def files_read() -> Iterator[dict[Path, str]]:
    """Within the block, everything that comes through the door: path and SHA-256 of the content.

    A file that was looked for and is not there has `MISSING` for its digest. Threads begin without
    a record; run them in a copy of this context where they open files.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.ga.files import files_read, read_bounded
    >>> with tempfile.TemporaryDirectory() as folder, files_read() as record:
    ...     path = Path(folder) / "pose.txt"
    ...     written = path.write_bytes(b"0 0 0 1")
    ...     data = read_bounded(path, 100)
    >>> [(path.name, digest[:8]) for path, digest in record.items()]
    [('pose.txt', '0d02030f')]
    """
    outer = _record.get()
    record: dict[Path, str] = {}
    token = _record.set(record)
    try:
        yield record
    finally:
        _record.reset(token)
        if outer is not None:
            outer.update(record)


@contextmanager
def off_record() -> Iterator[None]:
    """Within the block nothing is put on record: for files that the program made for itself."""
    token = _record.set(None)
    try:
        yield
    finally:
        _record.reset(token)


def file_digest(path: Path) -> str:
    """SHA-256 of a regular file's content; `MISSING` where there is none.

    Raises:
        FileError: it cannot be read.
    """
    with _told(path):
        if not path.is_file():
            return MISSING
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """The system's refusals as ours."""
    try:
        yield
    except FileNotFoundError as missing:
        raise FileError(path, "the file is missing") from missing
    except OSError as fault:
        raise FileError(path, f"cannot be read: {fault.strerror or fault}") from fault
