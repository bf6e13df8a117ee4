"""Folders in which something is built before it takes its name, locked while their builder lives.

Such a place, `.unfinished-…`, lies beside what is being built and holds two files of its own. Its
builder keeps an exclusive `flock` on `lock` until it is done; the system ends the lock together
with the process, also where that is killed or the power fails. `mark` says whose it is: host, boot,
PID namespace and process. What the dead leave is removed by the next run, where that is sure:

| the builder ran | lock | its place |
|---|---|---|
| since this boot of this machine, in any container | held | stays |
| | free | is removed |
| | the file system has none | is removed if the namespace is ours and the process is gone |
| on another host, or before this boot | held | stays |
| | free | is removed where hosts see each other's locks, else stays, with a warning |

Numbers of processes alone say nothing: those of another container or host are not ours.

Places are begun, and looked at, while the folder that they lie in is locked. So one without a mark
is of the dead too: its builder was killed as it began, or as it removed the place.

Not every file system has locks, and Windows has none on folders; whoever asks is told, and
must do without.
"""

from __future__ import annotations

import json
import logging
import os
import platform
import re
import secrets
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

from motorcade.ga.files import off_record, read_bounded

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
    >>> from motorcade.ga.unfinished import locked
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


log = logging.getLogger("motorcade.unfinished")

NAME = re.compile(r"\.unfinished-[0-9a-f]{16}")
"""Nothing of another name is ever removed."""
MOUNTS = Path("/proc/self/mountinfo")
MARKED_WITHIN_S = 3600.0
"""Where folders cannot be locked, a place without a mark is one whose builder has just begun, or,
after so long, died there."""
BEGUN_WITHIN_S = 0.2
"""To begin a place takes below a millisecond; `ga.locks` says who keeps a folder for longer."""

MARK_BYTES = 4096

_OF_ONE_HOST = {"ext2", "ext3", "ext4", "xfs", "btrfs", "f2fs", "zfs", "overlay", "tmpfs"}
_LOCKED_BY_SERVERS = {"nfs", "nfs4", "cifs", "smb3", "ceph", "gfs2", "ocfs2", "gpfs", "lustre"}
_LOCKS_HELD_BACK = {"nolock", "local_lock=all", "local_lock=flock", "localflock", "nobrl"}
"""Options of mounts that keep locks from the server, and so from other hosts."""


@contextmanager
def unfinished(folder: Path) -> Iterator[Path]:
    """A place in `folder` to build in, under any names but `lock` and `mark`.

    Rename what is done out of it; what is left there at the end of the block is removed. Whoever
    first builds in a folder removes what dead processes left in it.

    Raises:
        OSError: nothing can be written to `folder`, which is made where it is missing.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.ga.unfinished import unfinished
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with unfinished(Path(folder)) as place:
    ...         written = (place / "poses").write_text("0 0 0 1")
    ...         renamed = (place / "poses").rename(Path(folder) / "poses.txt")
    ...     [path.name for path in Path(folder).iterdir()]
    ['poses.txt']
    """
    _remove_once(folder.absolute())
    place = folder / f".unfinished-{secrets.token_hex(8)}"
    try:
        lock = _begin(place)
        try:
            yield place
        finally:
            os.close(lock)  # before it is deleted: NFS keeps the folder of an open file
    finally:
        shutil.rmtree(place, ignore_errors=True)


def remove_unfinished(folder: Path) -> None:
    """Remove from `folder` what is surely nobody's any more; see the table of this module."""
    if not (places := _places(folder)):
        return
    try:
        with locked(folder, BEGUN_WITHIN_S) as ours:
            none_begins = ours and _locks_reach_other_hosts(folder)
            gone = [place for place in places if _is_abandoned(place, none_begins)]
    except OSError:  # whoever cannot look into the folder removes nothing from it
        return
    for place in gone:
        shutil.rmtree(place, ignore_errors=True)


def _places(folder: Path) -> list[Path]:
    return [path for path in folder.glob(".unfinished-*") if NAME.fullmatch(path.name)]


@cache
def _remove_once(folder: Path) -> None:
    """So that no command leaves what an earlier one left, though most write to a folder often."""
    remove_unfinished(folder)


@dataclass(frozen=True)
class _Mark:
    """Whose a place is; None for what the system does not tell."""

    host: str
    boot: str | None
    pid_namespace: int | None
    process: int
    locked: bool

    @staticmethod
    def own(locked: bool) -> _Mark:
        """That of this process."""
        boot, namespace = Path("/proc/sys/kernel/random/boot_id"), Path("/proc/self/ns/pid")
        return _Mark(
            platform.node(),
            boot.read_text().strip() if boot.exists() else None,
            namespace.stat().st_ino if namespace.exists() else None,
            os.getpid(),
            locked,
        )

    @staticmethod
    def read(place: Path) -> _Mark | None:
        """That of a place; None where none is written yet, or it is not one."""
        try:
            with off_record():
                document = json.loads(read_bounded(place / "mark", MARK_BYTES))
            boot, namespace = document["boot"], document["pid_namespace"]
            return _Mark(
                str(document["host"]),
                None if boot is None else str(boot),
                None if namespace is None else int(namespace),
                int(document["process"]),
                bool(document["locked"]),
            )
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
            return None


def _begin(place: Path) -> int:
    """Make, lock, then mark a place; gives the open lock. OSError names the folder it lies in."""
    try:
        if not place.parent.exists():
            place.parent.mkdir(parents=True, exist_ok=True)
        with locked(place.parent, BEGUN_WITHIN_S):
            place.mkdir()
            lock = os.open(place / "lock", os.O_RDWR | os.O_CREAT, 0o666)
            try:
                mark = _Mark.own(locked=try_lock(lock) is True)
                (place / "mark").write_text(json.dumps(asdict(mark)) + "\n")
            except OSError:
                os.close(lock)
                raise
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(place.parent)) from fault
    return lock


def _is_abandoned(place: Path, none_begins: bool) -> bool:
    """Whether the builder of a place is surely gone, and whether none can be about to begin one."""
    mark = _Mark.read(place)
    try:
        begun_s = time.time() - place.stat().st_mtime
        if mark is None and not none_begins and begun_s < MARKED_WITHIN_S:
            return False
        lock = os.open(place / "lock", os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))
    except FileNotFoundError:
        return True  # its builder, or another run, has begun to remove it
    except OSError:
        return False
    try:
        taken = try_lock(lock)
    finally:
        os.close(lock)
    if mark is None or taken is False:
        return taken is not False
    ours = _Mark.own(locked=False)
    of_this_boot = mark.boot is not None and mark.boot == ours.boot
    if taken and mark.locked and (of_this_boot or _locks_reach_other_hosts(place)):
        return True
    if of_this_boot and mark.pid_namespace == ours.pid_namespace:
        return not _runs(mark.process)
    log.warning(
        "%s: left by process %d of %r, which may still run; delete it when it does not",
        place,
        mark.process,
        mark.host,
    )
    return False


def _runs(process: int) -> bool:
    """Whether a process of this number runs in our PID namespace."""
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def _locks_reach_other_hosts(folder: Path) -> bool:
    """Whether no other host has the folder's file system, or all meet each other's locks on it."""
    here, kind, options = folder.resolve(), "", set[str]()
    longest = 0
    for line in MOUNTS.read_text().splitlines() if MOUNTS.exists() else ():
        mounted, _, source = line.partition(" - ")
        point = Path(re.sub(r"\\([0-7]{3})", lambda code: chr(int(code[1], 8)), mounted.split()[4]))
        if here.is_relative_to(point) and len(point.parts) >= longest:
            longest, kind = len(point.parts), source.split()[0]
            options = set(source.split()[-1].split(","))
    return kind in _OF_ONE_HOST | _LOCKED_BY_SERVERS and not options & _LOCKS_HELD_BACK
