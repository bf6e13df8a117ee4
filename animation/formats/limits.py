"""What is refused of an untrusted file: how large it is, which files it names; and how it is told.

The limits are far above any character in use, and low enough that a hostile file is refused
before it fills the memory.
"""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from motorcade.ga import files
from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import UNSETTLED, FileError, is_there, put_on_record

MAX_FILE_BYTES = 256 << 20
MAX_TEXT_BYTES = 64 << 20
"""Of files, and parts of files, that are taken apart word by word."""
MAX_ENTRIES = 4 << 20
"""Of a JSON document, lists and tables too: two bytes of it may take a hundred of memory."""
MAX_VALUES = 32 << 20
"""Numbers that one file may unpack to, over all its arrays."""
MAX_POSES = 4 << 20
"""Local poses of all clips together: samples times nodes."""
MAX_NODES = 20_000
MAX_DEPTH = 512
"""Levels of the hierarchy, and of nested XML elements."""
MAX_CLIPS = 4096
MAX_VERTICES = 4 << 20
"""Vertices, and triangles, of all surfaces together; surfaces may share their arrays."""
MAX_PARTS = 8192
"""Parts of meshes that are drawn, counted at every node that shows them."""
MAX_IMAGE_PIXELS = 64 << 20
"""Pixels of one texture, and of all of a file that are kept as they are, broken ones too."""
MAX_REDUCED_PIXELS = 128 << 20
"""Pixels of further textures that are decoded, one by one, to be kept smaller."""
MAX_IMAGE_BYTES = 512 << 20
"""Bytes of the files of all textures."""
MAX_MORPHS = 32_768
"""Morph targets of all surfaces together, those of each of their materials counted apart."""


def read_bounded(path: Path, limit_bytes: int = MAX_FILE_BYTES) -> bytes:
    """Read a whole regular file; raises FormatError as `ga.files.read_bounded` does FileError."""
    try:
        return files.read_bounded(path, limit_bytes)
    except FileError as fault:
        raise FormatError(fault.problem) from fault


def beside(folder: Path, uri: str, field: str) -> Path:
    """The file that a relative address names, inside `folder` or below.

    It is named as it was given, links and all: where one is set anew, another file is meant.

    Raises FormatError: an absolute path, another scheme, or a way out of the folder, by `..` or by
    a symbolic link.
    """
    name = unquote(uri).replace("\\", "/")
    if name.startswith("/") or ":" in name or "\0" in name or len(name) > 1000:
        raise expected(field, "the name of a file beside this one", uri)
    named = folder / name
    try:
        inside = named.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError) as fault:  # links in a circle, names that are too long
        put_on_record({named: UNSETTLED})
        raise expected(field, "the name of a file beside this one", uri) from fault
    if not inside:
        if ".." not in named.parts:  # then a link leads out, which may be mended
            put_on_record({named: UNSETTLED})
        raise expected(field, "a file inside the folder of this one", uri)
    return named


def image_beside(folder: Path, uri: str, field: str) -> Path:
    """The image that an address names, inside `folder` or below.

    Programs write paths of the machine they ran on: where an address leads elsewhere, or to
    nothing, the file of the same name in the folder itself is meant.

    Raises FormatError: no name that a file beside this one may have.
    """
    try:
        named = beside(folder, uri, field)
    except FormatError:
        named = folder  # which is no regular file
    if is_there(named):
        return named
    return beside(folder, unquote(uri).replace("\\", "/").rpartition("/")[2], field)


def check_count(field: str, count: int, limit: int) -> int:
    """`count` where it is from 0 to `limit`.

    Raises FormatError: negative, or more than the limit.
    """
    if not 0 <= count <= limit:
        raise FormatError(f"{shown(field)}: expected at most {limit}, got {count}")
    return count


_SHOWN = 80


class FormatError(ValueError):
    """A character or motion file cannot be used as it is; the message says where and why."""

    def in_file(self, path: Path) -> FormatError:
        """The same error, opened by the name of the file it was found in."""
        return type(self)(f"{shown(str(path), 300)}: {self}")


class NoMeshError(FormatError):
    """A motion was read where a character was wanted: nothing in the file has a surface."""


def expected(field: str, wanted: str, got: object) -> FormatError:
    """Make the error "field: expected ..., got ..."; what came is shortened and printable."""
    return FormatError(f"{shown(field)}: expected {wanted}, got {shown(got)}")


def shown(value: object, limit: int = _SHOWN) -> str:
    """A value from a file for a message: printable, on one line, shortened to `limit`."""
    if isinstance(value, dict | list | tuple):
        text = f"{len(value)} entries"
    else:
        text = str(value) if not isinstance(value, bytes) else repr(value[:limit])
    text = text if len(text) <= limit else text[: limit - 3] + "..."
    return "".join(letter if letter.isprintable() else "?" for letter in text)


PIECE = 1 << 20
SPACE = re.compile(r"\s")


def numbers_in(text: str, field: str) -> FloatArray:
    """All numbers of a text, parted by white space.

    Raises FormatError: other words, NaN, numbers beyond 1e9, or more than MAX_VALUES.
    """
    pieces, start, total = [], 0, 0
    while start < len(text):
        gap = SPACE.search(text, min(start + PIECE, len(text)))
        end = len(text) if gap is None else gap.start()
        words = text[start:end].split()
        start = end + 1
        if not words:
            continue
        try:
            pieces.append(np.array(words, dtype=np.float64))
        except ValueError as fault:
            raise FormatError(f"{field}: expected numbers, {shown(fault)}") from fault
        total += len(words)
        if total > MAX_VALUES:
            raise expected(field, f"at most {MAX_VALUES} numbers", "more")
    values = np.concatenate(pieces) if pieces else np.zeros(0)
    if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > 1e9:
        raise expected(field, "finite numbers up to 1e9", "others")
    return values
