"""Runs a program's tape: as NumPy source at once, and as compiled C once that is there.

The first call in a precision looks whether the C was compiled before; otherwise a thread
compiles it while calls go on with NumPy. MOTORCADE_PROGRAMS set to "numpy" has no C compiled, set
to "wait" has the first call wait for it. Which way a call goes changes results by rounding alone.

The compiler is CC's; else the first of cc, gcc and clang. It is given a list, never a line for a
shell. Libraries are kept in MOTORCADE_PROGRAM_CACHE, or ``motorcade/programs`` in XDG_CACHE_HOME or
``~/.cache``: a folder for its owner alone, and not used where others own it or may write into it,
as what lies there is run; then each process has a folder of its own, which goes with it. A
library's name ends in its SHA-256: what is cut off or changed goes. Files are written under another
name and renamed, so that several processes may write at once. The oldest go where there are more
than `MOST_BYTES`.
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
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import kernels
from motorcade.ga.codegen.precision import DOUBLE, SINGLE, Precision
from motorcade.ga.codegen.runtime.by_numpy import SYMBOL, NumpyProgram, c_source, plain_tape
from motorcade.ga.codegen.tape import Tape

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


LONGEST_COMPILED = 20_000
"""Operations; longer programs stay with NumPy, as C compilers take minutes for them."""

_WAYS = ("", "numpy", "wait")


def way_wanted() -> str:
    """What MOTORCADE_PROGRAMS says: nothing, numpy or wait. Raises ValueError: anything else."""
    wanted = os.environ.get("MOTORCADE_PROGRAMS", "")
    if wanted not in _WAYS:
        raise ValueError(f"MOTORCADE_PROGRAMS: expected 'numpy', 'wait' or nothing, got {wanted!r}")
    return wanted


class Evaluator:
    """A program that runs on arrays, `arrays`, and on coefficients, `components`.

    Attributes:
        arrays: takes an array ``(*, n)`` for each input, or ``(*)`` or a number where that is a
            scalar, and gives one for each output.
        components: takes one number or array for each component of each input, those that are
            `negative` with the other sign, and gives a tuple of those of the outputs, which must
            be finite.
    """

    arrays: Callable[..., Any]
    components: Callable[..., tuple[Any, ...]]

    def __init__(self, name: str, tape: Tape, bare: bool, negative: Sequence[bool]) -> None:
        self._name = name
        self._plain = plain_tape(tape)
        self._inputs = [(o.name, -1 if o.components == ("1",) else o.width) for o in tape.inputs]
        self._outputs = [(o.name, -1 if o.components == ("1",) else o.width) for o in tape.outputs]
        self._bare = bare
        self._negative = list(negative)
        self._numpy = NumpyProgram(name, self._plain, self._inputs, self._outputs, self._negative)
        self._lock = threading.Lock()
        self._threads: dict[str, threading.Thread] = {}
        self._libraries: dict[str, str] = {}
        self._state: dict[str, str] = {}
        self._bind()

    def backend(self, precision: str = "float64") -> str:
        """How calls in a precision run now: "c", or "numpy" and why, in one line."""
        if precision in self._libraries:
            return "c"
        return f"numpy: {self._state.get(precision, 'not called yet')}"

    def wait(self, precision: str = "float64") -> bool:
        """Have the C of a precision compiled; whether it is there."""
        chosen = {p.numpy: p for p in (SINGLE, DOUBLE)}.get(precision)
        if chosen is None:
            raise ValueError(f"precision: expected float32 or float64, got {precision!a}")
        self._start(chosen)
        thread = self._threads.get(precision)
        if thread is not None:
            thread.join()
        return precision in self._libraries

    def _bind(self) -> None:
        """Calls go to the libraries that are there, and what they do not do to `_slowly`."""
        trampoline = _trampoline()
        if trampoline is None or not self._libraries:
            self.arrays = lambda *values: self._slowly("arrays", values)
            self.components = lambda *values: self._slowly("components", values)
            return
        arrays, components = trampoline.bind(
            self._name,
            self._inputs,
            self._outputs,
            self._negative,
            self._bare,
            self._libraries.get(SINGLE.numpy),
            self._libraries.get(DOUBLE.numpy),
            SYMBOL,
            kernels.threads,
        )
        if len(self._libraries) == 2:
            self.arrays, self.components = arrays, components
            return

        def either(of: Callable[..., Any], verb: str) -> Callable[..., Any]:
            def call(*values: Any) -> Any:
                result = of(*values)
                return self._slowly(verb, values) if result is NotImplemented else result

            return call

        self.arrays, self.components = either(arrays, "arrays"), either(components, "components")

    def _slowly(self, verb: str, values: Sequence[Any]) -> Any:
        """A call whose precision is not compiled: begin that, and do without."""
        precision = precision_of(values)
        if precision.numpy not in self._state:
            self._start(precision)
            if way_wanted() == "wait":
                self.wait(precision.numpy)
            if precision.numpy in self._libraries:
                return getattr(self, verb)(*values)
        if verb == "components":
            return self._numpy.components(precision, values)
        arrays = self._numpy.arrays(precision, values)
        return arrays[0] if self._bare else arrays

    def _start(self, precision: Precision) -> None:
        """Find the library of a precision, or have a thread compile it; does so once."""
        with self._lock:
            if precision.numpy in self._state:
                return
            self._state[precision.numpy] = "being compiled"
            trampoline = _trampoline()
            reason = ""
            if way_wanted() == "numpy":
                reason = "MOTORCADE_PROGRAMS says so"
            elif trampoline is None:
                reason = "the library was installed without compiled code"
            elif len(self._plain.nodes) > LONGEST_COMPILED:
                reason = f"more than {LONGEST_COMPILED} operations"
            if reason or trampoline is None:
                self._refused(precision, reason)
                return
            try:
                compiler = find_compiler(trampoline.processor_level())
                source = c_source(self._plain, precision)
                folder = cache_folder()
                key = cache_key(source, compiler.identity)
                path = cached_library(folder, key)
                if path is not None and self._load(precision, str(path)):
                    return
            except (CompileError, ValueError, OSError) as failed:
                self._refused(precision, str(failed))
                return

            def compile_it() -> None:
                try:
                    path = keep_library(folder, key, compiler.library(source, folder))
                except (CompileError, OSError) as failed:
                    self._refused(precision, str(failed))
                    return
                with self._lock:
                    self._load(precision, str(path))

            thread = threading.Thread(target=compile_it, name=f"compile {self._name}")
            self._threads[precision.numpy] = thread
            thread.start()

    def _load(self, precision: Precision, path: str) -> bool:
        """Call a library from now on; whether it could be loaded."""
        self._libraries[precision.numpy] = path
        try:
            self._bind()
        except RuntimeError as failed:
            del self._libraries[precision.numpy]
            self._refused(precision, str(failed))
            return False
        self._state[precision.numpy] = "compiled"
        _log.debug("%s: %s runs as compiled C, %s", self._name, precision.numpy, path)
        return True

    def _refused(self, precision: Precision, reason: str) -> None:
        self._state[precision.numpy] = reason
        _log.info("%s: %s runs as NumPy: %s", self._name, precision.numpy, reason)


def precision_of(values: Sequence[Any]) -> Precision:
    """The precision that arguments are computed in: float32 where all typed ones are."""
    kinds = {one.dtype for one in values if isinstance(one, np.ndarray | np.generic)}
    return SINGLE if kinds == {np.dtype(np.float32)} else DOUBLE


def _trampoline() -> Any:
    """The module that calls compiled programs; None where the library has no compiled code."""
    try:
        from motorcade.ga.codegen.runtime import _trampoline as found
    except ImportError:
        return None
    return found
