"""The machine's C compiler: which it is, how it is called, and shared libraries that it makes.

The environment variable CC says which one; otherwise it is the first of cc, gcc and clang that is
found. It is given a file and options as a list, never a line for a shell.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
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

        Raises:
            CompileError: it could not be run, refused the source, or took too long.
        """
        try:
            with tempfile.TemporaryDirectory(dir=folder, prefix="compiling-") as own:
                given, made = Path(own) / "program.c", Path(own) / "program.so"
                given.write_text(source, encoding="utf-8")
                command = [*self.command, str(given), "-o", str(made), "-lm"]
                done = subprocess.run(
                    command, capture_output=True, text=True, errors="replace",
                    stdin=subprocess.DEVNULL, timeout=LONGEST_S, check=False,
                )  # fmt: skip
                if done.returncode == 0:
                    return made.read_bytes()
        except subprocess.TimeoutExpired as late:
            raise CompileError(f"{self.command[0]} took more than {LONGEST_S:g} s") from late
        except OSError as failed:
            raise CompileError(f"{self.command[0]}: {failed}") from failed
        said = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr)
        raise CompileError(f"{self.command[0]} ended with {done.returncode}: {said.strip()[:200]}")


def find_compiler(processor_level: int) -> Compiler:
    """The compiler of this machine, for its processor.

    Raises:
        CompileError: there is none.
    """
    wanted = shlex.split(os.environ.get("CC", ""))
    names = wanted[:1] or list(_COMPILERS)
    found = next((path for name in names if (path := shutil.which(name))), None)
    if found is None:
        raise CompileError(f"no C compiler here: looked for {', '.join(names)}")
    command = (found, *wanted[1:], *_OPTIONS, *_LEVELS.get(processor_level, ()))
    real = Path(found).resolve()
    about = real.stat()
    return Compiler(command, f"{command} {real} {about.st_size} {about.st_mtime_ns}")
