"""Locks on files and folders (`flock`), which the system ends together with the process.

Not every file system has them, and Windows has none on folders; whoever asks is told, and must do
without.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform != "win32":
    import fcntl

WAIT_S = 10.0
"""Folders are locked for no longer than it takes to look at one thing and rename it; whoever keeps
one for longer, such as `flock FOLDER motorcade …`, is not of this program."""

_AGAIN_S = 0.002


def try_lock(file: int) -> bool | None:
    """Whether the lock of an open file is ours now; None where the system has no locks."""
    if sys.platform == "win32":
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


@contextmanager
def locked(folder: Path, wait_s: float = WAIT_S) -> Iterator[bool]:
    """Keep others that ask for it out of a folder within the block, as far as that is possible.

    Gives whether it is locked: False where the system has no locks, or another has kept it for
    `wait_s` seconds.

    Raises:
        OSError: the folder cannot be opened.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.ga.locks import locked
    >>> with tempfile.TemporaryDirectory() as folder, locked(Path(folder)) as ours:
    ...     ours
    True
    """
    if sys.platform == "win32":
        folder.stat()
        yield False
        return
    file = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        end = time.monotonic() + wait_s
        while (ours := try_lock(file)) is False and time.monotonic() < end:
            time.sleep(_AGAIN_S)
        yield ours is True
    finally:
        os.close(file)
