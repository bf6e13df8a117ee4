"""The machine's C compiler, and the libraries that it made, kept on disk.

The environment variable CC says which one; otherwise it is the first of cc, gcc and clang that is
found. It is given a file and options as a list, never a line for a shell.

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
import shlex
import shutil
import stat
import subprocess
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

LONGEST_S = 120.0
"""How long a compilation may take."""

_COMPILERS = ("cc", "gcc", "clang")
# Sums are never regrouped; nothing here reads errno or floating-point flags.
_OPTIONS = (
    "-std=gnu11", "-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast",
    "-shared", "-fPIC", "-w",
)  # fmt: skip
_LEVELS = {2: ("-march=x86-64-v2",), 3: ("-march=x86-64-v3",), 4: ("-march=x86-64-v4",)}


class CompileError(Exception):
    """The compiler did not make a library; the message says why, in one line."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler with its options; `identity` changes whenever its results may."""

    command: tuple[str, ...]
    identity: str

    def library(self, source: str, folder: Path) -> bytes:
        """Compile C to a shared library; the files in between are in a folder of their own.

        Raises CompileError: it could not be run, refused the source, or took too long.
        """
        try:
            with tempfile.TemporaryDirectory(dir=folder, prefix="compiling-") as own:
                source_file, library_file = Path(own) / "program.c", Path(own) / "program.so"
                source_file.write_text(source, encoding="utf-8")
                command = [*self.command, str(source_file), "-o", str(library_file), "-lm"]
                done = subprocess.run(
                    command, capture_output=True, text=True, errors="replace",
                    stdin=subprocess.DEVNULL, timeout=LONGEST_S, check=False,
                )  # fmt: skip
                if done.returncode == 0:
                    return library_file.read_bytes()
        except subprocess.TimeoutExpired as late:
            raise CompileError(f"{self.command[0]} took more than {LONGEST_S:g} s") from late
        except OSError as failed:
            raise CompileError(f"{self.command[0]}: {failed}") from failed
        said = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr)
        raise CompileError(f"{self.command[0]} ended with {done.returncode}: {said.strip()[:200]}")


def find_compiler(processor_level: int) -> Compiler:
    """The compiler of this machine, for its processor. Raises CompileError: there is none."""
    wanted = shlex.split(os.environ.get("CC", ""))
    names = wanted[:1] or list(_COMPILERS)
    compiler = next((path for name in names if (path := shutil.which(name))), None)
    if compiler is None:
        raise CompileError(f"no C compiler here: looked for {', '.join(names)}")
    command = (compiler, *wanted[1:], *_OPTIONS, *_LEVELS.get(processor_level, ()))
    real = Path(compiler).resolve()
    about = real.stat()
    return Compiler(command, f"{command} {real} {about.st_size} {about.st_mtime_ns}")


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
    value = os.environ.get("MOTORCADE_PROGRAM_CACHE", "")
    home = os.environ.get("XDG_CACHE_HOME", "") or str(Path.home() / ".cache")
    folder = Path(value) if value else Path(home) / "motorcade" / "programs"
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

    Raises OSError: it cannot be written.
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
    libraries = []
    for path in folder.glob("*.so"):
        with suppress(OSError):
            about = path.stat(follow_symlinks=False)
            libraries.append((path != newest, -about.st_mtime_ns, about.st_size, path))
    total = 0
    for _, _, size, path in sorted(libraries):
        total += size
        if total > MOST_BYTES:
            with suppress(OSError):  # another process may have done it
                path.unlink()
