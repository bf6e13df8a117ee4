"""The one guard of files that others made: regular, bounded, and on record while someone asks.

Everything of the program that opens a file which a user, a recording or another file names comes
through here, wherever the name came from. Libraries that open a file themselves (videos, bags)
are given its path after `admit_file`.

A record says in what state each file was when it was asked for. `files_now` says in what state they
are: where that is the same, what was made of them still holds.
"""

from __future__ import annotations

import hashlib
import os
import stat
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from io import BufferedReader
from os import stat_result
from pathlib import Path

MISSING = "missing"
"""The state of a file that was looked for in vain."""
UNSETTLED = "unsettled"
"""The state of a file that cannot be said, as it changed meanwhile; never that of a file now."""
_WAYS = ("O_RDONLY", "O_NONBLOCK", "O_NOCTTY", "O_BINARY")
# Windows has the last alone: without it, it would change the ends of lines.
_OPENED = sum(getattr(os, way, 0) for way in _WAYS)
_NO_FILE, _UNREADABLE = "not a file", "unreadable"
_SETTLES_NS = 2_000_000_000
# A file that changed just now may change again within one tick of the disk's clock.

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
    with _admitted(path, limit_bytes) as (file, about), _as_file_errors(path):
        size = about.st_size
        data = file.read(size + 1)  # not up to the limit, for which memory would be set aside
    if len(data) > size:
        raise FileError(path, f"expected {size} bytes, as when it was opened, got more")
    if _record.get() is not None:
        _note(path, f"{len(data)} bytes, SHA-256 {hashlib.sha256(data).hexdigest()}")
    if not data:
        raise EmptyFileError(path, "the file is empty")
    return data


@contextmanager
def open_bounded(path: Path, limit_bytes: int) -> Iterator[BufferedReader]:
    """Open a regular file of 1 to `limit_bytes` bytes, to be read within the block.

    Raises EmptyFileError: empty; FileError: missing, not a regular file (a pipe would hang), larger
    than the limit, or unreadable, also within the block.
    """
    with _admitted(path, limit_bytes) as (file, about):
        _note_admitted(path, about)
        with _as_file_errors(path):
            yield file


def admit_file(path: Path, limit_bytes: int) -> None:
    """Check a file that a library is about to open, and put it on record.

    Raises EmptyFileError, FileError: as `open_bounded`.
    """
    with _admitted(path, limit_bytes) as (_, about):
        _note_admitted(path, about)


def _note_admitted(path: Path, about: stat_result) -> None:
    """Put a file on record that may be opened, and refuse it where it is empty."""
    if _record.get() is not None:
        _note(path, _state(path))
    if about.st_size == 0:
        raise EmptyFileError(path, "the file is empty")


def is_there(path: Path) -> bool:
    """Whether a name leads to a regular file; one that does not is on record, as that may change.

    >>> from pathlib import Path
    >>> from motorcade.ga.files import files_read, is_there
    >>> with files_read() as record:
    ...     found = is_there(Path("/hero.md5anim"))
    >>> found, record
    (False, {PosixPath('/hero.md5anim'): 'missing'})
    """
    try:
        exists = path.is_file()
    except OSError:  # of a name that is too long
        exists = False
    if exists:
        return True
    _note(path, _state(path))
    return False


@contextmanager
def _admitted(path: Path, limit_bytes: int) -> Iterator[tuple[BufferedReader, stat_result]]:
    """A file that may be read, open, and what the system says of it.

    It is looked at twice: before it is opened, as that alone may set a device going, and then what
    was opened, which may have taken its name meanwhile; a pipe is not waited for. One that may not
    be read is on record as it is.
    """
    with _as_file_errors(path):
        try:
            _require_file(path, path.stat(), limit_bytes)
            handle = os.open(path, _OPENED)
        except OSError:
            _note(path, _state(path))
            raise
        except FileError:
            raise
        except ValueError as fault:
            raise FileError(path, f"expected the name of a file, got one with {fault}") from fault
    with os.fdopen(handle, "rb") as file:
        about = os.fstat(handle)
        _require_file(path, about, limit_bytes)
        yield file, about


def _require_file(path: Path, about: stat_result, limit_bytes: int) -> None:
    """Refuse what is no regular file, or too large a one."""
    if not stat.S_ISREG(about.st_mode):
        _note(path, _NO_FILE)
        raise FileError(path, "expected a file, got a folder or a device")
    if about.st_size > limit_bytes:
        _note(path, f"{about.st_size} bytes")
        raise FileError(path, f"expected at most {limit_bytes} bytes, got {about.st_size}")


@contextmanager
def files_read() -> Iterator[dict[Path, str]]:
    """Within the block, the state of each file that is opened: size and SHA-256.

    Files that were looked for in vain, or refused, are on record too. Threads begin without a
    record; run them in a copy of this context where they open files.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.ga.files import files_now, files_read, read_bounded
    >>> with tempfile.TemporaryDirectory() as folder, files_read() as record:
    ...     path = Path(folder) / "pose.txt"
    ...     written = path.write_bytes(b"0 0 0 1")
    ...     data = read_bounded(path, 100)
    ...     before = files_now(record) == record
    ...     written = path.write_bytes(b"0 0 0 2")
    ...     after = files_now(record) == record
    >>> [(path.name, state[:22]) for path, state in record.items()], before, after
    ([('pose.txt', '7 bytes, SHA-256 0d020')], True, False)
    """
    record: dict[Path, str] = {}
    token = _record.set(record)
    try:
        yield record
    finally:
        _record.reset(token)
        put_on_record(record)


def put_on_record(record: Mapping[Path, str]) -> None:
    """Have what another record says on the present one too, as if its files were read here."""
    for path, state in record.items():
        _note(path, state)


def files_now(record: Mapping[Path, str]) -> dict[Path, str]:
    """The state that the files of a record are in now; equal to it where nothing has changed.

    Only files of the size that is on record are read; those of another size have changed.
    """
    return {path: _state(path, known) for path, known in record.items()}


@contextmanager
def off_record() -> Iterator[None]:
    """Within the block nothing is put on record: for files that the program made for itself."""
    token = _record.set(None)
    try:
        yield
    finally:
        _record.reset(token)


def _note(path: Path, state: str) -> None:
    """Put a file's state on record, where there is one."""
    record = _record.get()
    if record is not None:
        place = path.absolute()
        record[place] = state if record.get(place, state) == state else UNSETTLED


def _state(path: Path, known: str | None = None) -> str:
    """The state of a file, told by its size alone where that is another than in the one known."""
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            return _NO_FILE
        size = f"{about.st_size} bytes"
        if known is not None and not known.startswith(f"{size}, "):
            return size
        facts = (about.st_size, about.st_mtime_ns, about.st_ctime_ns, about.st_ino, about.st_dev)
        settled = time.time_ns() - max(about.st_mtime_ns, about.st_ctime_ns) > _SETTLES_NS
        digest = _digest(path, facts) if settled else _digest.__wrapped__(path, facts)
        return f"{size}, SHA-256 {digest}"
    except (FileNotFoundError, NotADirectoryError, ValueError):  # or a name that none can have
        return MISSING
    except OSError:
        return _UNREADABLE


@lru_cache(maxsize=1 << 16)
def _digest(path: Path, facts: tuple[int, ...]) -> str:
    """SHA-256 of a file, read once for as long as the system says the same of it."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextmanager
def _as_file_errors(path: Path) -> Iterator[None]:
    """The system's refusals as ours."""
    try:
        yield
    except FileNotFoundError as missing:
        raise FileError(path, "the file is missing") from missing
    except OSError as fault:
        raise FileError(path, f"cannot be read: {fault.strerror or fault}") from fault
