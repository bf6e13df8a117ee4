"""Values kept in ``.npz`` files of plain arrays, each with the name of its format.

The same arrays give the same bytes; nothing is pickled. An archive that others made is read only
after its directory has told what it unpacks to.
"""

from __future__ import annotations

import math
import shutil
import struct
import zlib
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from io import BufferedReader, BytesIO
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, TypeVar
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from motorcade.ga.files import FileError, open_bounded

T = TypeVar("T")

MAX_FILE_BYTES = 1 << 30
MAX_UNPACKED_BYTES = 64 << 20
"""Of a compressed archive that is smaller itself; one as written here is stored as it is."""
MAX_ARRAYS = 1000
_MAX_DIRECTORY_BYTES = 1 << 18

_FAULTS = (
    BadZipFile,
    EOFError,
    KeyError,
    RuntimeError,  # an encrypted member
    TypeError,
    ValueError,
    struct.error,
    zlib.error,
)

_END = struct.Struct("<4s4H2LH")
_ZIP64_LOCATOR = struct.Struct("<4s16x")


def save_arrays(path: Path, owner: str, form: str, arrays: Mapping[str, Any]) -> None:
    """Write arrays and the name of their format.

    Raises ValueError: a file name that does not end in ``.npz``; OSError: a file that cannot be
    written.
    """
    if path.suffix != ".npz":
        raise ValueError(f"{owner}.save(path): expected a name ending in .npz, got {path}")
    np.savez(path, allow_pickle=False, format=np.array(form), **arrays)


def save_arrays_in_parts(
    path: Path, owner: str, form: str, parts: Iterable[Mapping[str, NDArray[Any]]]
) -> None:
    """As `save_arrays`, of arrays that come in parts, one after another along their first axis.

    What came is kept in files beside `path` until all is there, so that memory does not grow.

    Raises:
        ValueError: a file name that does not end in ``.npz``.
        OSError: a file that cannot be written.

    >>> import tempfile
    >>> import numpy as np
    >>> from motorcade.ga.archives import read_arrays, save_arrays_in_parts
    >>> parts = ({"squares": np.arange(k, k + 2) ** 2} for k in (0, 2, 4))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "numbers.npz")
    ...     save_arrays_in_parts(path, "Numbers", "numbers 1", parts)
    ...     read_arrays(path)["squares"]
    array([ 0,  1,  4,  9, 16, 25])
    """
    if path.suffix != ".npz":
        raise ValueError(f"{owner}.save(path): expected a name ending in .npz, got {path}")
    shapes: dict[str, tuple[int, ...]] = {}
    kinds: dict[str, np.dtype[Any]] = {}
    with ExitStack() as stack:
        waiting: dict[str, Any] = {}
        for part in parts:
            for name, values in part.items():
                if name not in waiting:
                    waiting[name] = stack.enter_context(TemporaryFile(dir=path.parent))
                    shapes[name], kinds[name] = (0, *values.shape[1:]), values.dtype
                waiting[name].write(np.ascontiguousarray(values).data)
                shapes[name] = (shapes[name][0] + len(values), *shapes[name][1:])
        with ZipFile(path, "w", ZIP_STORED) as archive:
            _add_member(
                archive, "format", np.array(form).dtype, (), BytesIO(np.array(form).tobytes())
            )
            for name, file in waiting.items():
                file.seek(0)
                _add_member(archive, name, kinds[name], shapes[name], file)


def _add_member(
    archive: ZipFile, name: str, kind: np.dtype[Any], shape: tuple[int, ...], content: Any
) -> None:
    """One array, as `numpy.savez` writes it."""
    with archive.open(ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
        head = {"descr": npy.dtype_to_descr(kind), "fortran_order": False, "shape": shape}
        npy.write_array_header_1_0(member, head)
        shutil.copyfileobj(content, member, 1 << 20)


def load_arrays(
    path: Path, what: str, form: str, make: Callable[[Mapping[str, NDArray[Any]]], T]
) -> T:
    """A value made of what `save_arrays` wrote.

    Raises FileError: as `read_arrays`; ValueError: a file that holds no such value, or numbers that
    the value refuses.
    """
    arrays = read_arrays(path, what)
    try:
        if arrays["format"].shape != () or str(arrays["format"]) != form:
            raise ValueError(f"expected the format '{form}', got '{arrays['format']!s:.60}'")
        return make(arrays)
    except (ValueError, KeyError, TypeError) as fault:
        raise FileError(path, f"not {what}: {_reason(fault)}") from fault


def read_arrays(
    path: Path, what: str = "a file of arrays", limit_bytes: int = MAX_FILE_BYTES
) -> dict[str, NDArray[Any]]:
    """All arrays of an ``.npz`` file by name; `what` the file should be is for the message.

    Raises FileError: what `files.open_bounded` refuses, a file that is no such archive,
    or one that would unpack to more than its own size and `MAX_UNPACKED_BYTES`.
    """
    with open_bounded(path, limit_bytes) as file:
        try:
            _check_directory(file, path.stat().st_size)
            with np.load(file, allow_pickle=False) as stored:
                return {name: stored[name] for name in stored.files}
        except FileError:
            raise
        except _FAULTS as fault:
            raise FileError(path, f"not {what}: {_reason(fault)}") from fault


def _reason(fault: Exception) -> str:
    """What a library found wrong, in one line; it may quote whatever bytes stand in the file."""
    return " ".join(str(fault)[:200].split())


def _check_directory(file: BufferedReader, size: int) -> None:
    """Refuse an archive by what its directory and its arrays' headers say, and nothing more."""
    _check_end(file, size)
    with ZipFile(file) as archive:
        members = archive.infolist()
        most = max(size, MAX_UNPACKED_BYTES)
        total = sum(member.file_size for member in members)
        if total > most or len(members) > MAX_ARRAYS:
            raise ValueError(
                f"expected at most {MAX_ARRAYS} arrays of {most} bytes in all, "
                f"got {len(members)} of {total}"
            )
        for member in members:
            if member.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
                raise ValueError(f"{member.filename}: expected it stored or deflated")
            with archive.open(member) as opened:
                shape, kind = _header(opened)
            if math.prod(shape) * max(kind.itemsize, 1) > member.file_size:
                raise ValueError(
                    f"{member.filename}: expected {shape} of {kind}, got {member.file_size} bytes"
                )
    file.seek(0)


def _check_end(file: BufferedReader, size: int) -> None:
    """The record that ends an archive tells how large a directory `ZipFile` would take in."""
    length = min(size, _ZIP64_LOCATOR.size + _END.size)
    file.seek(size - length)
    tail = file.read(length)
    if length < _END.size or tail[-_END.size :][:4] != b"PK\5\6":
        raise ValueError("expected an archive that is whole and without a comment")
    _, _, _, _, count, directory_bytes, _, comment = _END.unpack(tail[-_END.size :])
    zip64 = tail[: -_END.size][:4] == b"PK\6\7"
    if zip64 or comment or count > MAX_ARRAYS or directory_bytes > _MAX_DIRECTORY_BYTES:
        raise ValueError(
            f"expected at most {MAX_ARRAYS} arrays and {_MAX_DIRECTORY_BYTES} bytes of directory, "
            f"got {count} and {directory_bytes}"
        )


def _header(opened: Any) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type that an array's own header tells."""
    version = npy.read_magic(opened)
    if version == (1, 0):
        shape, _, kind = npy.read_array_header_1_0(opened)
    elif version == (2, 0):
        shape, _, kind = npy.read_array_header_2_0(opened)
    else:
        raise ValueError(f"expected an array of format 1.0 or 2.0, got {version}")
    return shape, kind
