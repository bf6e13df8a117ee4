"""Compiled libraries on disk: named by what they were made from and by what they are.

The folder is one's own: MOTORCADE_PROGRAM_CACHE, or ``motorcade/programs`` in XDG_CACHE_HOME or
``~/.cache``. It is made for its owner alone, and not used where others own it or may write into
it, as what lies there is run; then, and where it cannot be made, each process has a folder of its
own, which goes with it. A library's name ends in its SHA-256: what is cut off or changed is not
what its name says, and goes. Files are written under another name and renamed, so that several
processes may do so at once. The oldest go where there are more than `MOST_BYTES`.
"""

from __future__ import annotations

import atexit
import hashlib
import logging
import os
import shutil
import stat
import tempfile
import time
from contextlib import suppress
from functools import cache
from pathlib import Path

MOST_BYTES = 64 * 2**20
"""Of all libraries together."""
LARGEST_BYTES = 16 * 2**20
"""Of one library; a larger file is not read."""

_DIGITS = 40
_LEFT_BEHIND_S = 3600.0
_log = logging.getLogger(__name__)


def cache_key(*parts: str) -> str:
    """The name of what is made from these texts."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode()
        digest.update(f"{len(data)} ".encode() + data)
    return digest.hexdigest()[:_DIGITS]


def cache_folder() -> Path:
    """The folder of this user, made if need be, or one of this process."""
    given = os.environ.get("MOTORCADE_PROGRAM_CACHE", "")
    home = os.environ.get("XDG_CACHE_HOME", "") or str(Path.home() / ".cache")
    folder = Path(given) if given else Path(home) / "motorcade" / "programs"
    problem = _problem_of(folder)
    if problem is None:
        return folder
    _log.warning("%s: %s; compiled programs are kept for this process only", folder, problem)
    return _own_folder()


def _problem_of(folder: Path) -> str | None:
    """Why a folder cannot be used; None where it can, and is there."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        about = folder.stat(follow_symlinks=False)
    except OSError as failed:
        return str(failed.strerror or failed)
    if not stat.S_ISDIR(about.st_mode):
        return "expected a folder"
    if about.st_uid != os.geteuid():
        return f"expected a folder of user {os.geteuid()}, got one of user {about.st_uid}"
    if about.st_mode & 0o022:
        return "expected a folder that others may not write into"
    return None if os.access(folder, os.W_OK | os.X_OK) else "it cannot be written into"


@cache
def _own_folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="motorcade-programs-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def cached_library(folder: Path, key: str) -> Path | None:
    """The library of a key, if there is one that is what its name says."""
    for path in sorted(folder.glob(f"{key}-*.so")):
        if _is_whole(path):
            with suppress(OSError):
                os.utime(path)  # what is used goes last
            return path
        _log.warning("%s: not what its name says; it is compiled again", path)
        path.unlink(missing_ok=True)
    return None


def _is_whole(path: Path) -> bool:
    try:
        file = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return False
    with os.fdopen(file, "rb") as opened:
        about = os.fstat(file)
        regular = stat.S_ISREG(about.st_mode) and about.st_uid == os.geteuid()
        if not regular or about.st_mode & 0o022 or about.st_size > LARGEST_BYTES:
            return False
        digest = hashlib.sha256(opened.read(LARGEST_BYTES)).hexdigest()
    return path.stem.rpartition("-")[2] == digest


def keep_library(folder: Path, key: str, data: bytes) -> Path:
    """Put a library into the folder, in one step, and let the oldest go.

    Raises:
        OSError: it cannot be written.
    """
    path = folder / f"{key}-{hashlib.sha256(data).hexdigest()}.so"
    file, name = tempfile.mkstemp(dir=folder, prefix="writing-")
    try:
        with os.fdopen(file, "wb") as opened:
            opened.write(data)
            opened.flush()
            os.fsync(opened.fileno())
        Path(name).chmod(0o500)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    _let_oldest_go(folder, path)
    return path


def _let_oldest_go(folder: Path, newest: Path) -> None:
    for left in (*folder.glob("compiling-*"), *folder.glob("writing-*")):
        with suppress(OSError):  # of processes that were killed
            if time.time() - left.stat(follow_symlinks=False).st_mtime > _LEFT_BEHIND_S:
                shutil.rmtree(left, ignore_errors=True) if left.is_dir() else left.unlink()
    found = []
    for path in folder.glob("*.so"):
        with suppress(OSError):
            about = path.stat(follow_symlinks=False)
            found.append((path != newest, -about.st_mtime_ns, about.st_size, path))
    total = 0
    for _, _, size, path in sorted(found):
        total += size
        if total > MOST_BYTES:
            with suppress(OSError):  # another process may have done it
                path.unlink()
