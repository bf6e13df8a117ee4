"""The embedded recording of `motorcade demo`: rendered once, then read like any other."""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path

from motorcade.replays.engine.progress import track
from motorcade.replays.engine.provenance import code_digest
from motorcade.replays.synthetic_room import write_recording

MARKER = ".rendered"


def ensure_demo_recording(folder: Path, seed: int) -> Path:
    """Render the synthetic room into `folder` unless this code has done so with this seed.

    The folder appears complete or not at all. Raises `render.RenderUnavailable` without OpenGL,
    and FileExistsError where `folder` holds something else.
    """
    made_from = f"{code_digest(write_recording)} seed {seed}\n"
    marker = folder / MARKER
    if marker.is_file() and marker.read_text(encoding="utf-8") == made_from:
        return folder
    if folder.exists() and not marker.is_file():
        raise FileExistsError(
            errno.EEXIST,
            "is not a recording that this demo made; choose another --out",
            str(folder),
        )
    folder.parent.mkdir(parents=True, exist_ok=True)
    building = folder.with_name(f".{folder.name}.{os.getpid()}")
    shutil.rmtree(building, ignore_errors=True)
    write_recording(building, seed=seed, progress=track)
    (building / MARKER).write_text(made_from, encoding="utf-8")
    shutil.rmtree(folder, ignore_errors=True)
    building.rename(folder)
    return folder
