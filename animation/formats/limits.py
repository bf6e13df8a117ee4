"""How large an untrusted file and what it unpacks to may be, and which files it may name.

The limits are far above any character in use, and low enough that a hostile file is refused
before it fills the memory.
"""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

from motorcade.animation.formats.errors import FormatError, expected, shown
from motorcade.ga import files
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

    Raises:
        FormatError: an absolute path, another scheme, or a way out of the folder, by `..` or by a
            symbolic link.
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


def picture_beside(folder: Path, uri: str, field: str) -> Path:
    """The picture that an address names, inside `folder` or below.

    Programs write paths of the machine they ran on: where an address leads elsewhere, or to
    nothing, the file of the same name in the folder itself is meant.

    Raises:
        FormatError: no name that a file beside this one may have.
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

    Raises:
        FormatError: negative, or more than the limit.
    """
    if not 0 <= count <= limit:
        raise FormatError(f"{shown(field)}: expected at most {limit}, got {count}")
    return count
