"""Files that appear whole or not at all, so that no reader and no killed run meets half of one."""

from __future__ import annotations

import csv
import io
import os
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from motorcade.ga.unfinished import unfinished


def write_bytes(path: Path, data: bytes) -> None:
    """Write `data` over `path`; OSError naming `path`, which then stays as it was."""
    with replacing(path) as building:
        building.write_bytes(data)


def copy_file(source: Path, path: Path) -> None:
    """Copy a file over `path`; OSError naming `path` where that fails."""
    with replacing(path) as building:
        shutil.copyfile(source, building)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A file to write within the block, which then takes the place of `path`, all of it or nothing.

    Raises:
        OSError: a file that cannot be written, named by `path`, which then stays as it was.
    """
    try:
        with unfinished(path.parent) as place:
            building = place / f"content{path.suffix}"
            yield building
            with building.open("rb") as file:
                os.fsync(file.fileno())
            building.replace(path)
    except OSError as fault:
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
