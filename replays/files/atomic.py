"""Files that appear whole or not at all, so that no reader and no killed run meets half of one."""

from __future__ import annotations

import contextlib
import csv
import io
import os
import re
import secrets
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

__all__ = ["copy_file", "is_alive", "sweep_unfinished", "write_bytes", "write_csv"]

_UNFINISHED = re.compile(r"\..+\.(?P<pid>[0-9]+)-[0-9a-f]{12}")


def write_bytes(path: Path, data: bytes) -> None:
    """Write `data` over `path`; OSError naming `path`, which then stays as it was."""
    with _replacing(path) as building:
        building.write_bytes(data)


def copy_file(source: Path, path: Path) -> None:
    """Copy a file over `path`; OSError naming `path` where that fails."""
    with _replacing(path) as building:
        shutil.copyfile(source, building)


def sweep_unfinished(folder: Path) -> None:
    """Remove what killed processes left half-written in `folder`; those that live keep theirs."""
    for building in folder.iterdir():
        ours = _UNFINISHED.fullmatch(building.name)
        if ours is not None and not is_alive(int(ours["pid"])):
            building.unlink(missing_ok=True)


def is_alive(pid: int) -> bool:
    """Whether a process of this number runs on this machine."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


@contextmanager
def _replacing(path: Path) -> Iterator[Path]:
    building = path.with_name(f".{path.name}.{os.getpid()}-{secrets.token_hex(6)}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield building
        with building.open("rb") as file:
            os.fsync(file.fileno())
        building.replace(path)
    except OSError as fault:
        with contextlib.suppress(OSError):
            building.unlink()
        raise OSError(fault.errno, f"cannot be written: {fault.strerror}", str(path)) from fault


def write_csv(path: Path, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table, whole or not at all; None is an empty cell.

    Raises:
        OSError: the file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    write_bytes(path, text.getvalue().encode())
