"""An act in a child of its own, which may neither wait without end nor fill the memory."""

from __future__ import annotations

import json
import os
import resource
import signal
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

__all__ = ["Outcome", "in_child"]

SECONDS = 60
MEMORY_BYTES = 1 << 30


@dataclass(frozen=True)
class Outcome:
    """How an act ended.

    Fields:
        kind: "value", or the names of the error's class and of those that it stems from.
        text: what was given or raised, or what a command told.
        ended: False where it was killed, as it took too long.
    """

    kind: tuple[str, ...]
    text: str
    ended: bool = True


def in_child(act: Callable[[], object]) -> Outcome:
    """Do it in a fork, within a minute and a GiB more than there is now."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reading)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(SECONDS)
            most = _pages() * resource.getpagesize() + MEMORY_BYTES
            resource.setrlimit(resource.RLIMIT_AS, (most, most))
            os.write(writing, json.dumps(_done(act)).encode()[:60_000])
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as stream:
        told = stream.read()
    os.waitpid(child, 0)
    if not told:
        return Outcome((), f"killed after {SECONDS} s, or crashed", ended=False)
    kind, text = json.loads(told)
    return Outcome(tuple(kind), text)


def _done(act: Callable[[], object]) -> tuple[list[str], str]:
    heard = StringIO()
    try:
        with redirect_stderr(heard), redirect_stdout(heard):
            value = act()
    except BaseException as fault:
        return [one.__name__ for one in type(fault).__mro__], str(fault)[:10_000]
    return ["value"], f"{value!r:.1000}\n{heard.getvalue()[:10_000]}"


def _pages() -> int:
    return int(Path("/proc/self/statm").read_text().split()[0])
